"""Code in documents runs and prints the documented output."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

from arael.compiler import compiler
from arael.compiler.compilation import compile_text
from arael.diagnostics.records import Findings, Source
from arael.syntax.files import read_source
from tests.optional import needs, require

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(
    r"(?:`(?P<file>[\w.-]+\.arael)`:\n\n)?"
    r"^```(?P<language>\w+)\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```$)?",
    re.DOTALL | re.MULTILINE,
)


def pages_with_python() -> list[Path]:
    return [page for page in PAGES if "```python" in page.read_text(encoding="utf-8")]


IMPORTS = {"numba": "numba", "jax": "JAX"}
"""Modules of blocks that run apart, with the other blocks of their section before them."""


def part_of(code: str) -> str:
    """The optional part that a block imports, or an empty string."""
    names = re.findall(r"^import (\w+)", code, re.MULTILINE)
    return next((IMPORTS[name] for name in names if name in IMPORTS), "")


def sections_with_parts() -> list[object]:
    found = []
    for page in pages_with_python():
        for text in re.split(r"^(?=## )", page.read_text(encoding="utf-8"), flags=re.MULTILINE):
            for block in BLOCK.finditer(text):
                part = part_of(block["code"]) if block["language"] == "python" else ""
                if part:
                    name = f"{page.name}-{part}"
                    found.append(pytest.param(text, part, id=name, marks=needs(part)))
    return found


@pytest.mark.parametrize(("text", "part"), sections_with_parts())
def test_python_with_optional_parts(
    text: str, part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block that needs an optional part, after the blocks of its section that need none."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in BLOCK.finditer(text):
        if block["language"] == "arael" and block["file"]:
            (tmp_path / block["file"]).write_text(block["code"], encoding="utf-8")
        if block["language"] != "python" or part_of(block["code"]) not in ("", part):
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(block["code"], part, "exec"), names)
        assert block["printed"] is None or out.getvalue() == block["printed"]


LONG = {"cookbook.md", "from_rust.md", "robust.md"}
"""Pages whose code takes longest: ten to thirty models are compiled."""


def marked(page: Path) -> object:
    return pytest.param(page, marks=pytest.mark.slow) if page.name in LONG else page


@pytest.mark.parametrize(
    "page", [marked(p) for p in pages_with_python()], ids=lambda p: str(p.relative_to(ROOT))
)
def test_python_in_documents(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, update: bool
) -> None:
    """The blocks of a page run one after the other, in one namespace and an empty folder.

    A model whose file the words before it name is written there.
    """
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    text = page.read_text(encoding="utf-8")
    if "import matplotlib" in text:
        require("matplotlib")
    wrong = []
    for block in BLOCK.finditer(text):
        if block["language"] == "arael" and block["file"]:
            (tmp_path / block["file"]).write_text(block["code"], encoding="utf-8")
        if block["language"] != "python" or part_of(block["code"]):
            continue
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(block["code"], str(page), "exec"), names)
        if block["printed"] is not None and out.getvalue() != block["printed"]:
            wrong.append((block.span("printed"), out.getvalue()))
    if update:
        for (start, end), printed in reversed(wrong):
            text = text[:start] + printed + text[end:]
        page.write_text(text, encoding="utf-8")
    else:
        assert [printed for _, printed in wrong] == []


def models() -> list[object]:
    found = []
    for page in PAGES:
        for block in BLOCK.finditer(page.read_text(encoding="utf-8")):
            if block["language"] == "arael" and re.search(r"^root ", block["code"], re.MULTILINE):
                name = f"{page.stem}-{len(found)}"
                found.append(pytest.param(block["code"], id=name))
    return found


@pytest.mark.sweep(4)
@pytest.mark.parametrize("text", models())
def test_models_in_documents_compile(text: str, tmp_path: Path) -> None:
    if text.startswith("import "):  # files are imported by a file
        path = tmp_path / "page.arael"
        path.write_text(text, encoding="utf-8")
        assert not compile_text(read_source(path)).layout.warnings
        return
    findings = Findings()
    model = compiler.types(compiler.syntax(Source("page.arael", text)), findings)
    assert not list(findings)
    assert compiler.derive(model, "page.arael").kernels


def test_documents_have_python() -> None:
    assert ROOT / "README.md" in pages_with_python()


def test_the_readme_is_short_and_begins_with_a_picture() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 150
    assert text.index("![") < 600


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


def test_the_page_of_packages_names_every_package_and_module() -> None:
    page = (ROOT / "arael" / "README.md").read_text(encoding="utf-8")
    packages = {f"{path.parent.name}/" for path in (ROOT / "arael").glob("*/__init__.py")}
    modules = {path.name for path in (ROOT / "arael").glob("[!_]*.py")} - {"version.py"}
    assert set(re.findall(r"`(\w+(?:/|\.py))`", page)) == packages | modules
