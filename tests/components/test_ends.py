"""Independent problems in one model end as each does when it is solved alone.

The oracle is the same model with one of the problems in it: it has one component, and goes through
the loop for one component.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from arael.runtime.assembly import shares
from arael.runtime.linear import narrowing
from arael.solving import problem_of
from tests.components.problems import (
    COMPILED_OR_NOT,
    IN_BOTH,
    Load,
    Problem,
    compare,
    of,
    problems,
)


@pytest.mark.sweep(slow=("0-False-f32", "1-False-f32", "0-True-f32", "1-True-f32"))
@IN_BOTH
@COMPILED_OR_NOT
@pytest.mark.parametrize("seed", range(2))
def test_all_end_as_alone(load: Load, precision: str, interpret: bool, seed: int) -> None:
    result = compare(load(precision, interpret), problems(seed), solver="sparse")
    assert result.components is not None
    # What has no minimum that a step could reach leaves the others as they are.
    stuck = [one.status for one in result.components if one.name == "gates[0]"]
    assert stuck == ["stalled"] and not result.converged
    assert result.components.converged.mean() > 0.7


@pytest.mark.parametrize(
    ("precision", "interpret", "solver"),
    [
        ("f64", False, "sparse"),
        ("f32", False, "sparse"),
        ("f64", True, "band"),
        ("f64", False, "schur"),
        ("f64", False, "dense"),
    ],
)
def test_what_remains_ends_as_alone(
    load: Load, narrowed: list[int], precision: str, interpret: bool, solver: str
) -> None:
    # Rings may run off to an infinite radius, where rounding decides about the place.
    chosen = [one for one in problems(0, 5) if one[0] != "rings"]
    # One component alone may take inner iterations where it is solved by `schur`.
    compare(load(precision, interpret), chosen, solver=solver, strategy="dogleg")
    assert len(narrowed) > 5
    # Ever less; solves of one component alone do not narrow.
    assert (np.diff(narrowed) < 0).all() and narrowed[-1] <= 3


def test_what_remains_under_damping_ends_as_alone(load: Load, narrowed: list[int]) -> None:
    chosen = [one for one in problems(3) if one[0] not in ("edges", "gates")]
    tolerant = {"strategy": "damped", "damping": "nielsen", "parameter_tolerance": 1e-300}
    compare(load("f64", False), chosen, solver="sparse", **tolerant)
    assert narrowed


def test_a_failed_factorisation_of_what_remains(load: Load, narrowed: list[int]) -> None:
    """Which component it is, is found by the scalar of the whole."""
    singular: list[tuple[str, Problem]] = [
        ("pairs", lambda model, k=k: model.pairs.append(x=0.0, y=0.0, k=k)) for k in (1.0, 2.0, 3.0)
    ]
    hard = [one for one in problems(4, 2) if one[0] in ("valleys", "lines")]
    chosen = singular[:1] + hard + singular[1:]
    settings = {"solver": "sparse", "strategy": "dogleg", "lambda_floor": 0.0}
    compare(load("f64", False), chosen, **settings)
    assert narrowed


def test_a_narrowed_solve_leaves_the_problem_whole(load: Load, narrowed: list[int]) -> None:
    """The next solve of the session, from the same start, has the same bits."""
    chosen = [one for one in problems(12, 6) if one[0] in ("boxes", "valleys", "edges")]
    model = of(load("f64", False), chosen)
    model.boxes[0].y.optimize = False  # held scalars, beside bounds
    columns = [model.boxes.x, model.boxes.y, model.valleys.x, model.valleys.y, model.edges.x]
    start = [column.value.copy() for column in columns]
    first = model.solve(solver="sparse")
    steps = len(narrowed)
    for column, value in zip(columns, start, strict=True):
        column.value[:] = value
    again = model.solve(solver="sparse")
    assert steps > 2 and len(narrowed) == 2 * steps
    np.testing.assert_array_equal(first.x, again.x)
    np.testing.assert_array_equal(first.components.end_cost, again.components.end_cost)
    # At the end nothing that was passed over is out of date.
    assert again.end_cost == pytest.approx(problem_of(model).cost(), rel=1e-12)


def test_threads_change_no_bit_of_what_remains(
    load: Load, narrowed: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shares, "GRAIN", 30.0)
    kind, chosen = load("f64", False), problems(6, 12)
    one, two = (of(kind, chosen).solve(solver="sparse", num_threads=n) for n in (1, 2))
    assert narrowed
    np.testing.assert_array_equal(one.x, two.x)
    np.testing.assert_array_equal(one.components.end_cost, two.components.end_cost)


def test_a_small_problem_is_not_narrowed(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would take longer than what is passed over in vain."""
    monkeypatch.setattr(narrowing, "remaining_solver", None)
    assert of(load("f64", False), problems(2, 2)).solve(solver="sparse").components is not None


def test_an_error_while_narrowing_is_raised(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*args: Any) -> None:
        raise MemoryError("none left")

    monkeypatch.setattr(narrowing, "remaining_solver", failing)
    monkeypatch.setattr(narrowing, "CONSTANT", 0)
    monkeypatch.setattr(narrowing, "MULTIPLE", 0)
    model = of(load("f64", False), problems(2, 2))
    with pytest.raises(MemoryError, match="none left"):
        model.solve(solver="sparse")


