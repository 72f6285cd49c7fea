"""Residuals by own code against the same residuals written in the language."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from tests import optional

Array = Any

GRAPH = """
struct Pose {
    param t: vec2
    param th: angle
    constraint stay { [(t - t.value) * 1e-3, rad_diff(th, th.value) * 1e-3] }
}
struct Edge {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    d: vec2
    turn: real
    %s
}
root Graph { poses: list of Pose; edges: list of Edge }
"""
BETWEEN = (
    "constraint between { [a.th.rotation_matrix()' * (b.t - a.t) - d, sin(b.th - a.th - turn)] }"
)

BUNDLE = """
struct Camera {
    param r: quaternion
    param t: vec3
    constraint held { [(t - t.value) * 10, rotation_vector(r.value.conj() * r) * 10] }
}
struct Point {
    param pos: vec3
    constraint near { (pos - pos.value) * 0.01 }
}
struct View {
    camera: ref Camera in root.cameras
    point: ref Point in root.points
    pixel: vec2
    %s
}
root Bundle {
    cameras: list of Camera
    points: list of Point
    views: list of View
    param f: real = 500
    constraint focal { (f - 500) * 0.1 }
    marginalize points
}
"""
SEEN = """constraint seen {
    let p = camera.r.rotation_matrix() * point.pos + camera.t
    root.f * [p.x, p.y] / p.z - pixel
}"""


def between(ta: Array, tha: Array, tb: Array, thb: Array, d: Array, turn: Array) -> Any:
    """Residuals and Jacobians of `BETWEEN`; steps of angles are added."""
    c, s = np.cos(tha), np.sin(tha)
    rotation = np.stack((np.stack((c, s), 1), np.stack((-s, c), 1)), 1)
    rate = np.stack((np.stack((-s, c), 1), np.stack((-c, -s), 1)), 1)
    v = tb - ta
    n = len(ta)
    residuals = np.zeros((n, 3))
    residuals[:, :2] = np.einsum("nij,nj->ni", rotation, v) - d
    residuals[:, 2] = np.sin(thb - tha - turn)
    j = [np.zeros((n, 3, 2)), np.zeros((n, 3)), np.zeros((n, 3, 2)), np.zeros((n, 3))]
    j[0][:, :2], j[2][:, :2] = -rotation, rotation
    j[1][:, :2] = np.einsum("nij,nj->ni", rate, v)
    j[1][:, 2] = -np.cos(thb - tha - turn)
    j[3][:, 2] = np.cos(thb - tha - turn)
    return residuals, j


def between_alone(*values: Array, **data: Array) -> Array:
    return between(*values, **data)[0]


def between_jacobian(*values: Array, **data: Array) -> Array:
    return between(*values, **data)[1]


def seen(r: Array, t: Array, pos: Array, f: Array, pixel: Array) -> Any:
    """Residuals and Jacobians of `SEEN` by the stored scalars, that of `r` a quaternion."""
    w, v = r[:, :1], r[:, 1:]
    cross = np.cross(v, pos)
    # R(q) x = x + 2 w (v x x) + 2 v x (v x x), as a polynomial of q.
    p = pos + 2 * w * cross + 2 * np.cross(v, cross) + t
    eye = np.eye(3)[None]

    def skew(x: Array) -> Array:
        return np.cross(np.broadcast_to(eye, (len(x), 3, 3)), -x[:, None, :]).transpose(0, 2, 1)

    by_r = np.zeros((len(r), 3, 4))
    by_r[:, :, 0] = 2 * cross
    by_r[:, :, 1:] = -2 * w[:, :, None] * skew(pos) - 2 * (skew(cross) + skew(v) @ skew(pos))
    by_pos = eye + 2 * w[:, :, None] * skew(v) + 2 * skew(v) @ skew(v)
    z = p[:, 2]
    project = np.zeros((len(r), 2, 3))
    project[:, 0, 0] = project[:, 1, 1] = f / z
    project[:, :, 2] = -f[:, None] * p[:, :2] / z[:, None] ** 2
    residuals = f[:, None] * p[:, :2] / z[:, None] - pixel
    return residuals, [project @ by_r, project, project @ by_pos, p[:, :2] / z[:, None]]


def graph(load: Any, precision: str, language: bool, loss: str = "", how: str = "both") -> Any:
    rng = np.random.default_rng(5)
    n = 12
    th = np.linspace(-3, 3, n)
    t = np.cumsum(np.stack((np.cos(th), np.sin(th)), 1), axis=0)
    a = np.r_[0 : n - 1, 0, 2, 5]
    b = np.r_[1:n, 6, 9, 11]
    data = {
        "d": rng.normal(size=(len(a), 2)) * 0.1 + np.array([1, 0]),
        "turn": rng.normal(size=len(a)) * 0.1,
    }
    clause = BETWEEN.replace("{ [", f"loss {loss} {{ [") if loss else BETWEEN
    model = load(GRAPH % (clause if language else ""), precision)()
    model.poses.extend(t=t, th=th)
    if language:
        model.edges.extend(a=a, b=b, **data)
        return model
    at, to = model.poses[a], model.poses[b]
    model.add_residuals(
        {"both": between}.get(how, between_alone),
        [at.t, at.th, to.t, to.th],
        3,
        data=data,
        jacobian=between_jacobian if how == "apart" else None,
        loss=loss or None,
        name="between",
    )
    return model


def bundle(load: Any, precision: str, language: bool) -> Any:
    rng = np.random.default_rng(3)
    model = load(BUNDLE % (SEEN if language else ""), precision)()
    q = np.c_[np.ones(3), rng.normal(size=(3, 3)) * 0.2]
    model.cameras.extend(r=q / np.linalg.norm(q, axis=1)[:, None], t=rng.normal(size=(3, 3)) * 0.1)
    model.points.extend(pos=rng.normal(size=(9, 3)) + np.array([0, 0, 6]))
    camera, point = (x.ravel() for x in np.meshgrid(np.arange(3), np.arange(9)))
    here = seen(
        model.cameras.r.value[camera], model.cameras.t.value[camera],
        model.points.pos.value[point], np.full(27, 500.0), np.zeros((27, 2)),
    )  # fmt: skip
    pixel = here[0] + rng.normal(size=(27, 2))
    model.cameras.t.value = model.cameras.t.value + rng.normal(size=(3, 3)) * 0.01
    model.points.pos.value = model.points.pos.value + rng.normal(size=(9, 3)) * 0.1
    if language:
        model.views.extend(camera=camera, point=point, pixel=pixel)
        return model
    at = model.cameras[camera]
    model.add_residuals(
        seen,
        [at.r, at.t, model.points[point].pos, model.f],
        2,
        data={"pixel": pixel},
        coordinates="ambient",
    )
    return model


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Load a text once; compiled if asked."""
    loaded: dict[tuple[str, str, bool], Any] = {}

    def loader(text: str, precision: str, compiled: bool = False) -> Any:
        key = text, precision, compiled
        if key not in loaded:
            folder: Path = tmp_path_factory.mktemp("models")
            (folder / "m.arael").write_text(text, encoding="utf-8")
            loaded[key] = arael.load(
                folder / "m.arael",
                precision=precision,  # type: ignore[arg-type]
                interpret=not compiled,
            )
        return loaded[key]

    return loader


