"""Localization with a rigid transform of the whole trajectory among the parameters of the root.

    python loc_global_demo.py [--poses 40] [--seed 42] [--plot loc_global_demo.png]

The model is `loc_global.arael` in this folder. The start is displaced as a whole, by metres and
tens of degrees. Therefore the poses are frozen, the transform alone is solved for and applied to
the poses, and then all parameters are solved for.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import euler_angles, rotation_matrix, rotation_vector
from arael.scenes import Scene, columns, demo_config, fill, make_scene

Array = NDArray[np.float64]

MODEL = Path(__file__).with_name("loc_global.arael")

SHIFT = np.array([3.0, -2.0, 0.5])
TURN = np.deg2rad([2.0, -3.0, 25.0])
"""Displacement of the start: metres; roll, pitch, yaw."""


def displaced(scene: Scene) -> dict[str, Any]:
    """Columns of the scene with all start poses displaced by the same transform."""
    found = dict(columns(scene, "localization"))
    turn = rotation_matrix(TURN)
    found["poses.pos"] = scene.start_pos @ turn.T + SHIFT
    found["poses.ea"] = euler_angles(turn @ rotation_matrix(scene.start_ea))
    return {path: values for path, values in found.items() if "pixel" not in path}


def new_path(scene: Scene) -> Any:
    """An instance that holds the displaced scene."""
    model: Any = arael.load(MODEL)
    path = model()
    fill(path, model.layout, displaced(scene))
    return path


def optimise_center(path: Any) -> tuple[Any, Array, Array]:
    """Solve for the transform of the root alone and apply it to the poses.

    Returns
    -------
    The result of the solve, and the transform, as returned by `bake_in`.
    """
    path.poses.pos.optimize = False
    path.poses.ea.optimize = False
    result = path.solve()
    shift, turn = bake_in(path)
    path.poses.pos.optimize = True
    path.poses.ea.optimize = True
    return result, shift, turn


def bake_in(path: Any) -> tuple[Array, Array]:
    """Apply the transform of the root to every pose, and reset it to the identity.

    Returns
    -------
    The transform as it was: translation (3,) [m] and rotation matrix (3, 3).
    """
    shift, turn = path.global_pos.value.copy(), path.global_ea.matrix.copy()
    path.poses.pos.value = path.poses.pos.value @ turn.T + shift
    path.poses.ea.value = euler_angles(turn @ path.poses.ea.matrix)
    path.global_pos.value = np.zeros(3)
    path.global_ea.value = np.zeros(3)
    return shift, turn


@dataclass
class Run:
    """Results of both stages.

    Attributes
    ----------
    start, centred : positions (n, 3) before, and with the transform applied [m]
    shift, turn : the transform: translation (3,) [m], rotation matrix (3, 3)
    centre, sweep : results of the two solves
    """

    scene: Scene
    path: Any
    start: Array
    centred: Array
    shift: Array
    turn: Array
    centre: Any
    sweep: Any

    def rms(self, positions: Array) -> float:
        """RMS distance from the true positions [m]."""
        off = np.linalg.norm(positions - self.scene.pos, axis=1)
        return float(np.sqrt(np.mean(off**2)))

    @property
    def left_over(self) -> tuple[float, float]:
        """Translation [m] and rotation [rad] of displacement and transform combined."""
        turn = self.turn @ rotation_matrix(TURN)
        off = self.turn @ SHIFT + self.shift
        return float(np.linalg.norm(off)), float(np.linalg.norm(rotation_vector(turn)))

    @property
    def solved(self) -> Array:
        """Positions (n, 3) at the end [m]."""
        return np.array(self.path.poses.pos.value)


def run(poses: int = 40, seed: int = 42) -> Run:
    """Generate the scene, undo the displacement, solve for all parameters."""
    scene = make_scene(demo_config(poses, seed=seed))
    path = new_path(scene)
    start = np.array(path.poses.pos.value)
    centre, shift, turn = optimise_center(path)
    centred = np.array(path.poses.pos.value)
    sweep = path.solve()
    bake_in(path)
    return Run(scene, path, start, centred, shift, turn, centre, sweep)


def plot(found: Run, path: Path) -> None:
    """Draw the trajectory from above, after each stage, and the pattern of the Hessian."""
    from arael.plot.figure import BLUE, FAINT, GREEN, GREY, ORANGE, new_figure, save, styled

    @styled
    def drawn() -> Any:
        figure, (above, pattern) = new_figure(9.6, 4.4, columns=2)
        landmarks = found.scene.landmarks
        above.plot(landmarks[:, 0], landmarks[:, 1], ".", color=GREY, ms=3, label="map")
        above.plot(*found.scene.pos[:, :2].T, lw=5, color=FAINT, label="truth")
        stages = (
            ("start", found.start, ORANGE),
            ("transform folded in", found.centred, GREEN),
            ("everything solved", found.solved, BLUE),
        )
        for label, at, color in stages:
            above.plot(at[:, 0], at[:, 1], "o-", ms=3, lw=1, color=color, label=label)
        above.set(xlim=(-5, 17), ylim=(-9, 11), aspect="equal")
        above.set_xlabel("x [m]")
        above.set_ylabel("y [m]")
        above.set_title("A trajectory found in a map")
        above.legend(loc="lower right", ncols=2)
        hessian = found.path.hessian()
        pattern.imshow(hessian != 0, cmap="Greys", vmax=1.6, interpolation="nearest")
        pattern.set_title("Hessian: the root's six parameters meet every pose")
        return figure

    save(drawn(), path)


def main(arguments: list[str] | None = None) -> None:
    """Run both stages and print their results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=40)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)

    found = run(args.poses, args.seed)
    path = found.path
    print(f"start               RMS {found.rms(found.start):8.4f} m")
    print(
        f"transform alone     RMS {found.rms(found.centred):8.4f} m   cost {found.centre.cost:.2f}"
    )
    moved, turned = found.left_over
    print(f"  undoes the displacement within {moved:.3f} m and {np.rad2deg(turned):.3f} degrees")
    print(f"everything          RMS {found.rms(found.solved):8.4f} m   cost {found.sweep.cost:.2f}")
    frine = path.landmarks.frines[0]
    print(f"block of a pose and the root, beside the constraint: {frine.hb_root.shape}")
    print(f"pairs in the root's triplets: {path.hbt.nnz // 36}")
    if args.plot:
        plot(found, args.plot)


if __name__ == "__main__":
    main()
