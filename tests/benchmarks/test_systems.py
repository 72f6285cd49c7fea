"""The harness on tiny problems: arael in a process of its own, peers that are not there."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from arael.scenes import PlaneConfig, benchmark_config, make_plane_scene, make_scene
from benchmarks import problems, runtime_residuals, schur
from benchmarks.cases import SUITES, Case, cases
from benchmarks.fit import fit_arael, fit_scipy
from benchmarks.peers import ceres_program, g2o_program, native, rust_peer
from benchmarks.peers.runner import AbsentError
from benchmarks.report import suite_report
from benchmarks.systems import Plan, measure_suite, run_system

PLAN = Plan(peers=(), python=sys.executable, quick=True)


def scene(folder: Path, suite: str) -> Case:
    path = folder / "scene.npz"
    problems.write_scene(make_scene(benchmark_config(12)), path)
    return Case(suite, "12 poses", path, 1, 3, limit=40)


@pytest.mark.sweep(3)
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
    # Data: at least the parameters; factor: at least its diagonal.
    assert outcome.facts["data"] > 8 * 12
    assert outcome.facts["factor"] > 8 * 6 * 8
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


@pytest.mark.slow
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


def interpreter(folder: Path, script: str) -> str:
    """Something that is run as the interpreter of the peers' wheels."""
    path = folder / "python"
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o700)
    return str(path)


def test_a_wheel_that_is_missing_is_named_with_what_to_do(tmp_path: Path) -> None:
    said = "ModuleNotFoundError: No module named 'pyceres'"
    python = interpreter(tmp_path, f'echo "Traceback" >&2; echo "{said}" >&2; exit 1')
    outcome = run_system("gtsam", scene(tmp_path, "slam"), None, Plan(python=python), 1, tmp_path)
    assert not outcome.slopes
    assert outcome.reason == (
        "pyceres is not installed: `pip install pyceres==2.6 pycolmap==3.13.0`, or name the "
        "interpreter that has it with --peer-python"
    )


@pytest.mark.slow
def test_what_another_program_of_a_system_does_is_no_reason(tmp_path: Path) -> None:
    python = interpreter(tmp_path, "echo 'no such luck' >&2; exit 1")
    outcome = run_system("g2o", scene(tmp_path, "slam"), None, Plan(python=python), 1, tmp_path)
    assert outcome.reason == "no such luck"


def test_g2o_is_looked_for_where_the_wheels_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARAEL_BENCH_PEER_PYTHON", interpreter(tmp_path, "exit 0"))
    with pytest.raises(AbsentError, match="`pip install g2opy`"):
        g2o_program.program()
    origin = tmp_path / "site" / "g2opy" / "__init__.py"
    monkeypatch.setenv(
        "ARAEL_BENCH_PEER_PYTHON", interpreter(tmp_path, f"echo {origin}; echo 2.3.0")
    )
    assert g2o_program.wheel() == (tmp_path / "site", "2.3.0")
    with pytest.raises(AbsentError, match="without g2o's headers"):
        g2o_program.program()


def test_headers_that_are_missing_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler = tmp_path / "g++"
    said = "bundle.h:5:10: fatal error: ceres/rotation.h: No such file or directory"
    compiler.write_text(f'#!/bin/sh\necho "{said}" >&2\nexit 1\n')
    compiler.chmod(0o700)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.setattr(native, "BUILD", tmp_path / "build")
    words = r"did not build: Ceres's headers \(Debian: libceres-dev\) are missing"
    with pytest.raises(AbsentError, match=words):
        ceres_program.program()
    assert said in (tmp_path / "build" / "ceres.log").read_text()


def test_data_that_is_not_there_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.cases.DATA", tmp_path)
    found = measure_suite("pose_graph", Plan(peers=("gtsam",), threads=(1, 2)))
    assert [m.case.name for m in found][:2] == ["M3500", "intel"]
    text = "\n".join(suite_report("pose_graph", found, None))
    assert "the file is not there (ARAEL_DATA names its folder)" in text
    assert text.count("- arael, gtsam: ") == 1


@pytest.mark.parametrize("suite", sorted(SUITES))
def test_something_of_every_suite_is_measured_on_more_threads_too(
    tmp_path: Path, suite: str
) -> None:
    large = [case.name for case in cases(suite, tmp_path, quick=True) if case.large]
    assert 1 <= len(large) <= 2


@pytest.mark.slow
def test_every_step_of_residuals_given_as_text_is_timed() -> None:
    found = runtime_residuals.measure("f32", 1, 4)
    assert len(found) == 6
    assert all(seconds > 0 for seconds in found.values())


def test_solvers_are_timed_on_a_structure(monkeypatch: pytest.MonkeyPatch) -> None:
    small = {"small": lambda: schur.bundle_structure(30, 900, 5000)}
    monkeypatch.setattr(schur, "STRUCTURES", small)
    rows = schur.measure("small", 2)
    solvers = [row[2].split()[0] for row in rows]
    assert solvers == ["sparse", "schur", "schur_pcg"] * 2
    assert [row[0] for row in rows] == ["small, f64"] * 3 + ["small, f32"] * 3
    assert all(float(time.split()[0]) > 0 for row in rows for time in row[3:4])


def test_many_fits_at_once_reach_what_single_fits_reach() -> None:
    ours, single = fit_arael(250, 1), fit_scipy(250)
    assert ours["cost"] == pytest.approx(single["cost"], rel=1e-5)
