"""Inner iterations: where a bundle's first step fails, points are solved again at each trial."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.config import LmConfig
from arael.model import Model
from arael.runtime.levenberg.separable import inner_steps
from arael.runtime.solve import separable_for

BUNDLE = """
struct Camera {
    param at: vec2
    param th: real
    constraint prior { [(at.x - k) / 0.1, at.y / 0.1, th / 0.01] }
    k: real
}
struct Point { param pos: vec2 BOUND }
struct Observation {
    camera: ref Camera in root.cameras
    point:  ref Point in root.points
    pixel:  real
    constraint seen GUARD LOSS {
        let d = point.pos - camera.at
        let x = cos(camera.th) * d.x + sin(camera.th) * d.y
        let y = cos(camera.th) * d.y - sin(camera.th) * d.x
        500 * x / y - pixel
    }
}
root Bundle {
    cameras: list of Camera
    points: list of Point
    observations: list of Observation
    marginalize points
}
"""
PAIRS = """
root Chain {
    cameras: list of Camera
    points: list of Point
    pairs: list of Pair
}
struct Camera { param x: real
    constraint prior { x } }
struct Point { param x: real
    constraint prior { x - 1 } }
struct Pair {
    camera: ref Camera in root.cameras
    a: ref Point in root.points
    b: ref Point in root.points
    constraint both { [a.x - camera.x, b.x - 2 * camera.x] }
}
"""


def loaded(
    folder: Path, precision: Any = "f64", bound: str = "", guard: str = "", loss: str = ""
) -> type[Model]:
    text = BUNDLE.replace("BOUND", bound).replace("GUARD", guard).replace("LOSS", loss)
    path = folder / "bundle.arael"
    path.write_text(text)
    return arael.load(path, precision=precision, interpret=True)


def bundle(kind: type[Model], seed: int = 0, cameras: int = 6, points: int = 40) -> Model:
    """Cameras on a line, and points before them of which every fourth is 100 times as far."""
    rng = np.random.default_rng(seed)
    model = kind()
    x = np.linspace(-1, 1, cameras)
    at = np.column_stack([rng.uniform(-1, 1, points), rng.uniform(2, 4, points)])
    at[::4] *= 100
    model.cameras.extend(
        k=x, th=0.03 * rng.normal(size=cameras),
        at=np.column_stack([x, 0 * x]) + 0.1 * rng.normal(size=(cameras, 2)),
    )  # fmt: skip
    model.points.extend(pos=at * rng.uniform(0.3, 1.5, (points, 1)))
    c, p = (part.ravel() for part in np.meshgrid(range(cameras), range(points), indexing="ij"))
    pixel = 500 * (at[p, 0] - x[c]) / at[p, 1] + 0.5 * rng.normal(size=len(c))
    model.observations.extend(
        camera=[model.cameras[int(k)] for k in c], point=[model.points[int(k)] for k in p],
        pixel=pixel,
    )  # fmt: skip
    return model


def took_inner(result: Any) -> bool:
    """Whether damped steps took the place of the dogleg, which has a radius."""
    radius = result.history["radius"]
    return bool(np.isfinite(radius[0]) and np.isnan(radius[-1]))


def test_bundles_with_far_points_end(tmp_path: Path) -> None:
    kind = loaded(tmp_path)
    attempts = {"auto": 0, "dogleg": 0}
    for seed in range(6):
        found = {s: bundle(kind, seed).solve(strategy=s, solver="schur") for s in attempts}
        assert found["auto"].converged
        assert took_inner(found["auto"])
        assert not took_inner(found["dogleg"])
        assert found["auto"].end_cost <= found["dogleg"].end_cost * (1 + 1e-6)
        for name, result in found.items():
            attempts[name] += result.iterations
    assert attempts["auto"] < 0.4 * attempts["dogleg"]


def test_costs_fall_with_every_accepted_attempt(tmp_path: Path) -> None:
    model = bundle(loaded(tmp_path), 1)
    result = model.solve(solver="schur")
    history = result.history
    assert took_inner(result)
    taken = history["accepted"] != 0
    assert (history["trial_cost"][taken] < history["cost"][taken]).all()
    assert model.cost() == pytest.approx(result.end_cost, rel=1e-12)


def test_a_good_start_keeps_the_dogleg(tmp_path: Path) -> None:
    model = bundle(loaded(tmp_path))
    model.solve(solver="schur")
    again = model.solve(solver="schur")
    assert np.isfinite(again.history["radius"]).all()


def test_single_precision(tmp_path: Path) -> None:
    (tmp_path / "f64").mkdir()
    double, single = loaded(tmp_path / "f64"), loaded(tmp_path, "f32")
    taken = 0
    for seed in range(3):
        expected = bundle(double, seed).solve(solver="schur")
        result = bundle(single, seed).solve(solver="schur")
        taken += took_inner(result)
        assert result.converged
        assert result.end_cost <= expected.end_cost * (1 + 1e-3)
    assert taken


@pytest.mark.parametrize("loss", ["huber(3)", "cauchy(3)"])
def test_robust_losses(tmp_path: Path, loss: str) -> None:
    kind = loaded(tmp_path, loss=f"loss {loss}")
    result = bundle(kind, 1).solve(solver="schur")
    other = bundle(kind, 1).solve(solver="schur", strategy="dogleg", max_iters=1000)
    assert result.converged
    assert result.end_cost <= other.end_cost * (1 + 1e-6)


def test_any_number_of_threads_gives_the_same_bits(tmp_path: Path) -> None:
    kind = loaded(tmp_path)
    one, two = (bundle(kind, 1, points=300).solve(solver="schur", num_threads=n) for n in (1, 2))
    assert took_inner(one)
    assert one.history["cost"].tolist() == two.history["cost"].tolist()


@pytest.mark.parametrize(
    "part", [{"bound": "in -1e6 .. 1e6"}, {"guard": "when point.pos.y > -1e6"}]
)
def test_bounds_and_guards_over_parameters_keep_the_dogleg(
    tmp_path: Path, part: dict[str, str]
) -> None:
    result = bundle(loaded(tmp_path, **part), 1).solve(solver="schur")
    assert np.isfinite(result.history["radius"]).all()


@pytest.mark.parametrize(
    "settings",
    [
        {"strategy": "dogleg"},
        {"ending": "small_steps"},
        {"min_diagonal": 1e-6},
        {"initial_lambda": 1e-3},
    ],
)
def test_only_the_automatic_strategy_takes_them(tmp_path: Path, settings: dict[str, Any]) -> None:
    problem = bundle(loaded(tmp_path))._problem()
    solver = problem.make_solver("schur")
    assert separable_for(problem, LmConfig.of(), solver, None) is not None
    assert separable_for(problem, LmConfig.of(**settings), solver, None) is None
    assert separable_for(problem, LmConfig.of(), problem.make_solver("dense"), None) is None


def test_none_where_functions_are_called_before_linearisations(tmp_path: Path) -> None:
    """Inner iterations linearise at states that are only tried, for which nothing is called."""
    model = bundle(loaded(tmp_path))
    called = []
    model.before_linearisation(lambda at: called.append(at.copy()), [model.cameras.at])
    problem = model._problem()
    assert inner_steps(problem, problem.make_solver("schur"), 1e-12) is None
    result = model.solve(solver="schur")
    assert not took_inner(result)
    # Once for each accepted state.
    assert len(called) == 1 + int(result.history["accepted"].sum())


def test_none_where_an_instance_reads_two_eliminated_entities(tmp_path: Path) -> None:
    path = tmp_path / "pairs.arael"
    path.write_text(PAIRS)
    model = arael.load(path, interpret=True)()
    model.cameras.extend(x=[0.0, 1.0])
    model.points.extend(x=np.arange(6.0))
    model.pairs.extend(
        camera=[model.cameras[k % 2] for k in range(5)],
        a=[model.points[k] for k in range(5)], b=[model.points[k + 1] for k in range(5)],
    )  # fmt: skip
    problem = model._problem()
    solver = problem.make_solver("schur", eliminate=["points"])
    assert solver.plan["eliminated"] == 6
    assert inner_steps(problem, solver, 1e-12) is None
