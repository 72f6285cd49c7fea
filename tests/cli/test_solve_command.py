"""`arael solve`, as a user calls it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael.io import g2o
from arael.io.g2o.writer import dump
from tests.cli.conftest import Arael
from tests.optional import needs


def test_solves_and_writes(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "-o", "out.json")
    assert done.code == 0
    assert "converged" in done.out
    assert "wrote out.json" in done.out
    solved = json.loads((line / "out.json").read_text())
    assert (solved["a"], solved["b"]) == pytest.approx((2.0, 1.0))


def test_json_holds_what_is_documented(arael: Arael, line: Path) -> None:
    found = arael("solve", "line.arael", "line.json", "--json").json
    for key in ("status", "start_cost", "end_cost", "iterations", "accepted_iterations", "timing"):
        assert key in found
    assert found["status"] == "converged"
    assert found["plan"]["solver"]
    for key in ("predicted_decrease", "gradient_norm", "noise_floor"):
        assert found[key] >= 0
    assert [p["name"] for p in found["passes"]] == ["rough", "fine"]
    for one in found["passes"]:
        assert one["seconds"] > 0
        assert one["status"] == "converged"
    assert found["iterations"] == sum(p["iterations"] for p in found["passes"])


def test_json_is_one_object_also_of_a_failure(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "absent.json", "--json")
    assert done.code == 2
    assert done.json["status"] == "error"
    assert done.json["diagnostics"][0]["code"].startswith("E07")
    assert done.err == ""


def test_json_is_one_object_of_a_usage_error(arael: Arael) -> None:
    done = arael("solve", "slam", "x.json", "--solver", "qr", "--json")
    assert done.code == 2
    assert "'qr' is not one of" in done.json["diagnostics"][0]["message"]


def test_passes_can_be_chosen(arael: Arael, line: Path) -> None:
    found = arael("solve", "line.arael", "line.json", "--pass", "fine", "--json").json
    assert [p["name"] for p in found["passes"]] == ["fine"]


def test_set_reaches_the_cost(arael: Arael, line: Path) -> None:
    text = (line / "line.arael").read_text()
    (line / "line.arael").write_text(text[: text.index("    solve {")] + "}\n")
    plain = arael("solve", "line.arael", "line.json", "--json").json
    weighed = arael("solve", "line.arael", "line.json", "--set", "sigma=0.5", "--json").json
    assert weighed["start_cost"] == pytest.approx(4 * plain["start_cost"])


def test_max_iters_goes_over_the_models_passes(arael: Arael, line: Path) -> None:
    text = (line / "line.arael").read_text().replace("rel_precision = 1e-9", "max_iters = 50")
    (line / "line.arael").write_text(text)
    done = arael("solve", "line.arael", "line.json", "--max-iters", "1", "--json")
    assert done.code == 1
    assert [p["iterations"] for p in done.json["passes"]] == [1, 1]
    assert done.json["passes"][0]["status"] == "max_iterations"
    assert done.json["converged"] is False


def test_a_strategy_can_be_chosen(arael: Arael, line: Path) -> None:
    for strategy, word in (("damped", "lambda="), ("dogleg", "radius=")):
        done = arael("solve", "line.arael", "line.json", "-v", "--strategy", strategy)
        assert done.code == 0
        assert word in done.err
    assert arael("solve", "line.arael", "line.json", "--strategy", "other").code == 2


def test_a_stalled_solve_says_what_was_promised(arael: Arael, tmp_path: Path) -> None:
    """The residual jumps where it starts: exit code 1, and the predicted decrease beside it."""
    (tmp_path / "jump.arael").write_text(
        "root A {\n    param x: real = 1\n    constraint c { if x > 1 then x + 9 else x - 3 }\n}\n"
    )
    (tmp_path / "jump.json").write_text("{}")
    done = arael("solve", tmp_path / "jump.arael", tmp_path / "jump.json")
    assert done.code == 1
    assert done.out.startswith("stalled: cost 4 -> 4 in ")
    assert "; a further decrease of 4 is predicted (100 % of the cost)" in done.out
    done = arael("solve", tmp_path / "jump.arael", tmp_path / "jump.json", "--json")
    assert done.code == 1 and done.json["status"] == "stalled"
    assert done.json["predicted_decrease"] == pytest.approx(4)


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("sigm=2", "did you mean `sigma`?"),
        ("sigma=two", "expected numbers for `sigma`, found `two`"),
        ("origin=1,2,3", "expected 2 numbers, found 3"),
        ("sigma", "expected NAME=VALUE"),
        ("points=1", "has no field `points` to set"),
    ],
)
def test_set_that_does_not_fit(arael: Arael, line: Path, setting: str, told: str) -> None:
    done = arael("solve", "line.arael", "line.json", "--set", setting)
    assert done.code == 2
    assert "E0852" in done.err
    assert told in done.err


def test_every_wrong_set_is_told(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--set", "x=1", "--set", "y=2")
    assert done.err.count("E0852") == 2


def test_unknown_model_gets_a_suggestion(arael: Arael) -> None:
    done = arael("solve", "slan", "x.json")
    assert done.code == 2
    assert "did you mean `slam`?" in done.err


def test_unknown_pass_is_bad_input(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--pass", "fin")
    assert done.code == 2
    assert "did you mean `fine`?" in done.err


@pytest.mark.parametrize("option", ["-o", "--covariance", "--plot"])
def test_unwritable_output_is_told_before_the_solve(arael: Arael, line: Path, option: str) -> None:
    done = arael(
        "solve",
        "line.arael",
        "line.json",
        option,
        "no/such/x.json".replace("json", "png" if option == "--plot" else "json"),
    )
    assert done.code == 2
    assert "E0853" in done.err
    assert "its folder does not exist" in done.err
    assert done.out == ""


def test_impossible_format_is_told_before_the_solve(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "-o", "out.g2o")
    assert done.code == 2
    assert done.out == ""
    assert not (line / "out.g2o").exists()


def test_unsolvable_problem_exits_with_1(arael: Arael, line: Path) -> None:
    (line / "line.json").write_text('{"a": 0.0, "b": 0.0, "points": []}')
    done = arael("solve", "line.arael", "line.json")
    assert done.code == 1
    assert "E1003" in done.err


def test_covariance_as_npz_and_json(arael: Arael, line: Path) -> None:
    for name in ("c.npz", "c.json"):
        assert arael("solve", "line.arael", "line.json", "--covariance", name).code == 0
    found = np.load(line / "c.npz")
    design = np.array([[0, 1], [1, 1], [2, 1.0]])
    assert found["names"].tolist() == ["a", "b"]
    assert found["covariance"] == pytest.approx(np.linalg.inv(design.T @ design))
    sigma = json.loads((line / "c.json").read_text())["sigma"]
    assert sigma["a"] == pytest.approx(found["sigma"][0])


def test_covariance_ending_is_told_before_the_solve(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--covariance", "c.txt")
    assert done.code == 2
    assert "E0855" in done.err


def test_verbose_traces_each_pass(arael: Arael, line: Path) -> None:
    # The first residual is no longer zero at the solution of the pass before.
    text = (line / "line.json").read_text()
    (line / "line.json").write_text(text.replace("3", "3.1", 1))
    done = arael("solve", "line.arael", "line.json", "-v")
    assert "pass rough\n1/0: " in done.err
    assert "pass fine\n1/0: " in done.err
    assert "radius=" in done.err


def test_a_pipe_sees_no_progress(arael: Arael, line: Path) -> None:
    assert arael("solve", "line.arael", "line.json").err == ""


def test_without_a_compiler_the_interpreter_is_told_of(
    arael: Arael, line: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(line / "cache"))
    monkeypatch.setenv("CC", "/no/such/compiler")
    done = arael("solve", "line.arael", "line.json")
    assert done.code == 0
    assert done.err.startswith("warning: running on the expression machine")
    assert len(done.err.splitlines()) == 1


def test_unwritable_cache_is_bad_input(
    arael: Arael, line: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (line / "file").write_text("")
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(line / "file" / "cache"))
    done = arael("solve", "line.arael", "line.json")
    assert done.code == 2
    assert "E0804" in done.err
    assert "ARAEL_CACHE_DIR" in done.err


def test_interpreter_gives_the_same(arael: Arael, line: Path) -> None:
    compiled = arael("solve", "line.arael", "line.json", "--json").json
    interpreted = arael("solve", "line.arael", "line.json", "--interpret", "--json").json
    assert interpreted["start_cost"] == pytest.approx(compiled["start_cost"], rel=1e-12)
    assert interpreted["iterations"] == compiled["iterations"]


@needs("matplotlib")
def test_plot_writes_pictures(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--plot", "p.png")
    assert done.code == 0
    for name in ("p.png", "p-hessian.png"):
        assert (line / name).read_bytes().startswith(b"\x89PNG")


@needs("matplotlib")
def test_report_is_one_page_and_escapes_names(arael: Arael, line: Path) -> None:
    (line / "a&b.json").write_text((line / "line.json").read_text())
    done = arael("solve", str(line / "line.arael"), str(line / "a&b.json"), "--report", "r.html")
    assert done.code == 0
    page = (line / "r.html").read_text()
    assert "<h1>line.arael on a&amp;b.json</h1>" in page  # without the folders of this machine
    assert "<td>Line.points</td>" in page
    assert "<svg" in page
    assert "src=" not in page


@pytest.mark.parametrize("name", ["r.md", "r.TXT"])
def test_report_as_text(arael: Arael, line: Path, name: str) -> None:
    done = arael("solve", "line.arael", "line.json", "--interpret", "--report", name)
    assert done.code == 0 and f"wrote {name}" in done.out
    text = (line / name).read_text()
    title = "line.arael on line.json"
    assert text.startswith(f"# {title}\n" if name == "r.md" else f"{title}\n=====")
    for part in ("Solution", "degrees of freedom", "Line.points", "Cost by constraint", "Time"):
        assert part in text
    assert "<" not in text.replace("<->", "")


def test_a_report_of_another_ending_is_refused_before_the_solve(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--report", "c.pdf")
    assert done.code == 2 and not (line / "c.pdf").exists()
    assert "error[E0858]: reports are written as .html, .md or .txt" in done.err
    assert "for instance c.html" in done.err


def test_interpret_and_compiled_exclude_each_other(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--compiled", "--interpret")
    assert done.code == 2 and "error[E0851]" in done.err and "give one of them" in done.err


def test_more_threads_than_a_solve_uses_are_reported(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--interpret", "--threads", "99999")
    assert done.code == 0
    assert "most that a solve uses, 99999 were asked for; `--threads 0`" in done.err
    done = arael("solve", "line.arael", "line.json", "--interpret", "--threads", "2")
    assert "--threads" not in done.err or "1 thread is" in done.err


def test_interrupt_keeps_the_best_state(tmp_path: Path) -> None:
    """A long solve, interrupted in its trace, writes what it has and exits with 1."""
    # Gauss-Newton on x^4 shrinks x by a quarter a step: hundreds of steps, each over many points.
    (tmp_path / "slow.arael").write_text(
        "struct Point { w: real }\n"
        "root Slow {\n    param x: real\n    points: list of Point\n"
        "    fit points as p { p.w * x ^ 4 }\n"
        "    solve { pass long { max_iters = 100000   min_iters = 100000 } }\n}\n"
    )
    np.savez(tmp_path / "slow.npz", **{"x": 3.0, "points.w": np.ones(200_000)})
    command = [sys.executable, "-m", "arael.cli.main", "solve", "slow.arael", "slow.npz"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(
        [*command, "-o", "out.json", "--interpret", "-v"],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    for text in process.stderr:
        if text.startswith("1/0"):
            process.send_signal(signal.SIGINT)
            break
    out, err = process.communicate(timeout=60)
    assert process.returncode == 1, err
    assert "aborted" in out
    assert "interrupted" in err
    assert abs(json.loads((tmp_path / "out.json").read_text())["x"]) < 3.0


LOOP = """\
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1.1 9 1.6
VERTEX_SE2 2 -1 0.9 2.9
EDGE_SE2 0 1 1 0 1.5 100 0 0 100 0 400
EDGE_SE2 1 2 1 0 1.5 100 0 0 100 0 400
EDGE_SE2 0 2 1.07 1 3 100 0 0 100 0 400
"""


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder, made the current one, with a pose graph that starts far off."""
    (tmp_path / "loop.g2o").write_text(LOOP)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_pose_graph_starts_from_the_least_cost(arael: Arael, loop: Path) -> None:
    done = arael("solve", "pose_graph_2d", "loop.g2o")
    assert done.code == 0
    assert "start: chordal, cost " in done.err
    assert " (file 17263.5)" in done.err
    found = arael("solve", "pose_graph_2d", "loop.g2o", "--json").json
    assert found["init"]["chosen"] == "chordal"
    assert found["start_cost"] == pytest.approx(found["init"]["costs"]["chordal"])


