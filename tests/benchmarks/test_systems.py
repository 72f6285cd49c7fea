"""The harness on tiny problems: arael in a process of its own, peers that are not there."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from arael.scenes import PlaneConfig, benchmark_config, make_plane_scene, make_scene
from benchmarks import problems
from benchmarks.cases import Case
from benchmarks.fit import fit_arael, fit_scipy
from benchmarks.peers import native, rust_peer
from benchmarks.systems import Plan, run_system

PLAN = Plan(peers=(), python=sys.executable, quick=True)


def scene(folder: Path, suite: str) -> Case:
    path = folder / "scene.npz"
    problems.write_scene(make_scene(benchmark_config(12)), path)
    return Case(suite, "12 poses", path, 1, 3, limit=40)


@pytest.mark.parametrize("suite", ["slam", "localization", "plane"])
def test_arael_runs_in_a_process_and_its_answer_is_scored(tmp_path: Path, suite: str) -> None:
    if suite == "plane":
        path = tmp_path / "plane.npz"
        problems.write_planes(make_plane_scene(PlaneConfig(poses=8)), path)
        case = Case(suite, "8 poses", path, 1, 3, limit=20)
    else:
        case = scene(tmp_path, suite)
    reference = problems.Reference(suite, str(case.path))
    outcome = run_system("arael", case, reference, PLAN, 1, tmp_path)
    assert outcome.reason == ""
    assert len(outcome.slopes) >= 3
    assert outcome.memory > 10
    assert outcome.version.startswith("arael ")
    # The same by the library's own way.
    own = problems.KINDS[suite].load(str(case.path))
    result = own.solve(passes=problems.KINDS[suite].last_pass, rel_precision=1e-9)
    assert outcome.cost == pytest.approx(result.cost, rel=1e-3)
    assert outcome.cost < result.start_cost


def test_a_problem_that_a_system_lacks_has_a_reason(tmp_path: Path) -> None:
    case = Case("sudoku", "hard", tmp_path / "none.npz")
    outcome = run_system("arael", case, None, PLAN, 1, tmp_path)
    assert not outcome.slopes
    assert outcome.reason.startswith("no sudoku in arael")


def test_a_peer_that_fails_is_reported(tmp_path: Path) -> None:
    case = Case("slam", "gone", tmp_path / "none.npz")
    outcome = run_system("arael", case, None, PLAN, 1, tmp_path)
    assert not outcome.slopes
    assert "none.npz" in outcome.reason


def test_without_cargo_the_rust_framework_is_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CARGO_HOME", str(tmp_path))
    with pytest.raises(native.AbsentError, match="cargo is not installed"):
        rust_peer.program()


def test_many_fits_at_once_reach_what_single_fits_reach() -> None:
    ours, single = fit_arael(250, 1), fit_scipy(250)
    assert ours["cost"] == pytest.approx(single["cost"], rel=1e-5)
