"""Real pose graphs, from the file's start to their known optimum, with every general solver."""

from __future__ import annotations

from pathlib import Path

import pytest

import arael
from tests.optional import require, solvers
from tests.public_data import public

OPTIMA = {
    (2, "M3500"): 137.9130,
    (2, "intel"): 45.0047,
    (2, "kitti_00"): 98.3220,
    (2, "ringCity"): 262.8175,
    (3, "tinyGrid3D"): 18.5194,
    (3, "smallGrid3D"): 1025.3981,
    (3, "parking-garage"): 1.2684,
    (3, "sphere2500"): 1351.2157,
}
SMALL = ("intel", "tinyGrid3D", "smallGrid3D")
"""Graphs that the solvers for full matrices finish in seconds."""

CASES = [
    (n, name, solver)
    for n, name in OPTIMA
    for solver in ("auto", "sparse", "schur", "cholmod", "dense", "band")
    if name in SMALL or solver not in ("dense", "band")
]


@pytest.mark.parametrize(("n", "name", "solver"), CASES)
def test_known_optimum(n: int, name: str, solver: str) -> None:
    if solver == "cholmod":
        require("scikit-sparse")
    graph = arael.load(f"pose_graph_{n}d")()
    graph.read(public(f"pose_graph_{n}d/{name}.g2o"))
    result = graph.solve(solver=solver)
    assert result.status == "converged"
    assert round(result.end_cost, 4) == OPTIMA[n, name]
    if solver != "auto":
        assert result.plan["solver"] == solver


@pytest.mark.parametrize(("n", "name"), OPTIMA)
def test_a_solved_graph_written_as_g2o_has_its_cost(n: int, name: str, tmp_path: Path) -> None:
    model = arael.load(f"pose_graph_{n}d")
    graph = model()
    graph.read(public(f"pose_graph_{n}d/{name}.g2o"))
    cost = graph.solve().end_cost
    graph.write(tmp_path / "solved.g2o")
    again = model()
    again.read(tmp_path / "solved.g2o")
    assert again.cost() == pytest.approx(cost, rel=1e-9)


@pytest.mark.parametrize("solver", solvers(["band", "lapack_band", "sparse", "schur", "cholmod"]))
def test_every_solver_takes_the_same_first_step(solver: str) -> None:
    """Damped steps agree to 1e-8, so the states after one iteration do."""
    states = []
    for name in ("dense", solver):
        graph = arael.load("pose_graph_3d")()
        graph.read(public("pose_graph_3d/smallGrid3D.g2o"))
        graph.solve(solver=name, max_iters=1)
        states.append(graph.poses.t.value.copy())
    dense, state = states
    assert abs(state - dense).max() < 1e-8 * abs(dense).max()


def test_the_held_pose_is_exact_in_covariances() -> None:
    graph = arael.load("pose_graph_3d")()
    graph.read(public("pose_graph_3d/tinyGrid3D.g2o"))
    graph.solve()
    covariance = graph.covariance()
    assert not [name for name in covariance.names if name.startswith("poses[0].")]
    to_first = covariance.relative(graph.poses[3], graph.poses[0])
    assert abs(to_first - covariance.marginal(graph.poses[3])).max() < 1e-12