@pytest.mark.parametrize("init", ["tree", "chordal"])
def test_the_start_of_a_pose_graph_can_be_chosen(arael: Arael, loop: Path, init: str) -> None:
    found = arael("solve", "pose_graph_2d", "loop.g2o", "--init", init, "--json").json
    assert found["init"]["chosen"] == init
    assert list(found["init"]["costs"]) == ["file", init]


def test_init_file_takes_the_values_in_the_file(arael: Arael, loop: Path) -> None:
    done = arael("solve", "pose_graph_2d", "loop.g2o", "--init", "file", "--json")
    assert done.json["start_cost"] == pytest.approx(17263.5, abs=0.1)
    assert "init" not in done.json
    assert done.err == ""


def test_other_models_have_no_start_to_compute(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.arael", "line.json", "--init", "chordal")
    assert done.code == 2
    assert "E0843" in done.err
    assert "`Line` of line.arael is not a pose graph" in done.err
    assert "start:" not in arael("solve", "line.arael", "line.json").err


def test_a_singular_chordal_start_is_bad_input(arael: Arael, loop: Path) -> None:
    edge = '{"a": 0, "b": 1, "t": [1, 0], "th": 0, "u": [[1, 0, 0], [0, 1, 0], [0, 0, 0]]}'
    (loop / "loop.json").write_text(
        f'{{"poses": [{{"t": [0, 0], "th": 0}}, {{"t": [1, 0], "th": 0}}], "edges": [{edge}]}}'
    )
    done = arael("solve", "pose_graph_2d", "loop.json", "--init", "chordal")
    assert done.code == 2
    assert "E0844" in done.err


COMPONENTS = """
struct Fit { param x: real
    t: real
    constraint low when x < 1 { x - 2 }
    constraint high when x >= 1 { 3 * (x - t) } }
root Fits { fits: list of Fit }
"""


def test_what_became_of_each_component(arael: Arael, tmp_path: Path) -> None:
    """The one that stands at a jump of its cost is named; the exit code is that of the worst."""
    model, data = tmp_path / "fits.arael", tmp_path / "fits.json"
    model.write_text(COMPONENTS)
    starts = [(2.0, 1.5), (0.0, 3.0), (4.0, 2.0)]
    data.write_text(json.dumps({"fits": [{"x": x, "t": t} for x, t in starts]}))
    done = arael("solve", model, data, "--interpret")
    assert done.code == 1
    assert "2 of 3 components converged; fits[1]: stalled" in done.out
    found = arael("solve", model, data, "--interpret", "--json").json
    assert found["status"] == "stalled" and not found["converged"]
    (one,) = found["passes"]
    assert one["components"]["count"] == 3
    assert one["components"]["status"] == ["converged", "stalled", "converged"]
    assert one["components"]["name"] == ["fits[0]", "fits[1]", "fits[2]"]
    assert sum(one["components"]["end_cost"]) == pytest.approx(found["end_cost"])


def test_a_solve_of_a_pose_graph_imports_no_scipy(loop: Path) -> None:
    """Its import takes as long as a solve of thousands of poses."""
    code = (
        "import sys; from arael.cli.main import run\n"
        "code = run(['solve', 'pose_graph_2d', 'loop.g2o', '-o', 'out.g2o'])\n"
        "print(code, sorted(m for m in sys.modules if m.startswith('scipy')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "0 []", done.stderr


def test_a_g2o_output_is_written_once(
    arael: Arael, loop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before the solve its data are checked, but no text is made of them."""
    dumped = []

    def counting(*given: Any) -> bytes:
        dumped.append(given)
        return dump(*given)

    monkeypatch.setattr(g2o, "dump", counting)
    assert arael("solve", "pose_graph_2d", "loop.g2o", "-o", "out.g2o").code == 0
    assert len(dumped) == 1
    assert len((loop / "out.g2o").read_text().splitlines()) >= 6


def test_what_g2o_cannot_hold_is_told_before_the_solve(arael: Arael, loop: Path) -> None:
    edge = {"a": 0, "b": 1, "t": [1, 0], "th": 0, "u": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    poses = [{"t": {"value": [0, 0], "fixed": True}, "th": 0}, {"t": [1, 0], "th": 0}]
    (loop / "half.json").write_text(json.dumps({"poses": poses, "edges": [edge]}))
    done = arael("solve", "pose_graph_2d", "half.json", "-o", "out.g2o")
    assert done.code == 2
    assert "E0722" in done.err
    assert "poses[0]" in done.err
    assert done.out == ""
    assert not (loop / "out.g2o").exists()


def test_questions_to_the_solution(
    arael: Arael, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sensitivity, influence and uncertain data: as text, as JSON, in reports."""
    (tmp_path / "fit.arael").write_text(
        "struct Point { x: real\n y: real\n"
        "constraint fit { root.a * x + root.b - y + root.bias } }\n"
        "root Line { param a: real = 0\n param b: real = 0\n bias: real = 0\n"
        "points: list of Point }"
    )
    monkeypatch.chdir(tmp_path)
    points = [{"x": x, "y": y} for x, y in ((0, 0.1), (1, 0.9), (2, 2.2), (3, 2.8))]
    (tmp_path / "fit.json").write_text(json.dumps({"points": points}))
    base = ("solve", "fit.arael", "fit.json", "--interpret", "--sensitivity", "a")
    base += ("--uncertain", "bias=0.25")
    done = arael(*base, "--report", "r.html")
    assert done.code == 0
    assert "sensitivity of a (Gauss-Newton Hessian)" in done.out
    assert "observations that decide a" in done.out
    assert "standard errors with uncertain data" in done.out
    assert "observations" in (tmp_path / "r.html").read_text()
    found = arael(*base, "--report", "r.md", "--json").json
    assert found["sensitivity"][0]["by"]["points.y"] == pytest.approx([-0.3, -0.1, 0.1, 0.3])
    assert found["influence"][0]["deciding"][0]["share"] == pytest.approx(0.45)
    assert found["propagation"][0]["by"]["bias"] == pytest.approx([0, 0.25], abs=1e-9)
    assert "standard errors with uncertain data" in (tmp_path / "r.md").read_text()
    wrong = arael("solve", "fit.arael", "fit.json", "--interpret", "--uncertain", "bias")
    assert wrong.code == 2
    assert "E0852" in wrong.err and "expected PATH=SIGMA" in wrong.err
