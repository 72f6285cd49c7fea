"""The suite `optimum`: what counts as the optimum, what the report says, how a system is run."""

from __future__ import annotations

import json
import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.assembly.scatter_plan import scatter_plan
from arael.runtime.levenberg.compiled import RECORD
from arael.scenes import benchmark_config, make_scene
from benchmarks import demo_seeds, problems
from benchmarks.bundles import write_bal, write_bundle
from benchmarks.optimum import graphs
from benchmarks.optimum.cases import Problem, write_solved
from benchmarks.optimum.chapter import chapter, summary
from benchmarks.optimum.solving import KEEP, Ending, Solved, solve_problem
from benchmarks.peers import arael_peer
from benchmarks.peers.endings import Path as Steps
from benchmarks.systems import Plan

PLAN = Plan(peers=(), python=sys.executable, quick=True)
OURS = Ending(
    *("arael", "default", "--init auto", "converged, sparse", 4, 10.0),
    costs=[1000.0, 50.0, 11.0, 10.000_005, 10.0],
    counts=[0, 1, 2, 3, 4],
    cpu=[0.004, 0.006, 0.005],
    wall=[0.008, 0.009, 0.010],
    times=[[0.001, 0.002, 0.003, 0.0035, 0.004]] * 3,
    score=10.0,
    best=10.0,
    setup=0.1,
)
PEER = replace(OURS, system="gtsam", way="GN", attempts=3, cpu=[0.020], wall=[0.02], best=10.0)


@pytest.fixture
def solved() -> Solved:
    found = Solved(Problem("pose_graph", "ring", Path("ring.g2o")), [OURS, PEER])
    found.versions = {"arael": "arael 1", "gtsam": "GTSAM 4"}
    return found


def test_the_time_to_the_best_cost_is_that_of_the_first_iteration_within_a_millionth() -> None:
    assert OURS.to_best() == (3, 0.0035)
    assert OURS.to_end == 0.005
    assert OURS.to_end_wall == 0.009
    attempts, seconds = replace(OURS, best=9.9).to_best()
    assert attempts is None
    assert math.isnan(seconds)


@pytest.mark.parametrize(
    ("cost", "best", "at_best", "near"),
    [
        (10.0, 10.0, True, True),
        (10.000_009, 10.0, True, True),
        (10.000_02, 10.0, False, True),
        (10.02, 10.0, False, False),
        (9e-10, 1e-25, True, True),  # exact, by the cost of 1000 at the start
        (2e-9, 1e-25, False, False),
        (math.nan, 10.0, False, False),
    ],
)
def test_an_end_is_compared_with_the_best_known_cost(
    cost: float, best: float, at_best: bool, near: bool
) -> None:
    ending = replace(OURS, cost=cost, best=best)
    assert (ending.at_best, ending.near) == (at_best, near)


def test_the_summary_sets_arael_beside_the_best_peer(solved: Solved) -> None:
    text = "\n".join(summary([solved]))
    row = (
        "| ring | yes | 4 | 5.00 | 3 ! (gtsam GN) | 20.0 (gtsam GN) | 0.25 | 3 / 3 | 3.50 / 3.50 "
        "| 100 / 105 | 100 / 120 |"
    )
    assert row in text
    assert "(within 1e-06): 1 of 1" in text
    assert "- attempts at most those of the best peer plus a quarter: 0 of 1" in text
    assert "plus a quarter: 1 of 1" in text  # attempts to the best cost
    assert "half of the best peer's: 1 of 1; above the best peer's: 0" in text


def test_peers_that_end_elsewhere_are_no_measure(solved: Solved) -> None:
    assert "only arael" not in "\n".join(summary([solved]))
    solved.endings[1] = replace(PEER, cost=10.02)
    text = "\n".join(summary([solved]))
    assert "| ring | yes | 4 | 5.00 | - | - | - |" in text
    assert "half of the best peer's: 0 of 0" in text
    assert (
        "only arael ends there on 1; with these, attempts as wanted on 1 of 1, time on 1 of 1"
        in text
    )


def test_what_falls_short_is_marked(solved: Solved) -> None:
    slow = replace(OURS, cpu=[0.015], cost=10.5, status="max_iterations, sparse")
    solved.endings[0] = slow
    text = "\n".join(summary([solved]))
    assert "| ring | no: 5 %, max_iterations | 4 | 15.0 |" in text
    assert "| 0.75 ! |" in text
    assert "ratios above 0.5: ring 0.75" in text
    solved.endings[0] = replace(slow, cpu=[0.03])
    assert "| 1.50 !! |" in "\n".join(summary([solved]))


