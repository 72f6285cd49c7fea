"""The solve schedule."""

from __future__ import annotations

import pytest

from arael.check.passes import SETTINGS, SWITCHES
from arael.config import LmConfig, refused
from arael.diagnostics.records import AraelError
from arael.runtime.layout import LayoutPass, PassSetting
from tests.check.models import checked, codes, standard

MODEL = """
struct Globals { param scale: real; offset: real = 0; constraint c { scale - offset } }
struct Pose { param pos: vec3; param ea: euler; w: real; constraint c { [pos, ea] * w } }
struct Camera { f: real }
root Path {
    poses: list of Pose
    cameras: list of Camera
    globals: Globals
    gain: real = 1
    shift: vec2 = [0, 0]
    on: bool = true
    solve { pass one { STEPS } }
}
"""


def test_slam_schedule() -> None:
    def scale(value: float) -> tuple[PassSetting, ...]:
        return (PassSetting("frine_isigma_scale", (value,)),)

    assert standard("slam").passes == (
        LayoutPass("coarse", scale(0.01), {"rel_precision": 1e-4}),
        LayoutPass("medium", scale(0.1), {"rel_precision": 1e-4}),
        LayoutPass("fine", scale(1.0), {"rel_precision": 1e-6}),
    )


def test_settings_and_data() -> None:
    steps = """
        gain = 2 ^ 3; shift = [1, 2]; on = false; globals.offset = 1
        max_iters = 20; verbose = true
    """
    (found,) = checked(MODEL.replace("STEPS", steps)).passes
    assert {s.column: s.value for s in found.settings} == {
        "gain": (8,),
        "shift": (1, 2),
        "on": (0,),
        "globals.offset": (1,),
    }
    assert found.config == {"max_iters": 20, "verbose": True}


def test_freeze_and_free() -> None:
    steps = "freeze poses.ea, globals\n free root.poses, globals.scale"
    (found,) = checked(MODEL.replace("STEPS", steps)).passes
    assert found.freeze == ("poses.ea", "globals")
    assert found.free == ("poses", "globals.scale")


@pytest.mark.parametrize(
    ("steps", "code"),
    [
        ("gian = 1", "E0209"),
        ("poses = 1", "E0209"),
        ("globals.scale = 1", "E0209"),
        ("gain = [1, 2]", "E0310"),
        ("gain = true", "E0310"),
        ("max_iters = -1", "E0310"),
        ("rel_precision = true", "E0310"),
        ("gain = missing", "E0201"),
        ("gain = 1 / 0", "E0309"),
        ("gain = 1\n gain = 2", "E0207"),
        ("freeze poses.eaa", "E0405"),
        ("freeze pose", "E0405"),
        ("freeze cameras", "E0411"),
        ("freeze poses.w", "E0411"),
    ],
)
def test_wrong(steps: str, code: str) -> None:
    assert codes(MODEL.replace("STEPS", steps)) == [code]


def test_a_field_with_the_name_of_a_setting_is_ambiguous() -> None:
    text = """
    root Fit {
        param a: real
        patience: real
        constraint c { a * patience }
        solve { pass one { patience = 2 } }
    }
    """
    assert codes(text) == ["E0202"]
    assert codes(text.replace("{ patience = 2", "{ root.patience = 2")) == []


@pytest.mark.parametrize("name", sorted(SETTINGS - SWITCHES))
@pytest.mark.parametrize("value", [-1.0, 0, 1, 1.5, 2.0**31])
def test_settings_have_the_bounds_of_lm_config(name: str, value: float) -> None:
    text = "root R { param x: real\n constraint c { x }\n solve { pass a { NAME = VALUE } } }"
    whole = int(value) if float(value).is_integer() else value
    found = codes(text.replace("NAME", name).replace("VALUE", str(value)))
    assert found == (["E0310"] if refused(name, whole) else [])


def test_a_refused_setting_is_refused_by_lm_config() -> None:
    for name, value in (("max_iters", 0), ("rel_precision", -1.0)):
        assert refused(name, value)
        with pytest.raises(AraelError, match=name):
            LmConfig(**{name: value}).validate()  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["strategy", "ending", "damping", "observer", "lambda_ceiling"])
def test_settings_that_are_set_from_python_say_so(name: str) -> None:
    with pytest.raises(AraelError) as caught:
        checked(MODEL.replace("STEPS", f"{name} = 1"))
    (found,) = caught.value.diagnostics
    assert found.code == "E0209"
    assert found.help == (f"set it from Python: `model.solve({name}=...)`",)
