"""Bundle adjustment: cameras, their lenses and points from pixels alone.

    python bundle_demo.py [problem.txt] [--cameras 12] [--points 400] [--seed 1]
                          [--save solved.txt] [--plot bundle_demo.png]

With a file, a BAL problem is read and solved. Without one, a ring of cameras around a cloud of
points is generated, with half a pixel of noise, and the solution is compared with the truth. The
model is `bundle_adjustment.arael` in this folder.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import rotation_matrix
from arael.scenes.evaluate import rms_distance, similarity

MODEL = Path(__file__).with_name("bundle_adjustment.arael")
RADIUS = 4.0
"""Distance of the ring's cameras from its centre; the points fill a cube of side 2 [m]."""
FOCAL, K1, K2 = 800.0, -0.05, 0.01
NOISE = 0.5
"""Standard deviation of a pixel's coordinates [px]."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ring:
    """A synthetic problem of n cameras and m points, and its truth.

    Attributes
    ----------
    rotation, centre : (n, 3, 3) world to camera, and (n, 3) [m]
    points : (m, 3) [m]
    camera, point, pixel : (k,), (k,) and (k, 2): camera, point and pixel of each observation [px]
    """

    rotation: Array
    centre: Array
    points: Array
    camera: NDArray[np.int64]
    point: NDArray[np.int64]
    pixel: Array


def make_ring(cameras: int, points: int, seed: int) -> Ring:
    """Cameras on a circle that look at its centre; each sees two thirds of the points."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, cameras, endpoint=False)
    height = rng.uniform(-1, 1, cameras)
    centre = np.column_stack([RADIUS * np.cos(around), RADIUS * np.sin(around), height])
    # Rows: right, up, and backwards, since the camera looks along its negative z axis.
    back = centre / np.linalg.norm(centre, axis=1, keepdims=True)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    rotation = np.stack([right, np.cross(back, right), back], axis=1)

    cloud = rng.uniform(-1, 1, (points, 3))
    camera, point = np.nonzero(rng.random((cameras, points)) < 2 / 3)
    seen = np.einsum("kij,kj->ki", rotation[camera], cloud[point] - centre[camera])
    u = -seen[:, :2] / seen[:, 2:]
    r2 = np.sum(u * u, axis=1, keepdims=True)
    pixel = FOCAL * (1 + r2 * (K1 + K2 * r2)) * u + rng.normal(0, NOISE, u.shape)
    return Ring(rotation, centre, cloud, camera, point, pixel)


def problem(ring: Ring, seed: int) -> Any:
    """The problem with perturbed cameras and points, and lenses without distortion."""
    rng = np.random.default_rng(seed + 1)
    count = len(ring.centre)
    turned = rotation_matrix(rng.normal(0, 0.02, (count, 3))) @ ring.rotation
    centre = ring.centre + rng.normal(0, 0.05, ring.centre.shape)
    ba: Any = arael.load(MODEL)()  # type: ignore[operator]
    ba.cameras.extend(
        r=quaternions(turned),
        t=-np.einsum("kij,kj->ki", turned, centre),
        f=np.full(count, 760.0),
        k1=np.zeros(count),
        k2=np.zeros(count),
    )
    ba.points.extend(pos=ring.points + rng.normal(0, 0.05, ring.points.shape))
    ba.observations.extend(camera=ring.camera, point=ring.point, pixel=ring.pixel)
    return ba


def quaternions(rotation: Array) -> Array:
    """Unit quaternions (n, 4), w first, of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    xyzw: Array = Rotation.from_matrix(rotation).as_quat()
    return xyzw[:, [3, 0, 1, 2]]


def rms_pixels(ba: Any) -> float:
    """Root mean square distance between seen and predicted pixels."""
    return float(np.sqrt(ba.cost() / len(ba.observations)))


def compare(ba: Any, ring: Ring) -> str:
    """Errors of points and lenses after similarity alignment, which pixels do not determine."""
    found = np.asarray(ba.points.pos.value)
    moved = similarity(found, ring.points).apply(found)
    focal = np.asarray(ba.cameras.f.value)
    return (
        f"points: RMS {1e3 * rms_distance(moved, ring.points):.2f} mm after similarity alignment; "
        f"focal lengths {focal.mean():.2f} px, off by {np.abs(focal - FOCAL).max():.2f} px at most"
    )


def plot(ba: Any, ring: Ring, start: Array, path: Path) -> str:
    """Draw cameras and points from above: the truth, the start and the solution."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    found = np.asarray(ba.points.pos.value)
    aligned = similarity(found, ring.points)

    @styled
    def draw() -> Any:
        figure, (axes, near) = new_figure(11.0, 5.4, columns=2)
        for panel in (axes, near):
            panel.plot(*ring.points[:, :2].T, "o", color=GREY, ms=5, mfc="none", label="truth")
            panel.plot(*start[:, :2].T, ".", color=ORANGE, ms=3, label="start")
            panel.plot(*aligned.apply(found)[:, :2].T, ".", color=BLUE, ms=4, label="solution")
            panel.set_xlabel("x [m]")
            panel.set_ylabel("y [m]")
        axes.set_aspect("equal", adjustable="datalim")
        axes.plot(*ring.centre[:, :2].T, "^", color=BLUE, ms=8, label="cameras")
        axes.set_title("cameras around a cloud of points, from above")
        axes.legend(loc="upper right")
        near.set_xlim(-0.5, 0.5)
        near.set_ylim(-0.5, 0.5)
        near.set_title("the middle, larger")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a BAL file, or a synthetic problem."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("problem", nargs="?", type=Path)
    parser.add_argument("--cameras", type=int, default=12)
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    ring = None
    if args.problem:
        ba: Any = arael.load(MODEL)()  # type: ignore[operator]
        ba.read(args.problem)
    else:
        ring = make_ring(args.cameras, args.points, args.seed)
        ba = problem(ring, args.seed)
    start = np.array(ba.points.pos.value)
    print(
        f"{len(ba.cameras)} cameras, {len(ba.points)} points, {len(ba.observations)} observations, "
        f"RMS {rms_pixels(ba):.2f} px at the start"
    )
    result = ba.solve()
    print(
        f"{result.status} after {result.iterations} iterations: "
        f"{result.start_cost:.1f} -> {result.end_cost:.1f}, RMS {rms_pixels(ba):.3f} px"
    )
    if ring:
        print(compare(ba, ring))
    if args.save:
        ba.write(args.save)
        print("wrote", args.save)
    if args.plot and ring:
        print("wrote", plot(ba, ring, start, args.plot))


if __name__ == "__main__":
    main()
