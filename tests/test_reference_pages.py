"""Pages that list things list all of them: settings, statuses, solvers, functions, public names."""

from __future__ import annotations

import re
from dataclasses import fields
from itertools import pairwise
from pathlib import Path

import pytest

import arael
from arael import geometry, io, metrics, scenes, sym
from arael.check.builtins import FUNCTIONS
from arael.config import LmConfig
from arael.runtime.linear.auto import SOLVERS
from arael.statuses import CONVERGED, ENDING
from tests.reference_tables import with_tables

DOCS = Path(__file__).parents[1] / "docs"
SOLVING = (DOCS / "solving.md").read_text(encoding="utf-8")
API = {page: page.read_text(encoding="utf-8") for page in sorted((DOCS / "api").glob("*.md"))}
LANGUAGE = (DOCS / "language.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("field", fields(LmConfig), ids=lambda f: f.name)
def test_every_setting_is_listed_with_its_default(field: object) -> None:
    name, default = field.name, field.default  # type: ignore[attr-defined]
    row = re.search(rf"^\| `{name}` \| (\S+) \|", SOLVING, re.MULTILINE)
    assert row is not None, name
    said = row[1]
    if default is None:
        assert said == "none"
    elif isinstance(default, bool):
        assert said == str(default).lower()
    elif isinstance(default, str):
        assert said == default
    else:
        assert float(said) == default


@pytest.mark.parametrize(
    "status",
    sorted(CONVERGED | ENDING | {"max_iterations", "lambda_ceiling", "retry_budget", "stalled"}),
)
def test_every_status_is_explained(status: str) -> None:
    assert f"`{status}`" in SOLVING


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_solver_is_listed(solver: str) -> None:
    assert re.search(rf"^\| `{solver}` \|", SOLVING, re.MULTILINE)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function_of_the_language_is_listed(name: str) -> None:
    assert re.search(rf"\b{name}\b", LANGUAGE), name


@pytest.mark.parametrize("name", sorted(set(arael.__all__) - {"__version__"}))
def test_every_public_name_is_in_the_reference(name: str) -> None:
    assert re.search(rf"^::: arael\.{name}$", "".join(API.values()), re.MULTILINE), name


@pytest.mark.parametrize("package", [geometry, sym, scenes, io, metrics], ids=lambda r: r.__name__)
def test_every_name_of_the_open_packages_is_in_the_reference(package: object) -> None:
    # A package as a whole shows what of it has a docstring; what has none is named beside it.
    text = "".join(API.values())
    whole = f"::: {package.__name__}\n" in text  # type: ignore[attr-defined]
    for name in package.__all__:  # type: ignore[attr-defined]
        described = whole and (
            getattr(getattr(package, name), "__module__", "").startswith("arael.")
            and not getattr(getattr(package, name), "__qualname__", "").startswith("_function")
        )
        assert described or re.search(rf"\b{name}\b", text), name


@pytest.mark.parametrize("page", API, ids=lambda page: page.stem)
def test_the_python_interface_can_be_read_in_the_repository(page: Path, update: bool) -> None:
    made = with_tables(API[page])
    if update:
        page.write_text(made, encoding="utf-8")
    else:
        assert made == API[page], "run pytest --update"


def test_pages_of_the_python_interface_have_names_and_arguments() -> None:
    text = "".join(API.values())
    assert "| `arael.load(model, *, precision=None" in text
    assert "| `Model.solve(" in text


@pytest.mark.parametrize("page", API, ids=lambda page: page.stem)
def test_each_section_of_the_python_interface_has_an_example(page: Path) -> None:
    sections = re.split(r"^## ", API[page], flags=re.MULTILINE)[1:]
    for section in sections:
        before = section.partition("::: ")[0]
        assert "```python\n" in before and "\n```text\n" in before, section.splitlines()[0]
    assert f"](api/{page.name})" in (DOCS / "api.md").read_text(encoding="utf-8")


EXAMPLES = sorted((DOCS.parent / "examples").glob("*/*.png"))


@pytest.mark.parametrize("picture", EXAMPLES, ids=lambda p: p.stem)
def test_every_picture_of_an_example_is_in_the_gallery(picture: Path) -> None:
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert f"**`{picture.parent.name}`**" in page
    assert f"](figures/gallery/{picture.name})" in page
    assert (DOCS / "figures" / "gallery" / picture.name).exists(), "run docs/figures/gallery.py"


def test_the_site_asks_no_other_host() -> None:
    text = (DOCS.parent / "mkdocs.yml").read_text(encoding="utf-8")
    assert "font: false" in text
    assert "repo_url" not in re.sub(r"#.*", "", text), "its numbers come from GitHub with each page"


def test_the_navigation_is_nested_as_it_is_indented() -> None:
    """A page may stand beside other pages of its group, and not between two groups' depths."""
    lines = (DOCS.parent / "mkdocs.yml").read_text().partition("\nnav:\n")[2].splitlines()
    depths = [len(line) - len(line.lstrip()) for line in lines]
    assert all(b <= a or b == a + 4 for a, b in pairwise(depths))
    assert all(lines[k].endswith(":") for k, (a, b) in enumerate(pairwise(depths)) if b > a)


def test_every_page_is_in_the_navigation_once() -> None:
    listed = re.findall(r"- (\S+\.md)$", (DOCS.parent / "mkdocs.yml").read_text(), re.MULTILINE)
    pages = sorted(str(p.relative_to(DOCS)) for p in DOCS.rglob("*.md"))
    assert sorted(listed) == pages, "edit `nav` of mkdocs.yml"
