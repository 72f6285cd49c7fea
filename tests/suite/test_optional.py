"""Reasons of skips, and the README's promise that no optional part is needed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import optional, public_data

ROOT = Path(__file__).parents[2]


def test_an_installed_part_is_no_reason_to_skip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(optional.PARTS, "json", optional.Part("json", "pip install json"))
    assert optional.needs("json").args == (False,)
    assert optional.require("json").__name__ == "json"


def test_a_missing_part_is_named_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(optional.PARTS, "none", optional.Part("no_such_module", "pip install it"))
    mark = optional.needs("none")
    assert mark.args == (True,)
    assert mark.kwargs == {"reason": "needs none: pip install it"}
    with pytest.raises(pytest.skip.Exception, match="needs none: pip install it"):
        optional.require("none")


def test_only_cholmod_is_optional_among_the_solvers() -> None:
    plain, cholmod = optional.solvers(["dense", "cholmod"])
    assert plain == "dense"
    assert cholmod.values == ("cholmod",)
    assert len(cholmod.marks) == 1


def test_missing_data_is_named_with_the_variable_to_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(public_data, "FOLDER", tmp_path)
    with pytest.raises(pytest.skip.Exception, match=r"needs public data: set ARAEL_DATA .*x\.g2o"):
        public_data.public("x.g2o")


@pytest.mark.parametrize("word", ["sksparse", "cholmod", "numba"])
def test_tests_import_optional_parts_by_way_of_this_module(word: str) -> None:
    """A plain import fails where the part is missing."""
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in (ROOT / "tests").rglob("test_*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.strip().startswith((f"import {word}", f"from {word}", f"from sksparse.{word}"))
    ]
    assert found == []
