"""Calibration of a rig of two cameras, one with a fisheye lens, from pictures of a flat target.

    python camera_calibration.py [--views 15] [--seed 1] [--plot camera_calibration.png]
                                 [--data camera_calibration.json]

The model is `camera_calibration.arael` in this folder. Starts are rough: nominal focal lengths, no
distortion, the second camera at the place of the first, poses of the target from homographies.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import quat_from_matrix, rotation_from_vector

Array = NDArray[np.float64]

MODEL = Path(__file__).with_name("camera_calibration.arael")
SIGMA = 0.2
"""Noise of a corner in each direction [px]."""
SIZE = np.array([640, 480])
NOMINAL = (600.0, 300.0)
"""Focal lengths by the data sheets [px]."""


@dataclass(frozen=True)
class Lens:
    """One camera of the rig as it is.

    Attributes
    ----------
    name, fisheye : as in the model
    f, c, k : focal lengths, principal point (2,) [px], distortion (4,)
    t, v : rig to camera: translation (3,) [m], rotation vector (3,) [rad]
    """

    name: str
    fisheye: bool
    f: Array
    c: Array
    k: Array
    t: Array
    v: Array

    @property
    def intrinsics(self) -> Array:
        """Focal lengths, principal point, distortion (8,)."""
        return np.concatenate([self.f, self.c, self.k])


LENSES = (
    Lens("narrow", False, np.array([612.0, 609.0]), np.array([324.0, 236.0]),
         np.array([-0.28, 0.09, 1e-3, -5e-4]), np.zeros(3), np.zeros(3)),
    Lens("fisheye", True, np.array([281.0, 280.0]), np.array([316.0, 243.0]),
         np.array([0.02, -0.01, 4e-3, -1e-3]),
         np.array([-0.12, 0.01, 0.02]), np.array([0.03, -0.1, 0.02])),
)  # fmt: skip


def project(lens: Lens, points: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) in the frame of the rig."""
    p = points @ rotation_from_vector(lens.v).T + lens.t
    across, k = p[..., :2], lens.k
    if lens.fisheye:
        r = np.linalg.norm(across, axis=-1, keepdims=True)
        t = np.arctan2(r, p[..., 2:])
        bent = t * (1 + np.polyval([*k[::-1], 0], t**2))
        return np.asarray(lens.f * across / r * bent + lens.c)
    u = across / p[..., 2:]
    s = np.sum(u**2, axis=-1, keepdims=True)
    x, y = u[..., :1], u[..., 1:]
    off = np.concatenate(
        [2 * k[2] * x * y + k[3] * (s + 2 * x**2), k[2] * (s + 2 * y**2) + 2 * k[3] * x * y], -1
    )
    return np.asarray(lens.f * (u * (1 + k[0] * s + k[1] * s**2) + off) + lens.c)


@dataclass(frozen=True)
class Pictures:
    """Corners that were found in the pictures.

    Attributes
    ----------
    camera, view : numbers (n,)
    on : place on the target (n, 3) [m]
    pixel : measured (n, 2) [px]
    views : how many
    """

    camera: NDArray[np.int64]
    view: NDArray[np.int64]
    on: Array
    pixel: Array
    views: int


def simulate(views: int = 15, seed: int = 1) -> Pictures:
    """Pictures of a target of 9 by 7 corners; those outside of a picture are not found."""
    rng = np.random.default_rng(seed)
    board = np.array([[0.04 * i, 0.04 * j, 0.0] for i in range(-4, 5) for j in range(-3, 4)])
    tilt = rng.normal(0, 0.4, (views, 3))
    place = rng.uniform([-0.25, -0.2, 0.25], [0.25, 0.2, 0.6], (views, 3))
    points = np.einsum("vij,bj->vbi", rotation_from_vector(tilt), board) + place[:, None]
    parts = []
    for k, lens in enumerate(LENSES):
        pixel = project(lens, points) + rng.normal(0, SIGMA, (views, len(board), 2))
        view, corner = np.nonzero(np.all((pixel > 0) & (pixel < SIZE), axis=-1))
        parts.append((np.full(len(view), k), view, board[corner], pixel[view, corner]))
    camera, view, on, pixel = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Pictures(camera, view, on, pixel, views)


def rays(pixel: Array, nominal: float, fisheye: bool) -> Array:
    """Points (n, 2) at depth 1 that are seen at pixels (n, 2), by the data sheet."""
    u = (pixel - SIZE / 2) / nominal
    angle = np.linalg.norm(u, axis=1, keepdims=True)
    return u * np.tan(angle) / angle if fisheye else u


def pose_of_plane(on: Array, u: Array) -> tuple[Array, Array]:
    """Translation (3,) and rotation (3, 3) of a flat target from its homography.

    Parameters
    ----------
    on : corners on the target (n, 3), of which the third component is 0
    u : the same at depth 1 in the frame of the camera (n, 2)

    Z. Zhang, "A flexible new technique for camera calibration", IEEE PAMI 22, 2000, section 3.1.
    """
    flat = np.column_stack([on[:, :2], np.ones(len(on))])
    zero = np.zeros_like(flat)
    rows = np.vstack([
        np.hstack([flat, zero, -u[:, :1] * flat]),
        np.hstack([zero, flat, -u[:, 1:] * flat]),
    ])  # fmt: skip
    h = np.linalg.svd(rows)[2][-1].reshape(3, 3)
    h *= np.sign(h[2, 2]) / np.sqrt(np.linalg.norm(h[:, 0]) * np.linalg.norm(h[:, 1]))
    left, _, right = np.linalg.svd(np.column_stack([h[:, 0], h[:, 1], np.cross(h[:, 0], h[:, 1])]))
    return h[:, 2], left @ right