@pytest.mark.parametrize("damping", ["gain", "nielsen", "ladder"])
def test_damped_steps_end_as_alone(load: Load, damping: Any) -> None:
    chosen = [one for one in problems(3) if one[0] not in ("edges", "gates")]
    compare(load("f64", False), chosen, solver="band", strategy="damped", damping=damping)


@IN_BOTH
def test_a_failed_factorisation_is_that_of_its_component(load: Load, precision: str) -> None:
    kind = load(precision, False)
    singular: list[tuple[str, Problem]] = [
        ("pairs", lambda model, k=k: model.pairs.append(x=0.0, y=0.0, k=k)) for k in (1.0, 2.0, 3.0)
    ]
    chosen = [one for one in problems(4, 1) if one[0] not in ("edges", "gates")] + singular
    result = compare(kind, chosen, solver="sparse", strategy="dogleg", lambda_floor=0.0)
    failed = result.history[result.history["factored"] == 0]
    assert len(failed) >= 3 and (failed["accepted"] == 0).all()
    assert result.converged


def test_other_solvers_end_the_same(load: Load) -> None:
    kind, chosen = load("f64", False), problems(5)
    first = of(kind, chosen).solve(solver="sparse").components
    for solver in ("dense", "schur", "auto"):
        other = of(kind, chosen).solve(solver=solver).components
        assert (other.status == first.status).all()
        np.testing.assert_allclose(other.end_cost, first.end_cost, 1e-8, 1e-25)


@IN_BOTH
def test_threads_change_no_bit(load: Load, precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shares, "GRAIN", 30.0)
    kind, chosen = load(precision, False), problems(6, 12)
    one, two = (of(kind, chosen).solve(solver="sparse", num_threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.x, two.x)
    for name in ("iterations", "end_cost", "status"):
        np.testing.assert_array_equal(getattr(one.components, name), getattr(two.components, name))
    # Cut into shares, they end as uncut ones.
    monkeypatch.undo()
    whole = of(kind, chosen).solve(solver="sparse").components
    assert (whole.status == one.components.status).all()
    np.testing.assert_allclose(whole.end_cost, one.components.end_cost, 1e-3, 1e-6)


def test_residuals_of_run_time_end_as_alone(load: Load) -> None:
    """Parameters that only the expression machine works on."""
    kind = load("f64", False)
    rng = np.random.default_rng(8)
    starts, targets = rng.uniform(-2, 2, (6, 2)), rng.uniform(0.5, 4, 6).tolist()

    def model(chosen: Iterable[int]) -> Any:
        found = kind()
        for k in chosen:
            row = found.pairs.append(x=starts[k, 0], y=starts[k, 1], k=0.0)
            found.residuals.add(
                f"[10 * (p.y - p.x*p.x), {targets[k]!r} - p.x]", label=f"r{k}", entities={"p": row}
            )
        return found

    # The compiled constraint is there as well: each component has kernels and programs.
    result = model(range(6)).solve(solver="sparse")
    assert len(result.components) == 6
    for k, component in enumerate(result.components):
        alone = model([k]).solve(solver="sparse")
        assert (component.status, component.iterations) == (alone.status, alone.iterations)
        assert component.end_cost == pytest.approx(alone.end_cost, rel=1e-9)
        np.testing.assert_allclose(result.x[2 * k : 2 * k + 2], alone.x, rtol=1e-10)


def epochs(count: int) -> list[tuple[str, Problem]]:
    """Positions on the Earth with six to ten satellites above, started at the Earth's centre."""
    rng = np.random.default_rng(9)
    found: list[tuple[str, Problem]] = []
    for _ in range(count):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        seen = int(rng.integers(6, 11))
        ways = rng.normal(size=(seen, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        ways = np.where((ways @ up)[:, None] < 0, -ways, ways)
        place = 6.371e6 * up
        sats = place + 2.2e7 * ways
        measured = np.linalg.norm(sats - place, axis=1) + rng.normal(0, 5, seen)
        measured += rng.normal() * 3e5

        def add(model: Any, pos: Any = sats, range_: Any = measured) -> None:
            model.epochs.append(pos=[0, 0, 0], clock=0.0).sats.extend(pos=pos, range=range_)

        found.append(("epochs", add))
    return found


def test_a_thousand_epochs_converge(load: Load) -> None:
    kind, chosen = load("f64", False), epochs(1000)
    result = of(kind, chosen).solve()
    assert result.status == "converged" and result.components.converged.all()
    assert result.iterations < 15
    x = np.asarray(result.x).reshape(-1, 4)
    assert (np.abs(np.linalg.norm(x[:, :3], axis=1) - 6.371e6) < 200).all()
    for k in range(0, 1000, 50):
        alone = of(kind, [chosen[k]]).solve()
        # What is left after the fifth is rounding, which depends on how kernels were compiled.
        assert abs(result.components[k].iterations - alone.iterations) <= 1
        np.testing.assert_allclose(x[k], alone.x, rtol=1e-9, atol=1e-3)