def test_the_chapter_has_a_table_a_problem_and_reasons(solved: Solved) -> None:
    solved.absent = {"g2o": "g2opy is not installed"}
    text = "\n".join(chapter([solved]))
    assert "#### ring" in text
    assert (
        "| gtsam GN | 3 | converged, sparse | 10 | at best | 3 | 3.50 | 20.0 | 20.0 | 100 "
        "| 120 |" in text
    )
    assert "- g2o: g2opy is not installed" in text
    assert "- GTSAM 4: GN: --init auto" in text


@pytest.mark.slow
def test_arael_is_run_to_its_end_in_a_process(tmp_path: Path) -> None:
    path = tmp_path / "ring.g2o"
    assert graphs.ring(path, poses=60) == 60
    found = solve_problem(Problem("pose_graph", "ring", path), PLAN, tmp_path)
    ours = found.ours
    assert ours is not None
    assert [e.way for e in found.endings] == ["default", "file"]
    assert ours.status.startswith("converged, start ")
    assert ours.at_best
    assert ours.costs[0] > ours.costs[-1] == ours.cost
    assert ours.score == pytest.approx(ours.cost, rel=1e-9)
    assert len(ours.cpu) == len(ours.wall) == len(ours.times) >= 1
    assert all(np.all(np.diff(times) >= 0) and times[-1] > 0 for times in ours.times)
    assert max(t[-1] for t in ours.times) <= max(ours.cpu) * 1.01


@pytest.mark.slow
def test_a_scene_is_measured_by_solves_from_its_own_start(tmp_path: Path) -> None:
    """Its cost contains how far the solve has moved, the score of the answer does not."""
    path = tmp_path / "slam.npz"
    problems.write_scene(make_scene(benchmark_config(8)), path)
    ours = solve_problem(Problem("slam", "slam", path), PLAN, tmp_path).ours
    assert ours is not None and ours.status.startswith("converged")
    assert ours.score < ours.cost * (1 - 1e-6)
    assert ours.at_best and ours.best == pytest.approx(ours.cost, rel=1e-6)


def test_a_file_that_is_not_there_is_a_reason(tmp_path: Path) -> None:
    found = solve_problem(Problem("bundle", "none", tmp_path / "none.txt"), PLAN, tmp_path)
    assert "ARAEL_DATA" in found.absent["arael"]