def starts(pictures: Pictures) -> tuple[Array, Array]:
    """Translations (v, 3) and rotations (v, 3, 3) of the target, by the camera that sees most."""
    found = []
    for view in range(pictures.views):
        rows = [(pictures.view == view) & (pictures.camera == k) for k in range(len(LENSES))]
        k = int(np.argmax([row.sum() for row in rows]))
        u = rays(pictures.pixel[rows[k]], NOMINAL[k], LENSES[k].fisheye)
        found.append(pose_of_plane(pictures.on[rows[k]], u))
    t, turn = zip(*found, strict=True)
    return np.array(t), np.array(turn)


def problem(pictures: Pictures) -> Any:
    """The problem at its rough start; the first camera is the frame of the rig."""
    rig: Any = arael.load(MODEL)(sigma=SIGMA)
    for lens, nominal in zip(LENSES, NOMINAL, strict=True):
        rig.cameras.append(name=lens.name, fisheye=lens.fisheye, f=[nominal] * 2, c=SIZE / 2)
    rig.cameras[0].mount.fixed = True
    t, turn = starts(pictures)
    rig.views.extend(board=np.hstack([t, quat_from_matrix(turn)]))
    rig.corners.extend(
        camera=pictures.camera, view=pictures.view, on=pictures.on, pixel=pictures.pixel
    )
    return rig


def intrinsics(rig: Any) -> tuple[list[str], Array, Array]:
    """Names, values (16,) and joint covariance (16, 16) of the intrinsics of both cameras."""
    wanted = [f"cameras[{k}].{part}" for k in range(2) for part in "fck"]
    covariance = rig.covariance()
    names = [name for one in wanted for name in covariance.names_of(one)]
    cameras = rig.cameras
    values = np.hstack([cameras.f.value, cameras.c.value, cameras.k.value]).ravel()
    return names, values, covariance.marginal(wanted)


def report(rig: Any, result: Any) -> list[str]:
    """Lines on the solution."""
    names, values, covariance = intrinsics(rig)
    sigma = np.sqrt(np.diag(covariance))
    true = np.concatenate([lens.intrinsics for lens in LENSES])
    residuals, parameters = rig.jacobian().shape
    lines = [
        f"{len(rig.corners)} corners in {len(rig.views)} views of {len(rig.cameras)} cameras",
        f"{result.status} after {result.iterations} iterations: cost {result.end_cost:.0f}, "
        f"{residuals} residuals, {parameters} parameters",
    ]
    for name, value, one, truth in zip(names, values, sigma, true, strict=True):
        digits = max(1 - int(np.floor(np.log10(one))), 0)  # two of the standard deviation
        lines.append(
            f"  {name:15} {value:10.{digits}f} +- {one:<8.{digits}f} "
            f"error {(value - truth) / one:+.1f} sigma"
        )
    mount = rig.cameras[1].mount
    off = 1e3 * np.linalg.norm(mount.translation - LENSES[1].t)
    lines.append(f"mount of the fisheye: error {off:.2f} mm")
    return lines


def plot(rig: Any, path: Path) -> str:
    """Draw the corners of both cameras with their residuals, and the correlations."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    names, _, covariance = intrinsics(rig)
    sigma = np.sqrt(np.diag(covariance))

    @styled
    def draw() -> Any:
        figure, (narrow, fish, joint) = new_figure(13.0, 4.2, columns=3)
        kinds = (("narrow", "Corner.narrow_lens"), ("fisheye", "Corner.fisheye_lens"))
        cameras = rig.corners.camera.rows
        for k, (axes, (name, label)) in enumerate(zip((narrow, fish), kinds, strict=True)):
            pixel = rig.corners.pixel[cameras == k]
            off = rig.residual_values(label).raw
            axes.plot(*pixel.T, ".", ms=2, color=GREY)
            axes.quiver(
                *pixel[::3].T, *off[::3].T, angles="xy", scale_units="xy", scale=0.02, color=BLUE
            )
            c = rig.cameras[k].c.value
            axes.plot(*c, "+", ms=10, color=ORANGE, label="principal point")
            axes.set(xlim=(0, SIZE[0]), ylim=(SIZE[1], 0), aspect="equal")
            axes.set(xlabel="x [px]", title=f"{name}: corners, residuals times 50")
        fish.legend(loc="lower right")
        shown = joint.imshow(covariance / np.outer(sigma, sigma), cmap="RdBu", vmin=-1, vmax=1)
        short = [name.split("].")[1] for name in names]
        joint.set_xticks(range(16), short, rotation=90, fontsize=7)
        joint.set_yticks(range(16), short, fontsize=7)
        joint.set_title("correlations: narrow, fisheye")
        figure.colorbar(shown, ax=joint)
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate pictures, calibrate, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--views", type=int, default=15)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problem, for `arael solve`")
    args = parser.parse_args(arguments)

    rig = problem(simulate(args.views, args.seed))
    if args.data:
        rig.write(args.data)
    result = rig.solve(rel_precision=1e-9)
    print("\n".join(report(rig, result)))
    if args.plot:
        print("wrote", plot(rig, args.plot))


if __name__ == "__main__":
    main()
