"""Which of several runs of a benchmark counts on a virtual machine."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from benchmarks import undisturbed as made


def runs(monkeypatch: pytest.MonkeyPatch, *shares: float) -> list[tuple[int, float]]:
    """Runs of one second on two processors, of which the host takes these shares."""
    clock = itertools.count()
    taken = itertools.chain.from_iterable((10.0, 10.0 + 2.0 * one) for one in shares)
    monkeypatch.setattr(made, "_taken", lambda: next(taken))
    monkeypatch.setattr(made.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(made.time, "perf_counter", lambda: float(next(clock)))
    numbers = itertools.count(1)
    return [(one.found, round(one.taken, 6)) for one in made.undisturbed(lambda: next(numbers))]


def test_a_run_that_had_the_processors_counts_and_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    assert runs(monkeypatch, 0.001) == [(1, 0.001)]
    assert runs(monkeypatch, 0.1, 0.03, 0.0, 0.0) == [(1, 0.1), (2, 0.03), (3, 0.0)]


def test_else_the_one_that_was_disturbed_least_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    found = runs(monkeypatch, 0.1, 0.03, 0.2, 0.05, 0.3, 0.0)
    assert found == [(1, 0.1), (3, 0.2), (4, 0.05), (5, 0.3), (2, 0.03)]


def test_what_the_kernel_counts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    stat = tmp_path / "stat"
    stat.write_text("cpu  7649747 91479 467476 5631826 16381 0 26690 11755 0 0\ncpu0 1 2\n")
    monkeypatch.setattr(made, "_STAT", stat)
    monkeypatch.setattr(made.os, "sysconf", {"SC_CLK_TCK": 100}.__getitem__)
    assert made._taken() == pytest.approx(117.55)
    stat.write_text("cpu  7649747 91479\n")
    assert made._taken() == 0.0
    stat.unlink()
    assert made._taken() == 0.0
