"""The cost model of a solve in parts, and the bookkeeping of its benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.chapters import SUITES
from benchmarks.parts import Cell, Model, Stamps, boundary_of, grid, work_in_parts


def cell(parts: int, between: int, largest: int) -> Cell:
    return Cell(parts, 30_000, 10_000, between, largest, 0.1, 0.1, 3e6, 1e6, 5.0, 10.0, 0.0)


def test_the_model_adds_work_of_parts_and_caller_messages_and_bytes() -> None:
    model = Model(message=1e-3, rate=1e8, cores=2)
    assert model.parts_of(cell(4, 100, 50), 0.6, 0.1) == pytest.approx((0.3, 0.1, 0.02, 0.04))
    assert model.parts_of(cell(1, 0, 0), 0.6, 0.1)[0] == pytest.approx(0.6)


@pytest.mark.slow
def test_work_of_the_parts_is_told_from_that_of_the_caller(tmp_path: Path) -> None:
    grid(tmp_path, n=20)
    for divided, caller in work_in_parts("grid", str(tmp_path / "grid.npz")).values():
        assert divided > 0
        assert caller > 0


def test_boundaries_grow_with_parts_on_a_line_and_with_their_root_on_a_grid() -> None:
    found = [cell(2, 100, 50), cell(8, 700, 100)]
    assert boundary_of("loop", found, 1e6, 80) == (7000, 100)
    between, largest = boundary_of("grid", found, 30_000, 4)
    assert between == pytest.approx(2 * 300)
    assert largest == pytest.approx(4 * 300 / 2)


def test_iterations_are_between_accepted_attempts_of_one_solve() -> None:
    clocks = iter([[1.0, 10.0, 20.0], [2.0, 13.0, 21.0]])
    stamps = Stamps(lambda: next(clocks, [9.0, 9.0, 9.0]))
    for accepted in (True, False, True):
        stamps({"accepted": accepted})
    stamps.end()
    assert stamps.processor == 1.0 + 3.0
    stamps.begin()
    stamps({"accepted": True})
    assert len(stamps.gaps) == 1


def test_it_is_a_suite() -> None:
    assert "parts" in SUITES
