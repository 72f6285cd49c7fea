"""A map of planes: poses, walls, floors and ceilings from measurements of planes.

    python plane_demo.py [--poses 120] [--trajectory s-curve|loop|eight] [--seed 42]
                         [--plot plane_demo.png]

The model is `plane_slam.arael` in this folder, the scene that of `arael.scenes.PlaneConfig`.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import rotation_matrix
from arael.scenes import TRAJECTORIES, PlaneConfig, fill, make_plane_scene
from arael.scenes.evaluate import rms_distance
from arael.scenes.planes import PlaneScene

MODEL = Path(__file__).with_name("plane_slam.arael")
HALF_WIDTH = 1.5
"""Half the length of a wall as it is drawn [m]."""

Array = NDArray[np.float64]


def dead_reckoning(scene: PlaneScene) -> Array:
    """Positions (n, 3) that the odometry alone gives [m]."""
    pos, rotation = [scene.pos[0]], rotation_matrix(scene.ea[:1])[0]
    for step, turn in zip(scene.delta_pos, rotation_matrix(scene.delta_ea), strict=True):
        pos.append(pos[-1] + rotation @ step)
        rotation = rotation @ turn
    return np.array(pos)


def problem(scene: PlaneScene) -> Any:
    """The problem at its start."""
    model = arael.load(MODEL)
    plane_map: Any = model()
    fill(plane_map, model.layout, scene.columns)
    return plane_map


def plane_errors(plane_map: Any, scene: PlaneScene) -> tuple[Array, Array]:
    """Errors (m,) of the normals [rad] and of the distances from the nearest pose's truth [m]."""
    n, c = np.asarray(plane_map.planes.n.value), np.asarray(plane_map.planes.c.value)
    angle = np.arccos(np.clip(np.einsum("ki,ki->k", n, scene.normals), -1, 1))
    # At the first pose that observed the plane: far from it an angle error becomes a distance.
    first = scene.seen_pose[np.unique(scene.seen_plane, return_index=True)[1]]
    found = np.einsum("ki,ki->k", n, scene.pos[first]) + c
    true = np.einsum("ki,ki->k", scene.normals, scene.pos[first]) + scene.offsets
    return angle, np.abs(found - true)


def report(plane_map: Any, scene: PlaneScene, result: Any) -> list[str]:
    """Lines on the solution."""
    found = np.asarray(plane_map.poses.pos.value)
    angle, distance = plane_errors(plane_map, scene)
    reckoned = rms_distance(dead_reckoning(scene), scene.pos)
    return [
        f"{len(scene.pos)} poses, {len(scene.normals)} planes, {len(scene.seen_pose)} observations",
        f"{result.status} after {result.iterations} iterations, solver {result.plan['solver']}: "
        f"{result.start_cost:.1f} -> {result.end_cost:.1f}",
        f"poses: RMS {rms_distance(found, scene.pos):.3f} m; odometry alone {reckoned:.3f} m",
        f"planes: median error {np.rad2deg(np.median(angle)):.3f} deg, "
        f"{1e3 * np.median(distance):.1f} mm where first seen",
    ]


def plot(plane_map: Any, scene: PlaneScene, path: Path) -> str:
    """Draw path and walls from above."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    n, c = np.asarray(plane_map.planes.n.value), np.asarray(plane_map.planes.c.value)
    found = np.asarray(plane_map.poses.pos.value)
    first = scene.seen_pose[np.unique(scene.seen_plane, return_index=True)[1]]
    walls = np.abs(scene.normals[:, 2]) < 0.5

    def stretches(normals: Array, offsets: Array, seen_from: Array) -> Array:
        """Ends (m, 2, 2) of the walls where they are closest to a pose."""
        foot = seen_from - (np.einsum("ki,ki->k", normals, seen_from) + offsets)[:, None] * normals
        along = np.column_stack([-normals[:, 1], normals[:, 0]]) * HALF_WIDTH
        return np.stack([foot[:, :2] - along, foot[:, :2] + along], axis=1)

    @styled
    def draw() -> Any:
        figure, (axes,) = new_figure(11.0, 5.0)
        true = stretches(scene.normals, scene.offsets, scene.pos[first])[walls]
        solved = stretches(n, c, found[first])[walls]
        for k, (one, other) in enumerate(zip(true, solved, strict=True)):
            axes.plot(*one.T, color=GREY, lw=4, alpha=0.5, label="walls" if k == 0 else None)
            axes.plot(*other.T, color=INK, lw=1, label="walls, solved" if k == 0 else None)
        axes.plot(*scene.pos[:, :2].T, color=GREY, lw=4, alpha=0.5, label="path")
        axes.plot(*dead_reckoning(scene)[:, :2].T, color=ORANGE, lw=1, label="odometry alone")
        axes.plot(*found[:, :2].T, color=BLUE, lw=1.2, label="path, solved")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title("a path between walls, from above")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        return figure

    return save(draw(), path)


def main() -> None:
    """Generate a scene, solve it, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=120)
    parser.add_argument("--trajectory", choices=TRAJECTORIES, default="s-curve")
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    config = PlaneConfig(poses=args.poses, trajectory=args.trajectory, seed=args.seed)
    scene = make_plane_scene(config)
    plane_map = problem(scene)
    result = plane_map.solve()
    print("\n".join(report(plane_map, scene, result)))
    if args.plot:
        print("wrote", plot(plane_map, scene, args.plot))


if __name__ == "__main__":
    main()