def assert_equal(found: Any, expected: Any, tolerance: float) -> None:
    assert found.cost() == pytest.approx(expected.cost(), rel=tolerance)
    for a, b in (
        (found.gradient(), expected.gradient()),
        (found.hessian(), expected.hessian()),
    ):
        np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * np.abs(b).max())


MAKERS = {"graph": graph, "bundle": bundle}
TOLERANCE = {"f64": 1e-10, "f32": 5e-5}


@pytest.mark.sweep(
    slow=(
        "bundle-f64-True",
        "bundle-f32-True",
        "graph-f32-True",
        "bundle-f32-False",
        "bundle-f64-False",
    )
)
@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("which", MAKERS)
def test_like_the_language(load: Any, which: str, precision: str, compiled: bool) -> None:
    def loads(text: str, precision: str) -> Any:
        return load(text, precision, compiled)

    expected = MAKERS[which](loads, precision, True)
    found = MAKERS[which](loads, precision, False)
    assert_equal(found, expected, TOLERANCE[precision])
    found.solve(rel_precision=1e-14, max_iters=60)
    expected.solve(rel_precision=1e-14, max_iters=60)
    # In f32 both stop where rounding hides what is left to gain.
    tolerance = {"f64": 1e-10, "f32": 1e-2}[precision]
    assert found.cost() == pytest.approx(expected.cost(), rel=tolerance)
    if precision == "f64":
        np.testing.assert_allclose(found.serialize(), expected.serialize(), rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    "solver", optional.solvers(["dense", "band", "sparse", "schur", "cholmod"])
)
@pytest.mark.parametrize("which", MAKERS)
def test_every_linear_solver(load: Any, which: str, solver: str) -> None:
    found, expected = MAKERS[which](load, "f64", False), MAKERS[which](load, "f64", True)
    # One path for both: along a valley, ends differ by more than rounding between paths.
    found.solve(solver=solver, rel_precision=1e-14, max_iters=60, strategy="dogleg")
    expected.solve(solver=solver, rel_precision=1e-14, max_iters=60, strategy="dogleg")
    assert found.cost() == pytest.approx(expected.cost(), rel=1e-10)
    np.testing.assert_allclose(found.serialize(), expected.serialize(), rtol=0, atol=1e-8)


