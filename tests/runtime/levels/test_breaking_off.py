"""Solves that another thread breaks off, and frames of a drag that end by the clock."""

from __future__ import annotations

from threading import Thread

import numpy as np
from numpy.typing import NDArray

from arael.runtime.compiled import Interruption
from arael.runtime.levels.compiled import Levels, PythonRows
from tests.runtime.levels.systems import chain

Array = NDArray[np.float64]


class Endless:
    """One row without a root; after some evaluations another thread interrupts."""

    def __init__(self, after: int, interruption: Interruption | None = None) -> None:
        self.evaluations, self.after = 0, after
        rows = PythonRows(self._residuals, lambda x: np.array([[-np.exp(-x[0])]]), n=1, m=1)
        self.levels = Levels(rows, step_limit=10_000, interruption=interruption)

    def _residuals(self, x: Array) -> Array:
        self.evaluations += 1
        if self.evaluations == self.after:
            other = Thread(target=self.levels.interrupt)
            other.start()
            other.join()
        return np.array([np.exp(-x[0])])


def test_another_thread_breaks_a_solve_off() -> None:
    endless = Endless(5)
    x = np.zeros(1)
    outcome = endless.levels.solve(x, 1e-300)
    assert outcome.status == "interrupted"
    assert x[0] == 0.0
    assert endless.evaluations == 5


def test_the_solve_after_one_that_was_broken_off_is_not() -> None:
    endless = Endless(5)
    assert endless.levels.solve(np.zeros(1), 1e-300).status == "interrupted"
    assert endless.levels.solve(np.zeros(1), 1e-3).solved


def test_nothing_in_progress_nothing_broken_off() -> None:
    rows, home = chain(3)
    levels = Levels(rows)
    levels.interrupt()
    x = home + 0.01
    assert levels.solve(x).solved


def test_a_shared_interruption_lasts_until_it_is_withdrawn() -> None:
    interruption = Interruption()
    rows, home = chain(3)
    both = [Levels(rows, interruption=interruption) for _ in range(2)]
    both[0].interrupt()
    assert interruption.requested
    for levels in both:
        x = home + 0.01
        assert levels.solve(x).status == "interrupted"
        np.testing.assert_array_equal(x, home + 0.01)
    interruption.withdraw()
    assert all(levels.solve(home + 0.01).solved for levels in both)


def test_what_holds_is_not_broken_off() -> None:
    interruption = Interruption()
    rows, home = chain(3)
    levels = Levels(rows, interruption=interruption)
    levels.interrupt()
    assert levels.solve(home.copy()).solved


def test_a_drag_that_is_broken_off_is_put_back() -> None:
    interruption = Interruption()
    rows, home = chain(20)
    levels = Levels(rows, interruption=interruption)
    levels.interrupt()
    x = home.copy()
    outcome = levels.drag(x, [40, 41], home[40:] + np.array([-3.0, 4.0]), home)
    assert outcome.status == "interrupted"
    np.testing.assert_array_equal(x, home)


def test_frames_that_end_by_the_clock_hold_and_the_next_go_on() -> None:
    rows, home = chain(20)
    target = home[40:] + np.array([-6.0, 7.0])
    whole = home.copy()
    assert Levels(rows).drag(whole, [40, 41], target, home).converged
    levels = Levels(rows)
    x = home.copy()
    gaps, distances = [], []
    for _ in range(30):
        outcome = levels.drag(x, [40, 41], target, home, seconds=0.0)
        assert outcome.solved
        assert np.abs(rows.evaluate(x)).max() <= 1e-10
        gaps.append(outcome.soft)
        distances.append(outcome.distance)
    assert not outcome.converged
    assert gaps[0] > 1.0
    assert gaps[-1] <= 1e-9
    arrived = next(k for k, gap in enumerate(gaps) if gap <= 1e-9)
    assert distances[-1] < distances[arrived]
    assert levels.drag(x, [40, 41], target, home).converged
    np.testing.assert_allclose(x, whole, atol=1e-3)


def test_a_factor_ends_between_its_rows() -> None:
    interruption = Interruption()
    rows, home = chain(200)
    start = home + 0.05 * np.sin(np.arange(len(home)))
    right = start.copy()
    assert Levels(rows).solve(right).solved
    levels = Levels(rows, interruption=interruption)
    for looks in (1, 2, 3, 50, 150, 200):  # rows of the first factor
        interruption.request(looks)
        x = start.copy()
        assert levels.solve(x).status == "interrupted"
        assert interruption.requested
        np.testing.assert_array_equal(x, start)
        interruption.withdraw()
    x = start.copy()
    assert levels.solve(x).solved
    np.testing.assert_array_equal(x, right)


def test_a_drag_ends_within_a_factor() -> None:
    interruption = Interruption()
    rows, home = chain(200)
    target = home[400:] + np.array([-30.0, 40.0])
    right = home.copy()
    Levels(rows).drag(right, [400, 401], target, home)
    levels = Levels(rows, interruption=interruption)
    for looks in (1, 2, 100, 202, 203, 500):
        interruption.request(looks)
        x = home.copy()
        assert levels.drag(x, [400, 401], target, home).status == "interrupted"
        np.testing.assert_array_equal(x, home)
        interruption.withdraw()
    x = home.copy()
    levels.drag(x, [400, 401], target, home)
    np.testing.assert_allclose(x, right, atol=1e-12)
