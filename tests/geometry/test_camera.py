"""The pinhole camera against the formulas written out, and against its own inverse."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.geometry import PinholeCamera, level_axes

RNG = np.random.default_rng(7)
CAMERA = PinholeCamera(
    fx=600.0, fy=580.0, cx=330.0, cy=230.0, width=640, height=480,
    pos=np.array([0.2, -0.1, 0.4]), axes=level_axes(0.3), min_depth=0.5,
)  # fmt: skip


def test_projection_by_hand() -> None:
    x, y, z = 0.4, -0.2, 2.5
    c, s = math.cos(0.3), math.sin(0.3)
    right, down, ahead = (s, -c, 0), (0, 0, -1), (c, s, 0)
    point = [p + x * r + y * d + z * a
             for p, r, d, a in zip(CAMERA.pos, right, down, ahead, strict=True)]  # fmt: skip
    pixel, visible = CAMERA.project(point)
    assert pixel == pytest.approx([600 * x / z + 330, 580 * y / z + 230])
    assert visible.shape == () and visible


def test_unproject_is_the_inverse_of_project() -> None:
    pixel = RNG.uniform((0, 0), (640, 480), (4, 50, 2))
    depth = RNG.uniform(0.6, 40, (4, 50))
    points = CAMERA.unproject(pixel, depth)
    again, visible = CAMERA.project(points)
    assert again == pytest.approx(pixel)
    assert visible.all()
    rays = CAMERA.rays(pixel)
    away = points - CAMERA.pos
    assert rays == pytest.approx(away / np.linalg.norm(away, axis=-1, keepdims=True))


def test_visible_needs_depth_and_image() -> None:
    ahead, right = CAMERA.axes[:, 2], CAMERA.axes[:, 0]
    edge = (640 - 330) / 600
    points = CAMERA.pos + np.array(
        [ahead, -ahead, 0.49 * ahead, 0.51 * ahead,
         ahead + (edge - 1e-6) * right, ahead + (edge + 1e-6) * right]
    )  # fmt: skip
    assert CAMERA.visible(points).tolist() == [True, False, False, True, True, False]
    assert np.isnan(CAMERA.project(points)[0][1]).all()
    assert np.isfinite(CAMERA.project(points)[0][2]).all()  # too near, but it has a pixel


def test_axes_look_where_they_should() -> None:
    axes = level_axes(0.0)
    assert np.linalg.det(axes) == pytest.approx(1)
    camera = PinholeCamera.from_fov(640, 480, math.radians(90))
    left_and_up = camera.project([2.0, 0.5, 0.25])[0]
    assert left_and_up == pytest.approx([320 - 320 * 0.25, 240 - 320 * 0.125])


def test_field_of_view_ends_at_the_image() -> None:
    camera = PinholeCamera.from_fov(1024, 768, math.radians(80))
    ray = camera.rays([[0.0, 384.0], [1024.0, 384.0]])
    assert math.degrees(math.acos(ray[0] @ ray[1])) == pytest.approx(80)


def test_feature_frames() -> None:
    frames = CAMERA.feature_frames(RNG.uniform((0, 0), (640, 480), (20, 2)))
    assert np.swapaxes(frames, -1, -2) @ frames == pytest.approx(np.tile(np.eye(3), (20, 1, 1)))
    assert np.linalg.det(frames) == pytest.approx(1)
    assert frames[:, 2, 1] == pytest.approx(0)  # column 1 is level
    assert (frames[:, 2, 2] > 0).all()  # column 2 looks up


def test_angular_size_of_pixels_by_differences() -> None:
    pixel = RNG.uniform((0, 0), (640, 480), (20, 2))
    frames = CAMERA.feature_frames(pixel)
    step = 1e-4
    for axis, shift in ((1, [step, 0]), (2, [0, step])):
        moved = np.einsum("kji,kj->ki", frames, CAMERA.rays(pixel + np.array(shift)))
        angle = np.abs(np.arctan2(moved[:, axis], moved[:, 0])) / step
        assert CAMERA.pixel_angles(pixel)[:, axis - 1] == pytest.approx(angle, rel=1e-4)
    centre = CAMERA.pixel_angles([330.0, 230.0])
    assert centre == pytest.approx([1 / 600, 1 / 580])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fx": 0.0}, "`fx` is 0.0"),
        ({"height": -1}, "`height` is -1"),
        ({"axes": np.ones((3, 3))}, "not unit vectors at right angles"),
    ],
)
def test_impossible_cameras(change: dict[str, object], message: str) -> None:
    values = {"fx": 1.0, "fy": 1.0, "cx": 0.0, "cy": 0.0, "width": 2, "height": 2, **change}
    with pytest.raises(AraelError, match=message) as error:
        PinholeCamera(**values)  # type: ignore[arg-type]
    assert error.value.diagnostics[0].code == "E1032"


def test_degrees_for_radians() -> None:
    with pytest.raises(AraelError, match="`fov` is 80"):
        PinholeCamera.from_fov(640, 480, 80)
