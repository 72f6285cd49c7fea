"""Warnings of a model reach a Python user, and one at the shell once."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import arael
from arael.cli.main import run

SPARE = """
struct Spare { x: real }
root Fit {
    param a: real
    constraint c { a }
}
"""


@pytest.fixture
def spare(tmp_path: Path) -> Path:
    path = tmp_path / "spare.arael"
    path.write_text(SPARE, encoding="utf-8")
    (tmp_path / "spare.json").write_text('{"a": 1}', encoding="utf-8")
    return path


def test_load_issues_them_as_python_warnings(spare: Path) -> None:
    for _ in range(2):  # derived anew, then found in the cache
        with pytest.warns(arael.ModelWarning) as issued:
            arael.load(spare, interpret=True)
        (one,) = issued
        text = str(one.message)
        assert text.startswith("warning[W0401]: struct `Spare` is never used\n --> ")
        assert text.endswith("or remove it") and f"{spare}:2:8" in text
        assert one.filename == __file__


def test_python_shows_one_of_them_once_for_a_place(spare: Path) -> None:
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("default")
        for _ in range(3):
            arael.load(spare, interpret=True)
    assert len(issued) == 1


@pytest.mark.parametrize(
    "command", [("solve", "--interpret"), ("check",), ("diagnose",)], ids=lambda c: c[0]
)
@pytest.mark.filterwarnings("default")
def test_commands_print_them_once(
    spare: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    name, *options = command
    run([name, str(spare), str(spare.with_suffix(".json")), *options])
    printed = capsys.readouterr().err
    assert printed.count("W0401") == 1
    assert printed.startswith("warning[W0401]: struct `Spare`")
    assert __file__ not in printed and "ModelWarning" not in printed