@pytest.mark.parametrize("loss", ["huber(0.5)", "cauchy(0.3)", "|s| log(1 + s)"])
def test_losses_by_name(load: Any, loss: str) -> None:
    found, expected = graph(load, "f64", False, loss), graph(load, "f64", True, loss)
    assert_equal(found, expected, 1e-12)
    a, b = found.residual_values("between"), expected.residual_values("Edge.between")
    np.testing.assert_allclose(a.robust, b.robust, atol=1e-14)
    np.testing.assert_allclose(a.whitened, b.whitened, atol=1e-14)


def test_jacobians_from_a_function_of_their_own(load: Any) -> None:
    assert_equal(graph(load, "f64", False, how="apart"), graph(load, "f64", True), 1e-12)


def test_differences_on_the_tangent(load: Any, caplog: pytest.LogCaptureFixture) -> None:
    found, expected = graph(load, "f64", False, how="alone"), graph(load, "f64", True)
    assert found.residuals.code["between"].derivatives == "unknown"
    assert_equal(found, expected, 1e-8)
    assert found.residuals.code["between"].derivatives == "differences"
    note = "derivatives of `between` are central differences"
    assert note in str(found.report())
    with caplog.at_level("INFO", logger="arael.solve"):
        found.solve()
    assert any(note in record.getMessage() for record in caplog.records)


def test_differences_of_quaternions(load: Any) -> None:
    expected = bundle(load, "f64", True)
    found = bundle(load, "f64", False)
    found.residuals.remove("seen")
    views = expected.views
    at = found.cameras[views.camera.rows]
    found.add_residuals(
        lambda *values, pixel: seen(*values, pixel=pixel)[0],
        [at.r, at.t, found.points[views.point.rows].pos, found.f],
        2,
        data={"pixel": views.pixel},
        name="seen",
    )
    assert_equal(found, expected, 1e-7)


def test_threads_and_components(load: Any) -> None:
    """Many instances in several shares, in a problem of two parts that are solved separately."""
    models = []
    for language in (True, False):
        model = load(GRAPH % (BETWEEN if language else ""), "f64", True)()
        n = 400
        model.poses.extend(t=np.c_[np.arange(n), np.zeros(n)], th=np.zeros(n))
        a = np.r_[0 : n // 2 - 1, n // 2 : n - 1]
        data = {"d": np.c_[np.ones(len(a)), 0.01 * np.arange(len(a))], "turn": np.full(len(a), 0.1)}
        if language:
            model.edges.extend(a=a, b=a + 1, **data)
        else:
            at, to = model.poses[a], model.poses[a + 1]
            model.add_residuals(between, [at.t, at.th, to.t, to.th], 3, data=data)
        result = model.solve(num_threads=2, rel_precision=1e-12)
        models.append((model, result))
    (expected, one), (found, other) = models
    assert one.components is not None and other.components is not None
    assert found.cost() == pytest.approx(expected.cost(), rel=1e-9)
