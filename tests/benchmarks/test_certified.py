"""The chapter on NIST's certified regressions."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks import certified, nist
from benchmarks.systems import Plan
from tests.public_data import public


def test_digits_of_each_program_stand_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certified, "DATA", public("nist/BoxBOD.dat").parents[1])
    monkeypatch.setattr(nist, "FORMULAS", {"BoxBOD": nist.FORMULAS["BoxBOD"]})
    lines = certified.run(Plan((), sys.executable, (1,), True))
    head, _, row, six, eight = (line for line in lines if line.startswith("|"))
    assert "| set | arael.fit, found | arael.fit, 1 |" in head and "SciPy, 1" in head
    digits = row.split("|")[3].split("/")
    assert float(digits[0]) > 8 and float(digits[1]) > 8
    assert "| at least 6 digits | 1 of 1 | 1 of 1 |" in six and "8 digits" in eight


def test_sets_that_are_not_there_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certified, "DATA", tmp_path)
    lines = certified.run(Plan((), sys.executable, (1,), False))
    assert any("Not there: Bennett5, BoxBOD" in line for line in lines)
