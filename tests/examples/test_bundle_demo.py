"""bundle_demo against SciPy on a reprojection written by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.examples.scripts import printed, script
from tests.public_data import public


def by_hand(x: np.ndarray, ring, base: Rotation) -> np.ndarray:
    """Residuals (2k,) of cameras (rotation vector on top of `base`, t, f, k1, k2) and points."""
    n = len(ring.centre)
    cameras, points = x[: 9 * n].reshape(n, 9), x[9 * n :].reshape(-1, 3)
    turned = (base * Rotation.from_rotvec(cameras[:, :3]))[ring.camera]
    p = turned.apply(points[ring.point]) + cameras[ring.camera, 3:6]
    u = -p[:, :2] / p[:, 2:]
    f, k1, k2 = cameras[ring.camera, 6:].T[:, :, None]
    r2 = np.sum(u * u, axis=1, keepdims=True)
    return (f * (1 + k1 * r2 + k2 * r2 * r2) * u - ring.pixel).ravel()


def test_the_optimum_is_that_of_scipy() -> None:
    module = script("bundle_demo")
    ring = module.make_ring(4, 30, seed=3)
    ba = module.problem(ring, seed=3)
    base = Rotation.from_quat(np.asarray(ba.cameras.r.value)[:, [1, 2, 3, 0]])
    lens = [np.asarray(getattr(ba.cameras, name).value)[:, None] for name in ("f", "k1", "k2")]
    start = np.hstack([np.zeros((4, 3)), np.asarray(ba.cameras.t.value), *lens])
    x = np.concatenate([start.ravel(), np.asarray(ba.points.pos.value).ravel()])
    assert ba.cost() == pytest.approx(np.sum(by_hand(x, ring, base) ** 2), rel=1e-12)
    found = least_squares(by_hand, x, args=(ring, base), x_scale="jac", xtol=1e-12, ftol=1e-12)
    result = ba.solve(rel_precision=1e-12)
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-6)


def test_points_and_lenses_are_found() -> None:
    module = script("bundle_demo")
    ring = module.make_ring(12, 400, seed=1)
    ba = module.problem(ring, seed=1)
    assert ba.solve().status == "converged"
    # Two residuals a detection, less nine unknowns a camera and three a point, plus the gauge.
    freedom = 2 * len(ring.camera) - 9 * 12 - 3 * 400 + 7
    assert ba.cost() == pytest.approx(freedom * module.NOISE**2, rel=0.08)
    assert np.abs(np.asarray(ba.cameras.f.value) - module.FOCAL).max() < 3
    assert "RMS 1.96 mm" in module.compare(ba, ring)


def test_a_public_problem(monkeypatch, capsys, tmp_path) -> None:
    path = public("bundle_adjustment/problem-49-7776-pre.txt")
    saved = tmp_path / "solved.txt"
    out = printed("bundle_demo", [str(path), "--save", str(saved)], monkeypatch, capsys)
    assert "49 cameras, 7776 points, 31843 observations" in out
    assert "-> 26688.5, RMS 0.915 px" in out
    again = printed("bundle_demo", [str(saved)], monkeypatch, capsys)
    assert "RMS 0.92 px at the start" in again