@pytest.mark.slow
def test_results_of_peers_are_kept_and_those_of_arael_never(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    monkeypatch.setenv(KEEP, str(kept))
    path = tmp_path / "ring.g2o"
    graphs.ring(path, poses=40)
    plan = Plan(peers=("gtsam",), python=str(tmp_path / "no-python"), quick=True)
    place = kept / "ring-gtsam-0.json"
    place.parent.mkdir()
    way = {"name": "GN", "settings": "", "status": "ended", "attempts": 2, "cost": 1.0}
    way |= {"costs": [2.0, 1.0], "counts": [0, 2], "score": 5.0}
    way["runs"] = [{"cpu": 0.1, "wall": 0.1, "times": [0.0, 0.1]}]
    place.write_text(json.dumps({"version": "GTSAM", "setup": 0.1, "ways": [way]}))
    found = solve_problem(Problem("pose_graph", "ring", path), plan, tmp_path)
    assert [e.system for e in found.endings] == ["arael", "arael", "gtsam"]
    assert found.endings[-1].score == 5.0
    assert not list(kept.glob("*arael*"))


@pytest.mark.parametrize("name", graphs.GRAPHS)
def test_generated_graphs_start_with_their_odometry_and_end_at_the_noise(
    tmp_path: Path, name: str
) -> None:
    path = tmp_path / f"{name}.g2o"
    small = {"sphere": {"rings": 6, "around": 12}, "torus": {"rings": 12, "around": 8}}
    make = getattr(graphs, name.removesuffix("-noisy"))
    sizes = small.get(name.removesuffix("-noisy"), {})
    sizes = sizes or {"blocks" if name == "city" else "poses": 300}
    count = make(path, **sizes)
    assert graphs.has_vertices(path)
    graph = arael.load(problems.pose_graph_model(path))()
    graph.read(path)
    assert len(graph.poses) == count
    assert graph.cost() > 0
    arael.initialise(graph)
    result = graph.solve()
    assert result.converged
    # The information is that of the noise: about one for each residual beyond the unknowns.
    width = 3 if "VERTEX_SE2" in path.read_text(encoding="utf-8") else 6
    freedom = width * (len(graph.edges) - count + 1)
    assert 0.3 * freedom < result.end_cost < 2 * freedom + 10


def test_a_file_without_vertices_gets_its_odometry(tmp_path: Path) -> None:
    path = tmp_path / "bare.g2o"
    edges = "EDGE_SE2 0 1 1 0 1.5707963 1 0 0 1 0 1\n\nEDGE_SE2 1 2 2 0 0 1 0 0 1 0 1\n"
    path.write_text(edges + "EDGE_SE2 0 2 1 2 1.5 1 0 0 1 0 1\n")
    assert not graphs.has_vertices(path)
    (tmp_path / "out").mkdir()
    out = graphs.with_odometry(path, tmp_path / "out")
    graph = arael.load("pose_graph_2d")()
    graph.read(out)
    assert np.allclose(graph.poses.t.value, [[0, 0], [1, 0], [1, 2]], atol=1e-6)
    assert len(graph.edges) == 3


def test_a_solved_bundle_is_written_as_the_same_problem(tmp_path: Path) -> None:
    path = tmp_path / "bundle.txt"
    write_bundle(path, cameras=12, points=60)
    bundle = problems.KINDS["bundle"].load(str(path))
    write_bal(tmp_path / "copy.txt", bundle)
    copy = problems.KINDS["bundle"].load(str(tmp_path / "copy.txt"))
    assert copy.cost() == pytest.approx(bundle.cost(), rel=1e-9)
    bundle.solve(max_iters=3)
    state = problems.KINDS["bundle"].state(bundle)
    again = write_solved(Problem("bundle", "b", path), state, tmp_path)
    assert again is not None
    assert problems.KINDS["bundle"].load(str(again)).cost() == pytest.approx(
        bundle.cost(), rel=1e-9
    )


def test_scenes_have_no_other_start(tmp_path: Path) -> None:
    assert write_solved(Problem("slam", "s", tmp_path / "s.npz"), {}, tmp_path) is None


def test_the_demo_is_run_over_seeds() -> None:
    text = "\n".join(demo_seeds.run(PLAN, None))
    assert "- converged: 2 of 2" in text
    seed, attempts, before, pose, landmark, status = demo_seeds.measure(1)
    assert (seed, status) == (1, "")
    assert attempts < before
    assert pose < 0.02
    assert landmark < 0.03


@pytest.mark.parametrize("recorded", [0.0, 0.005, 0.22])
def test_the_times_of_attempts_are_those_of_the_processor(
    monkeypatch: pytest.MonkeyPatch, recorded: float
) -> None:
    """However long the clock ran while others worked, within an attempt or after it."""

    class Waits:
        """An instance whose solve works, makes an attempt, and waits for others."""

        def solve(self, **settings: object) -> Any:
            began = time.process_time()
            while time.process_time() - began < 0.02:
                pass
            history = np.zeros(1, dtype=RECORD)
            history["cost"], history["trial_cost"], history["accepted"] = 3.0, 2.0, True
            history["seconds"] = recorded
            time.sleep(0.2)
            plan = {"solver": "dense"}
            costs = {"start_cost": 3.0, "end_cost": 2.0}
            return SimpleNamespace(history=history, status="converged", plan=plan, **costs)

    monkeypatch.setattr(arael_peer, "can_initialise", lambda instance: False)
    monkeypatch.setattr(arael_peer, "order_again", lambda instance: None)
    kind = SimpleNamespace(state=lambda instance: {}, last_pass=None)
    system, path = arael_peer.Arael(Waits(), kind, 1), Steps()
    assert system.solve("default", path, 10) == "converged, dense"
    spent = time.process_time() - path.began
    assert (path.costs, path.counts) == ([3.0, 2.0], [0, 1])
    begun, ended = path.times
    assert 0.5 * spent < ended <= spent
    assert ended - begun == pytest.approx(min(recorded, ended))


@pytest.mark.parametrize("way", ["default", "file"])
def test_set_up_builds_the_problem_and_the_clock_holds_pattern_and_analysis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    path = tmp_path / "ring.g2o"
    graphs.ring(path, poses=40)
    kind = problems.KINDS["pose_graph"]
    system = arael_peer.Arael(kind.load(str(path)), kind, 1, str(path))
    system.fresh()
    session = system.instance.session
    assert (session.counts.problems, session.counts.analyses) == (1, 0)
    structure = session.earlier.structure
    assert structure.partition == []
    made: list[Any] = []

    def planned(*given: Any) -> Any:
        made.append(scatter_plan(*given))
        return made[-1]

    monkeypatch.setattr(arael_peer, "scatter_plan", planned)
    steps = Steps()
    assert system.solve(way, steps, 100).startswith("converged")
    (plan,) = made
    assert plan is not structure.plan
    assert plan.pattern.same_as(structure.pattern)
    assert plan._shares.keys() == structure.plan._shares.keys() != set()
    assert (session.counts.problems, session.counts.analyses) == (1, 1)
