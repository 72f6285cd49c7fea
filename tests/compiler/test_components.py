"""Components: the built-in parameter types written in the language, nesting, updates, formulas."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arael.loading import load
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

Array = np.ndarray[Any, Any]
SLOW = pytest.mark.slow(reason="compiles for half a minute")
TIGHT = {"abs_precision": 1e-15, "rel_precision": 1e-15, "max_iters": 60}


def model_of(tmp_path: Path, text: str, name: str = "model", **options: Any) -> type[Model]:
    path = tmp_path / f"{name}.arael"
    path.write_text(text)
    return load(path, **options)


def turns(rng: np.random.Generator, n: int, size: float = 1.0) -> Array:
    """Random rotations as (n, 4), w first."""
    return np.roll(Rotation.from_rotvec(size * rng.normal(size=(n, 3))).as_quat(), 1, axis=1)


# --- the built-in types, written as components ----------------------------------------------------

COMPONENTS = """
component Vector { param v: vec3 }

component Heading {
    param a: real
    symbolic R = rotation_matrix(a)
    update { a = rad_diff(a, 0) }
}

component Euler {
    param rpy: vec3
    symbolic R = rotation_matrix(rpy)
}

component Turn {
    param d: vec3 = [0, 0, 0]
    base: quat
    symbolic q = base * exp(d)
    symbolic R = q.rotation_matrix()
    update { base = q; d = 0 }
}
"""

BUILT_IN = {"Vector": "vec3", "Heading": "angle", "Euler": "euler", "Turn": "quaternion"}

SCENE = """
struct Pose {{
    param p: {Vector}
    param h: {Heading}
    param e: {Euler}
    param q: {Turn}
    constraint prior {{ [0.1 * {p}, 0.2 * {h}, 0.1 * {e}, 0.3 * ({q}).log()] }}
}}
struct Sight {{
    s: ref Pose in root.poses
    x: vec3
    seen: vec3
    flat: vec2
    constraint near {{ {R} * x + {sp} - seen }}
    constraint turned {{ {E}' * x - {sp} + seen }}
    constraint planar {{ {H} * x2 - flat }}
    x2: vec2
}}
root World {{ poses: list of Pose; sights: list of Sight }}
"""

WITH_BUILT_IN = SCENE.format(
    **BUILT_IN, p="p", h="h", e="e", q="q", sp="s.p",
    R="s.q.rotation_matrix()", E="s.e.rotation_matrix()", H="s.h.rotation_matrix()",
)  # fmt: skip
WITH_COMPONENTS = COMPONENTS + SCENE.format(
    **{name: name for name in BUILT_IN}, p="p.v", h="h.a", e="e.rpy", q="q.q", sp="s.p.v",
    R="s.q.R", E="s.e.R", H="s.h.R",
)  # fmt: skip


def scenes(tmp_path: Path, **options: Any) -> tuple[Model, Model]:
    """The same problem with built-in types and with components."""
    built_in = model_of(tmp_path, WITH_BUILT_IN, "builtin", **options)()
    written = model_of(tmp_path, WITH_COMPONENTS, "written", **options)()
    rng = np.random.default_rng(3)
    n, m = 4, 40
    p, h, e = rng.normal(size=(n, 3)), rng.uniform(-3, 3, n), rng.normal(size=(n, 3))
    q = turns(rng, n)
    built_in.poses.extend(p=p, h=h, e=e, q=q)
    written.poses.extend(n, **{"p.v": p, "h.a": h, "e.rpy": e, "q.base": q})
    sights = {
        "x": rng.normal(size=(m, 3)),
        "seen": rng.normal(size=(m, 3)),
        "x2": rng.normal(size=(m, 2)),
        "flat": rng.normal(size=(m, 2)),
    }
    for model in (built_in, written):
        model.sights.extend(s=np.arange(m) % n, **sights)
    return built_in, written


def values(model: Model) -> list[Array]:
    """Positions, headings, Euler angles, quaternions."""
    if "v" in dir(model.poses.p):
        q = np.array(model.poses.q.base)
        found = [model.poses.p.v.value, model.poses.h.a.value, model.poses.e.rpy.value]
    else:
        q = np.array(model.poses.q.value)
        found = [model.poses.p.value, model.poses.h.value, model.poses.e.value]
    return [*map(np.array, found), q]


@pytest.mark.sweep(slow=("f64-False", "f64-True"))
@pytest.mark.parametrize(
    ("precision", "interpret"),
    [("f64", False), ("f64", True), ("f32", True), pytest.param("f32", False, marks=SLOW)],
)
def test_built_in_types_written_as_components(
    tmp_path: Path, precision: str, interpret: bool
) -> None:
    built_in, written = scenes(tmp_path, precision=precision, interpret=interpret)
    tight = 1e-12 if precision == "f64" else 2e-5
    for model in (built_in, written):
        assert model.cost() == pytest.approx(built_in.cost(), rel=tight)
    scale = np.abs(built_in.hessian()).max()
    np.testing.assert_allclose(written.gradient(), built_in.gradient(), atol=tight * scale, rtol=0)
    np.testing.assert_allclose(written.hessian(), built_in.hessian(), atol=tight * scale, rtol=0)

    start = written.cost()
    for iterations in (1, 3, 60):
        one = built_in.solve(abs_precision=1e-14, rel_precision=1e-14, max_iters=iterations)
        other = written.solve(abs_precision=1e-14, rel_precision=1e-14, max_iters=iterations)
        loose = tight if iterations == 1 else 1e3 * tight
        assert other.cost == pytest.approx(one.cost, rel=loose)
        for found, expected in zip(values(written), values(built_in), strict=True):
            np.testing.assert_allclose(found, expected, atol=100 * loose, rtol=0)
    assert other.cost < 0.9 * start


# --- nesting, places, updates ---------------------------------------------------------------------

NESTED = """
component UnitVec {
    param d: vec2 = [0, 0]
    base: mat3
    symbolic dir = base * unit([1, d.x, d.y])
    compute  first = base.col(0)
    update {
        base = base * rotation_matrix([0, -atan2(d.y, hypot(1, d.x)), atan(d.x)])
        d = 0
    }
}

component Frame {
    param pos: vec3
    param axis: UnitVec
    param turn: angle
    gain: real = 1
    param rig: transform
    symbolic tip = pos + gain * axis.dir
    symbolic ahead = rig * (axis.dir + [cos(turn), sin(turn), 0])
    symbolic far = dot(axis.dir, pos) * tip
    symbolic up = pos.z > 0
}

struct Mount {
    param frame: Frame
    param scale: real
    weight: real
    constraint weak { 0.3 * [frame.pos, frame.axis.dir, frame.turn, frame.rig.log(), scale - 1] }
}

struct Robot {
    mount: Mount
    spare: Mount?
    marks: list of Mark
    constraint home { mount.weight * (mount.frame.tip - [0.1, 0.2, 0.3]) }
    constraint both when spare { spare.frame.ahead - mount.frame.ahead * spare.scale }
}

struct Mark {
    param dir: UnitVec
    seen: vec3
    constraint seen {
        let frame = parent.mount.frame
        [0.3 * (0.2 * frame.far + frame.rig * dir.dir - seen),
         dot(dir.dir, root.north.dir) - 0.3,
         if frame.gain > 1 then dir.dir.x else dir.dir.y]
    }
    constraint low loss huber(0.1) { dir.dir - root.north.dir }
}

root World {
    param north: UnitVec
    robots: list of Robot
    constraint tilt { north.dir - [0, 0.6, 0.8] }
}
"""


def frame(rng: np.random.Generator) -> dict[str, Any]:
    """Data of a `Frame`."""
    return {
        "pos": rng.normal(size=3),
        "axis": {"base": Rotation.from_rotvec(rng.normal(size=3)).as_matrix()},
        "turn": rng.uniform(-3, 3),
        "gain": 2.0,
        "rig": np.concatenate([rng.normal(size=3), turns(rng, 1)[0]]),
    }


def nested(tmp_path: Path, text: str = NESTED, **options: Any) -> Model:
    """Components in the root, in structs by value and optional, in nested lists, in components."""
    rng = np.random.default_rng(8)
    model = model_of(tmp_path, text, **options)(north={"base": np.eye(3)})
    for i in range(3):
        mount = {"frame": frame(rng), "scale": 1.1, "weight": 0.7}
        spare = {"frame": frame(rng), "scale": 0.9, "weight": 0.7} if i else None
        robot = model.robots.append(mount=mount, spare=spare)
        for _ in range(4):
            base = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
            robot.marks.append(dir={"base": base, "d": [0.1, -0.2]}, seen=rng.normal(size=3))
    return model


@pytest.mark.slow
def test_nested_components_against_interpreter_and_differences(tmp_path: Path) -> None:
    model = nested(tmp_path)
    check_against_oracle(model)
    check_against_differences(model)
    assert model.check_gradients()


@SLOW
def test_single_precision(tmp_path: Path) -> None:
    check_against_oracle(nested(tmp_path, precision="f32"), 2e-5)


def test_solve_leaves_deltas_at_zero_and_charts_moved(tmp_path: Path) -> None:
    model = nested(tmp_path)
    start = model.cost()
    bases = np.array(model.robots.marks.dir.base)
    result = model.solve(abs_precision=1e-13, rel_precision=1e-13, max_iters=200)
    assert result.cost < 0.5 * start
    assert model.cost() == pytest.approx(result.cost, rel=1e-6)
    assert (model.robots.marks.dir.d.value == 0).all()
    assert np.abs(model.robots.marks.dir.base - bases).max() > 0.01
    product = np.einsum("nij,nkj->nik", *2 * [np.array(model.robots.marks.dir.base)])
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), atol=1e-12)
    np.testing.assert_allclose(model.gradient(), 0, atol=1e-4)


def test_what_does_not_move_is_not_updated(tmp_path: Path) -> None:
    model = nested(tmp_path)
    marks = model.robots.marks
    marks[0].dir.d.fixed = True
    bases = np.array(marks.dir.base)
    model.solve(max_iters=5)
    np.testing.assert_array_equal(marks[0].dir.d.value, [0.1, -0.2])
    np.testing.assert_array_equal(marks[0].dir.base, bases[0])
    assert (np.array(marks.dir.d.value)[1:] == 0).all()


def test_an_update_takes_a_held_delta_along(tmp_path: Path) -> None:
    text = """
    component Pair {
        param a: real
        param d: real
        base: real
        symbolic b = base + d
        update { base = b; d = 0 }
    }
    root R {
        param p: Pair
        constraint c { [p.a - 3, p.b - 7] }
    }
    """
    model = model_of(tmp_path, text)(p={"a": 1, "d": {"value": 0.5, "fixed": True}, "base": 2})
    model.solve()
    assert model.p.a.value == pytest.approx(3)
    assert (model.p.base, model.p.d.value, model.p.b) == (2.5, 0.0, 2.5)


def test_updates_run_one_after_the_other_and_keep_bounds(tmp_path: Path) -> None:
    text = """
    component Counted {
        param x: real in 0 .. 5
        param v: vec2 in [-1, -1] .. [1, 2]
        last: real
        sum: real
        steps: real = 0
        update { steps = steps + 1; last = steps; sum = sum + last; v = 9 }
    }
    root R {
        param c: Counted
        constraint pull { [c.x - 2, c.v - [3, 3]] }
    }
    """
    for interpret in (False, True):
        model = model_of(tmp_path, text, interpret=interpret)(
            c={"x": 1, "v": [0, 0], "last": 0, "sum": 0}
        )
        result = model.solve(abs_precision=0, rel_precision=1e-30, max_iters=3, min_iters=3)
        count = result.accepted_iterations
        assert count >= 1
        assert (model.c.steps, model.c.last, model.c.sum) == (count, count, count * (count + 1) / 2)
        np.testing.assert_array_equal(model.c.v.value, [1, 2])


# --- from Python and in files ---------------------------------------------------------------------


def test_formulas_are_read_from_python(tmp_path: Path) -> None:
    model = nested(tmp_path)
    robots = model.robots
    base, d = np.array(robots.marks.dir.base), np.array([1, 0.1, -0.2])
    expected = base @ d / np.linalg.norm(d)
    np.testing.assert_allclose(robots.marks.dir.dir, expected, atol=1e-15)
    np.testing.assert_allclose(robots.marks[5].dir.dir, expected[5], atol=1e-15)
    np.testing.assert_array_equal(robots.marks[5].dir.first, base[5, :, 0])
    one = robots[1].mount.frame
    tip = one.pos.value + 2 * base_dir(one)
    np.testing.assert_allclose(one.tip, tip, atol=1e-15)
    np.testing.assert_allclose(robots["mount.frame.tip"][1], tip, atol=1e-15)
    assert robots[0].spare is None
    assert one.up is bool(one.pos.value[2] > 0)
    assert robots.mount.frame.up.dtype == bool
    assert {"tip", "ahead", "far", "up", "pos", "axis"} <= set(dir(one))
    with pytest.raises(AttributeError, match="is a formula"):
        one.tip = [0, 0, 0]


def base_dir(one: Any) -> Array:
    """First column of the chart, where the delta is zero."""
    return np.array(one.axis.base)[:, 0]


def test_through_json(tmp_path: Path) -> None:
    model = nested(tmp_path)
    model.robots.marks[2].dir.d.fixed = True
    model.solve(max_iters=4)
    path = tmp_path / "data.json"
    model.write(path)
    written = json.loads(path.read_text())
    assert set(written["robots"][0]["mount"]["frame"]["axis"]) == {"d", "base"}
    other = type(model)()
    other.read(path)
    assert other.cost() == pytest.approx(model.cost(), rel=1e-12)
    np.testing.assert_array_equal(other.robots.marks.dir.base, model.robots.marks.dir.base)
    assert other.robots.marks[2].dir.d.fixed
    other.write(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == path.read_text()


def test_freezing(tmp_path: Path) -> None:
    model = nested(tmp_path)
    names = model.parameter_names()
    assert "robots[1].mount.frame.axis.d.x" in names and "north.d.y" in names
    model.robots.mount.frame.axis.d.optimize = False
    assert not any("mount.frame.axis" in name for name in model.parameter_names())
    bases = np.array(model.robots.mount.frame.axis.base)
    pos = np.array(model.robots.mount.frame.pos.value)
    model.solve(max_iters=4)
    np.testing.assert_array_equal(model.robots.mount.frame.axis.base, bases)
    assert np.abs(model.robots.mount.frame.pos.value - pos).min() > 0


def test_passes_freeze_components(tmp_path: Path) -> None:
    schedule = """
    solve {
        pass first { freeze north freeze robots.mount.frame }
        pass second { freeze north freeze robots.mount.frame free robots.mount.frame.axis }
    }
    constraint tilt"""
    text = NESTED.replace("    constraint tilt", schedule)
    model = nested(tmp_path, text, interpret=True)
    base, north = np.array(model.robots.mount.frame.axis.base), np.array(model.north.base)
    pos = np.array(model.robots.mount.frame.pos.value)
    model.solve(passes="first")
    np.testing.assert_array_equal(model.robots.mount.frame.axis.base, base)
    model.solve(passes=["first", "second"])
    np.testing.assert_array_equal(model.north.base, north)
    np.testing.assert_array_equal(model.robots.mount.frame.pos.value, pos)
    assert np.abs(model.robots.mount.frame.axis.base - base).max() > 1e-3


def test_covariance(tmp_path: Path) -> None:
    model = nested(tmp_path)
    model.solve(abs_precision=1e-12, rel_precision=1e-12, max_iters=200)
    names = model.parameter_names()
    covariance = model.covariance()
    full = 2 * np.linalg.inv(model.hessian())
    np.testing.assert_allclose(covariance.matrix, full, rtol=1e-6, atol=1e-9 * full.max())
    at = [names.index(f"robots[1].marks[2].dir.d.{axis}") for axis in "xy"]
    marginal = covariance.marginal(model.robots[1].marks[2])
    np.testing.assert_allclose(marginal, full[np.ix_(at, at)], rtol=1e-6)
    frame_of = [i for i, name in enumerate(names) if name.startswith("robots[2].mount.frame.")]
    every = covariance.marginals("robots.mount.frame")
    np.testing.assert_allclose(
        every[2], full[np.ix_(frame_of, frame_of)], rtol=1e-6, atol=1e-9 * full.max()
    )


@pytest.mark.slow
def test_guards_over_formulas(tmp_path: Path) -> None:
    text = """
    component Gate {
        param x: real
        symbolic open = x > 1
        compute near = abs(x) < 3
    }
    root R {
        param g: Gate
        constraint a when g.open { g.x - 2 }
        constraint b when g.near and not g.open { 5 * g.x }
        constraint c { 0.1 * g.x }
    }
    """
    for interpret in (False, True):
        model = model_of(tmp_path, text, interpret=interpret)(g={"x": 4})
        assert model.cost() == pytest.approx(2**2 + 0.16)
        model.g.x = 0.5
        assert model.cost() == pytest.approx(2.5**2 + 0.0025)
        assert (model.g.open, model.g.near) == (False, True)


@pytest.mark.parametrize("interpret", [True, pytest.param(False, marks=SLOW)])
def test_stored_value_of_a_formula(tmp_path: Path, interpret: bool) -> None:
    text = NESTED.replace(
        "constraint home {",
        "constraint drift { mount.frame.tip - mount.frame.tip.value }\n    constraint home {",
    )
    model = nested(tmp_path, text, interpret=interpret)
    plain = nested(tmp_path, interpret=interpret)
    assert model.cost() == pytest.approx(plain.cost(), rel=1e-12)
    assert model.check_gradients()
    if not interpret:
        check_against_differences(model)
    start = np.array(model.robots.mount.frame.tip)
    model.solve(max_iters=8)
    plain.solve(max_iters=8)
    moved = np.linalg.norm(model.robots.mount.frame.tip - start, axis=1)
    free = np.linalg.norm(plain.robots.mount.frame.tip - start, axis=1)
    assert (moved < free).all()


def test_runtime_residuals_see_what_is_carried_along(tmp_path: Path) -> None:
    text = """
    component Sum {
        param d: real = 0
        base: real
        symbolic all = base + d
        update { base = all; d = 0 }
    }
    root R {
        param s: Sum
        constraint c { 0.01 * s.all }
    }
    """
    model = model_of(tmp_path, text)(s={"base": 1})
    model.residuals.add("s.base + s.d - 5")
    assert model.cost() == pytest.approx(16 + 1e-4)
    model.solve()
    assert model.s.d.value == 0
    assert model.s.base == pytest.approx(5, rel=1e-3)


def test_freezing_by_the_name_of_a_component(tmp_path: Path) -> None:
    model = nested(tmp_path)
    bases = np.array(model.robots.marks.dir.base)
    pos = np.array(model.robots.mount.frame.pos.value)
    model.solve(freeze="UnitVec", max_iters=3)
    np.testing.assert_array_equal(model.robots.marks.dir.base, bases)
    np.testing.assert_array_equal(model.robots.marks.dir.d.value[0], [0.1, -0.2])
    assert np.abs(model.robots.mount.frame.pos.value - pos).min() > 0
    model.solve(freeze="Frame", max_iters=3)
    assert np.abs(model.robots.marks.dir.base - bases).max() > 1e-3
