"""The language page on `solve { }`: passes, settings, `freeze` and `free`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.cli.main import run
from tests.language.models import loaded, refusal

# Every parameter that moves goes at once to its target: the residuals are linear and apart.
MODEL = """
struct Bias { param b: real; constraint c { b - 5 * root.gain } }
struct Pose {
    param pos: vec2
    param ea: real
    bias: Bias
    marks: list of Mark
    constraint c { [pos.x - 1, pos.y - 2, ea - 3 * root.gain] }
}
struct Mark { param m: real; constraint c { m - 7 } }
root Path {
    poses: list of Pose
    loose: list of Mark
    bias: Bias
    param drift: real = 0
    gain: real = 1
    constraint c { drift - root.gain }
    SOLVE
}
"""
DATA = {
    "poses": [{"pos": [0, 0], "ea": 0, "bias": {"b": 0}, "marks": [{"m": 0}]}],
    "loose": [{"m": 0}],
    "bias": {"b": 0},
}
ALL = {
    "poses.pos": [1, 2], "poses.ea": [3], "poses.bias.b": [5], "poses.marks.m": [7],
    "loose.m": [7], "bias.b": [5], "drift": [1],
}  # fmt: skip


def filled(folder: Path, passes: str = "") -> Any:
    solve = f"solve {{ {passes} }}" if passes else ""
    model = loaded(folder, MODEL.replace("SOLVE", solve))()
    (folder / "data.json").write_text(json.dumps(DATA))
    model.read(folder / "data.json")
    return model


def values(model: Any) -> dict[str, list[float]]:
    found = {
        "poses.pos": model.poses.pos.value[0],
        "poses.ea": model.poses.ea.value,
        "poses.bias.b": model.poses[0].bias.b.value,
        "poses.marks.m": model.poses[0].marks.m.value,
        "loose.m": model.loose.m.value,
        "bias.b": model.bias.b.value,
        "drift": model.drift.value,
    }
    return {k: np.ravel(v).tolist() for k, v in found.items()}


def moved(model: Any) -> set[str]:
    """Parameters that are at their target; the others must be where they began."""
    found = set()
    for name, value in values(model).items():
        if value == pytest.approx(ALL[name], abs=1e-5):
            found.add(name)
        else:
            assert value == [0] * len(value), name
    return found


def test_without_passes_there_is_one_plain_solve(tmp_path: Path) -> None:
    model = filled(tmp_path)
    model.solve()
    assert moved(model) == set(ALL)


FREEZES = [
    ("poses.ea", {"poses.ea"}),
    ("poses.pos, drift", {"poses.pos", "drift"}),
    ("root.drift", {"drift"}),
    ("poses", {"poses.pos", "poses.ea", "poses.bias.b", "poses.marks.m"}),
    ("poses.bias", {"poses.bias.b"}),
    ("poses.marks", {"poses.marks.m"}),
    ("poses.marks.m", {"poses.marks.m"}),
    # by the type of a struct, wherever it sits
    ("Bias", {"poses.bias.b", "bias.b"}),
    ("Bias.b", {"poses.bias.b", "bias.b"}),
    ("Mark", {"poses.marks.m", "loose.m"}),
    ("Pose", {"poses.pos", "poses.ea", "poses.bias.b"}),
    ("Pose.pos", {"poses.pos"}),
    ("Pose.bias", {"poses.bias.b"}),
    ("Pose.bias.b", {"poses.bias.b"}),
    ("Pose.marks", {"poses.marks.m"}),
    ("Path", {"drift", "bias.b"}),
]


@pytest.mark.parametrize(("paths", "stay"), FREEZES)
def test_freeze(tmp_path: Path, paths: str, stay: set[str]) -> None:
    """In a pass of the model, in `solve(freeze=)`, and in a pass from Python."""
    model = filled(tmp_path, f"pass one {{ freeze {paths} }}")
    model.solve()
    assert set(ALL) - moved(model) == stay
    listed = [p.strip().removeprefix("root.") for p in paths.split(",")]
    model = filled(tmp_path)
    model.solve(freeze=listed)
    assert set(ALL) - moved(model) == stay
    model = filled(tmp_path)
    model.solve(passes=arael.Pass("one", freeze=listed))
    assert set(ALL) - moved(model) == stay


@pytest.mark.parametrize(
    ("steps", "stay"),
    [
        ("freeze poses; free Pose.ea", {"poses.pos", "poses.bias.b", "poses.marks.m"}),
        ("freeze Bias; free bias", {"poses.bias.b"}),
        ("freeze Mark, Pose, Bias, Path; free poses, loose", {"bias.b", "drift"}),
    ],
)
def test_free_within_what_is_frozen(tmp_path: Path, steps: str, stay: set[str]) -> None:
    model = filled(tmp_path, f"pass one {{ {steps} }}")
    model.solve()
    assert set(ALL) - moved(model) == stay


def test_a_freeze_ends_with_its_pass(tmp_path: Path) -> None:
    passes = "pass one { freeze Mark, drift }\n pass two { freeze Mark }\n pass three { }"
    for names, stay in (
        (["one"], {"loose.m", "poses.marks.m", "drift"}),
        (["one", "two"], {"loose.m", "poses.marks.m"}),
        (["one", "two", "three"], set()),
        (["two"], {"loose.m", "poses.marks.m"}),
    ):
        model = filled(tmp_path, passes)
        model.solve(passes=names)
        assert set(ALL) - moved(model) == stay, names


def test_freezing_ends_with_the_solve(tmp_path: Path) -> None:
    model = filled(tmp_path, "pass one { freeze poses }")
    model.solve()
    model.solve(passes=[])
    assert moved(model) == set(ALL)


def test_what_is_fixed_or_not_optimised_is_not_freed(tmp_path: Path) -> None:
    model = filled(tmp_path, "pass one { freeze poses }\n pass two { free poses }")
    model.poses.pos.fixed = True
    model.loose.m.optimize = False
    model.solve()
    assert set(ALL) - moved(model) == {"poses.pos", "loose.m"}


@pytest.mark.parametrize(
    ("steps", "code"),
    [
        ("freeze Marc", "E0405"),
        ("freeze Pose.eaa", "E0405"),
        ("freeze Empty", "E0411"),
        ("freeze Unheld", "E0411"),
        ("freeze gain", "E0411"),
    ],
)
def test_what_cannot_be_frozen(tmp_path: Path, steps: str, code: str) -> None:
    text = MODEL.replace("SOLVE", f"empty: Empty; solve {{ pass one {{ {steps} }} }}").replace(
        ";", "\n"
    )
    text += "struct Empty { x: real = 0 }\nstruct Unheld { param x: real\n constraint c { x } }\n"
    found = refusal(tmp_path, text)
    assert found.code == code
    assert steps != "freeze Marc" or found.help == ("did you mean `Mark`?",)
    model = filled(tmp_path)
    with pytest.raises(arael.AraelError) as caught:
        model.solve(freeze=steps.removeprefix("freeze "))
    assert caught.value.diagnostics[0].code == "E1012"


# --- data and settings of a pass ------------------------------------------------------------------

GAINS = "pass low { gain = 2; max_iters = 30 }\n pass high { gain = 10 }"


def test_passes_run_in_order_and_their_data_stays(tmp_path: Path) -> None:
    model = filled(tmp_path, GAINS)
    result = model.solve()
    assert [part.name for part in result.passes] == ["low", "high"]
    assert model.gain == 10
    assert model.drift.value == pytest.approx(10)
    model.solve(passes="low")
    assert (model.gain, model.drift.value) == pytest.approx((2, 2))


def test_settings_are_for_their_pass_alone(tmp_path: Path) -> None:
    result = filled(tmp_path, "pass a { max_iters = 1 }\n pass b { gain = 3 }").solve()
    assert [part.status for part in result.passes] == ["max_iterations", "converged"]


def test_a_pass_from_python(tmp_path: Path) -> None:
    model = filled(tmp_path)
    schedule = [
        arael.Pass("rough", data={"gain": 4}, freeze="Mark", config={"max_iters": 1}),
        arael.Pass("full", data={"gain": 2}, free="Mark"),
    ]
    result = model.solve(passes=schedule)
    assert [part.name for part in result.passes] == ["rough", "full"]
    assert result.passes[0].iterations == 1
    assert (model.gain, model.drift.value) == pytest.approx((2, 2))
    assert model.loose.m.value[0] == pytest.approx(7)


def test_passes_of_the_model_and_from_python_mix(tmp_path: Path) -> None:
    model = filled(tmp_path, GAINS)
    result = model.solve(passes=["high", arael.Pass("more", data={"gain": 1})])
    assert [part.name for part in result.passes] == ["high", "more"]
    assert model.drift.value == pytest.approx(1)


@pytest.mark.parametrize(
    ("given", "code", "said"),
    [
        (arael.Pass("p", data={"gian": 1}), "E0701", "did you mean `gain`?"),
        (arael.Pass("p", data={"drift": 1}), "E0701", ""),
        (arael.Pass("p", data={"gain": [1, 2]}), "E0704", ""),
        (arael.Pass("p", data={"gain": "x"}), "E0703", ""),
        (arael.Pass("p", data={"gain": float("nan")}), "E0705", ""),
        (arael.Pass("p", freeze="poses.eaa"), "E1012", "did you mean `poses.ea`?"),
        (arael.Pass("p", freeze="Posee"), "E1012", "did you mean `Pose`?"),
        (arael.Pass("p", config={"max_itrs": 1}), "E1010", "did you mean `max_iters`?"),
        ("lw", "E1011", "did you mean `low`?"),
    ],
)
def test_passes_that_do_not_fit(tmp_path: Path, given: Any, code: str, said: str) -> None:
    model = filled(tmp_path, GAINS)
    with pytest.raises(arael.AraelError) as caught:
        model.solve(passes=["low", given])
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert said in " ".join(found.help)
    assert moved(model) == set(), "nothing runs before all passes are understood"


# --- on the command line --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "drift"),
    [([], 10), (["--pass", "low"], 2), (["--pass", "high", "--pass", "low"], 2)],
)
def test_passes_on_the_command_line(
    tmp_path: Path, options: list[str], drift: float, capsys: pytest.CaptureFixture[str]
) -> None:
    filled(tmp_path, GAINS)
    model, data, out = (tmp_path / name for name in ("model.arael", "data.json", "out.json"))
    code = run(["solve", str(model), str(data), "-o", str(out), "--interpret", *options])
    assert code == 0, capsys.readouterr()
    assert json.loads(out.read_text())["drift"] == pytest.approx(drift)


def test_an_unknown_pass_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    filled(tmp_path, GAINS)
    model, data = (str(tmp_path / name) for name in ("model.arael", "data.json"))
    assert run(["solve", model, data, "--interpret", "--pass", "lwo"]) == 2
    told = capsys.readouterr().err
    assert "there is no pass `lwo`" in told
    assert "did you mean `low`?" in told
