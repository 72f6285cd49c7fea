"""Notebooks of the problems run, agree with their scripts, and have the models of the examples."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.optional import needs

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "notebooks"
NAMES = sorted(p.stem for p in FOLDER.glob("*.py") if p.stem != "make")


def cells(name: str) -> list[str]:
    """Sources of the cells of the script, without the signs of comments of text."""
    text = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    found = []
    for part in re.split(r"^# %%", text, flags=re.MULTILINE)[1:]:
        kind, _, body = part.partition("\n")
        body = re.sub(r"^# ?", "", body, flags=re.MULTILINE) if "markdown" in kind else body
        found.append(body.strip())
    return found


def test_every_problem_has_a_notebook() -> None:
    pages = {p.stem for p in (ROOT / "docs" / "problems").glob("*.md")}
    assert pages == set(NAMES)
    for name in NAMES:
        page = (ROOT / "docs" / "problems" / f"{name}.md").read_text(encoding="utf-8")
        assert f"](../notebooks/{name}.ipynb)" in page


@pytest.mark.parametrize("name", NAMES)
def test_the_notebook_is_the_script_with_outputs(name: str) -> None:
    notebook = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    assert ["".join(cell["source"]).strip() for cell in notebook["cells"]] == cells(name), (
        "run docs/notebooks/make.py"
    )
    outputs = [out for cell in notebook["cells"] for out in cell.get("outputs", ())]
    assert not any(out["output_type"] == "error" for out in outputs)
    assert sum("image/png" in out.get("data", {}) for out in outputs) == 2


def test_each_model_is_that_of_the_example() -> None:
    known = [
        line.strip()
        for path in (ROOT / "examples").glob("*/*.arael")
        for line in path.read_text(encoding="utf-8").splitlines()
    ]
    for name in NAMES:
        (text,) = re.findall(r"arael\.loads\('''\n(.*?)\n'''\)", "\n".join(cells(name)), re.DOTALL)
        assert [line for line in text.splitlines() if line.strip() not in known] == []


@needs("matplotlib")
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_it_runs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(FOLDER)
    names: dict[str, object] = {}
    exec((FOLDER / f"{name}.py").read_text(encoding="utf-8"), names)
    assert names["result"].converged  # type: ignore[attr-defined]
