"""Hand-eye calibration: a camera on the hand of a robot, with one unknown transform and with two.

    python hand_eye.py [--shots 30] [--seed 1] [--plot hand_eye.png] [--data FOLDER]

`hand_eye.arael` solves A X = X B on motions, `robot_world.arael` A X = Y B on poses, and
`hand_eye_offset.arael` the same while the hand moves and the camera has a clock of its own.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import (
    clock_offset,
    quat_from_matrix,
    rotation_from_vector,
    rotation_vector,
    skew,
)

Array = NDArray[np.float64]

HERE = Path(__file__).parent
SIGMA = np.array([1e-3, 1e-3, 3e-3, 3e-3, 3e-3, 1e-3])
"""Noise of a pose of the camera in its frame: [m] with the depth last, [rad] with the roll last."""


def rigid(t: Any, v: Any) -> Array:
    """Rigid transforms (..., 4, 4) of translations and rotation vectors."""
    t, v = np.asarray(t, dtype=float), np.asarray(v, dtype=float)
    found = np.zeros((*t.shape[:-1], 4, 4))
    found[..., :3, :3], found[..., :3, 3] = rotation_from_vector(v), t
    found[..., 3, 3] = 1
    return found


@dataclass(frozen=True)
class Poses:
    """Measured poses, and the truth.

    Attributes
    ----------
    a : hand in the frame of the robot (n, 4, 4)
    b : camera in the frame of the target (n, 4, 4), measured
    x, y : true transforms (4, 4): camera in the hand, target in the frame of the robot
    """

    a: Array
    b: Array
    x: Array
    y: Array


def simulate(shots: int = 30, seed: int = 1) -> Poses:
    """Poses of a hand that looks at a target from all around; the camera's are noisy."""
    rng = np.random.default_rng(seed)
    x = rigid([0.05, -0.03, 0.12], [0.02, -0.05, 1.6])
    y = rigid([0.7, 0.1, 0.0], [0.03, 0.01, 0.8])
    at = np.array([0.7, 0.1, 0.6]) + rng.uniform(-0.3, 0.3, (shots, 3)) * [1, 1, 0.5]
    down = rigid(np.zeros(3), [np.pi, 0, 0])
    a = rigid(at, np.zeros(3)) @ down @ rigid(np.zeros((shots, 3)), rng.normal(0, 0.5, (shots, 3)))
    noise = SIGMA * rng.normal(size=(shots, 6))
    b = np.linalg.inv(y) @ a @ x @ rigid(noise[:, :3], noise[:, 3:])
    return Poses(a, b, x, y)


@dataclass(frozen=True)
class Sweep(Poses):
    """Poses of a hand in motion: `a` at the times `t` of the robot, `b` at `shot` of the camera.

    Attributes
    ----------
    offset : true offset, added to times of the camera
    """

    t: Array
    shot: Array
    offset: float


def sweep(seconds: float = 30.0, seed: int = 1) -> Sweep:
    """A hand that swings before a target: poses at 125 Hz, pictures at 10 Hz."""
    rng = np.random.default_rng(seed)
    still, offset = simulate(2, seed), 0.0231
    phase = rng.uniform(0, 2 * np.pi, (6, 2))

    def hand(t: Array) -> Array:
        def swing(k: int) -> Array:
            slow = np.sin((1.1 + 0.1 * k) * t + phase[k, 0])
            return slow + 0.3 * np.sin((3.1 + 0.2 * k) * t + phase[k, 1])

        at = np.array([0.7, 0.1, 0.6]) + 0.15 * np.stack([swing(k) for k in range(3)], axis=1)
        turns = rigid(np.zeros((len(t), 3)), 0.35 * np.stack([swing(k) for k in (3, 4, 5)], axis=1))
        return rigid(at, np.zeros(3)) @ rigid(np.zeros(3), [np.pi, 0, 0]) @ turns

    t = np.arange(0.0, seconds, 0.008)
    shot = np.arange(0.5, seconds - 0.5, 0.1) + rng.uniform(0, 0.02, int((seconds - 1) / 0.1 + 0.5))
    noise = SIGMA * rng.normal(size=(len(shot), 6))
    b = np.linalg.inv(still.y) @ hand(shot + offset) @ still.x
    return Sweep(hand(t), b @ rigid(noise[:, :3], noise[:, 3:]), still.x, still.y, t, shot, offset)


def adjoint(b: Array) -> Array:
    """Adjoints (..., 6, 6) of rigid transforms: they move a twist to another frame."""
    found = np.zeros((*b.shape[:-2], 6, 6))
    turn = b[..., :3, :3]
    found[..., :3, :3] = found[..., 3:, 3:] = turn
    found[..., :3, 3:] = skew(b[..., :3, 3]) @ turn
    return found


def motions(poses: Poses) -> tuple[Array, Array, Array]:
    """Motions of hand and camera (m, 4, 4) between pairs of shots, and their whitening (m, 6, 6).

    No shot is in two pairs, so that the noise of the motions is independent.
    """
    m = len(poses.a) // 2
    a = np.linalg.inv(poses.a[:m]) @ poses.a[m : 2 * m]
    b = np.linalg.inv(poses.b[:m]) @ poses.b[m : 2 * m]
    moved = adjoint(np.linalg.inv(b))  # the noise of the first pose, in the frame of the second
    one = np.diag(SIGMA**2)
    covariance = one + moved @ one @ np.swapaxes(moved, 1, 2)
    return a, b, np.linalg.inv(np.linalg.cholesky(covariance))


def columns(a: Array, b: Array) -> dict[str, Array]:
    """Transforms as columns of a collection."""
    return {
        "a_t": a[:, :3, 3],
        "a_q": quat_from_matrix(a[:, :3, :3]),
        "b_t": b[:, :3, 3],
        "b_q": quat_from_matrix(b[:, :3, :3]),
    }


def hand_eye(poses: Poses) -> Any:
    """The problem A X = X B at its start, the identity."""
    a, b, whiten = motions(poses)
    model: Any = arael.load(HERE / "hand_eye.arael")()
    model.motions.extend(**columns(a, b), whiten=whiten)
    return model


def robot_world(poses: Poses) -> Any:
    """The problem A X = Y B at its start, two identities."""
    model: Any = arael.load(HERE / "robot_world.arael")(isigma=1 / SIGMA)
    model.shots.extend(**columns(poses.a, poses.b))
    return model


def moving(poses: Sweep) -> Any:
    """The problem A(t + offset) X = Y B, from two identities and the offset of angular rates."""

    def rates(t: Array, pose: Array) -> tuple[Array, Array]:
        turn = np.swapaxes(pose[:-1, :3, :3], 1, 2) @ pose[1:, :3, :3]
        return (t[1:] + t[:-1]) / 2, np.linalg.norm(rotation_vector(turn), axis=1) / np.diff(t)

    offset = clock_offset(*rates(poses.t, poses.a), *rates(poses.shot, poses.b), 0.2)
    model: Any = arael.load(HERE / "hand_eye_offset.arael")(isigma=1 / SIGMA, offset=offset)
    turns = quat_from_matrix(poses.a[:, :3, :3])
    model.hand.extend(t=poses.t, a=np.hstack([poses.a[:, :3, 3], turns]))
    shots = columns(poses.b, poses.b)
    model.shots.extend(time=poses.shot, b_t=shots["b_t"], b_q=shots["b_q"])
    return model


def error(found: Array, true: Array) -> Array:
    """Error (6,) in the tangent of the found transform, as its covariance: [m], [rad]."""
    off = np.linalg.inv(found) @ true
    return np.concatenate([off[:3, 3], rotation_vector(off[:3, :3])])


def report(name: str, model: Any, result: Any, poses: Poses) -> list[str]:
    """Lines on a solution."""
    residuals = model.jacobian().shape[0]
    lines = [f"{name}: {result.status}, cost {result.end_cost:.1f} of {residuals} residuals"]
    covariance = model.covariance()
    for which, true in (("X", poses.x), ("Y", poses.y)):
        if which == "Y" and name == "A X = X B":
            continue
        off = np.abs(error(getattr(model, which).matrix, true))
        sigma = np.sqrt(np.diag(covariance.marginal(which)))
        for part, unit, rows in (
            ("translation", "mm", slice(3)),
            ("rotation", "mrad", slice(3, 6)),
        ):
            lines.append(
                f"  {which} {part:11}  error {1e3 * off[rows].max():5.2f} {unit:4}"
                f"  sigma {1e3 * sigma[rows].max():5.2f} {unit}"
            )
    if isinstance(poses, Sweep):
        off = 1e6 * abs(float(model.offset.value) - poses.offset)
        sigma = 1e6 * np.sqrt(float(covariance.marginal("offset")[0, 0]))
        lines.append(f"  offset         error {off:5.0f} us    sigma {sigma:5.0f} us")
    return lines


def plot(poses: Poses, model: Any, path: Path) -> str:
    """Draw hand, camera and target, and the residuals in sigmas."""
    from arael.plot.figure import BLUE, GREEN, GREY, ORANGE, new_figure, save, styled

    x, y = model.X.matrix, model.Y.matrix

    @styled
    def draw() -> Any:
        figure, (side, spread) = new_figure(10.0, 4.4, columns=2)
        camera = poses.a @ x
        for k, (hand, eye) in enumerate(zip(poses.a, camera, strict=True)):
            legend = {"label": "hand to camera"} if k == 0 else {}
            side.plot(*np.array([hand[[0, 2], 3], eye[[0, 2], 3]]).T, color=GREY, lw=1.5, **legend)
            ahead = eye[:3, 3] + 0.12 * eye[:3, 2]
            legend = {"label": "view of the camera"} if k == 0 else {}
            side.plot([eye[0, 3], ahead[0]], [eye[2, 3], ahead[2]], color=BLUE, lw=0.8, **legend)
        from_target = (y @ poses.b)[:, :3, 3]
        side.plot(from_target[:, 0], from_target[:, 2], "o", color=ORANGE, ms=4, label="seen pose")
        side.plot(*y[[0, 2], 3], "s", color=GREEN, ms=9, label="target")
        side.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="robot, from the side")
        side.legend(loc="upper left", bbox_to_anchor=(0.0, -0.16), ncols=2)
        rows = model.residual_values("Shot.chain").whitened
        names = ["x", "y", "z", "roll", "pitch", "yaw"]
        for k in range(6):
            spread.plot(np.full(len(rows), k) + np.linspace(-0.2, 0.2, len(rows)), rows[:, k], ".")
        spread.axhspan(-1, 1, color=GREY, alpha=0.2, lw=0)
        spread.set_xticks(range(6), names)
        spread.set(ylabel="residual [sigma]", title="A X against Y B, in the frame of the camera")
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate poses, solve both forms, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--shots", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problems here, for `arael solve`")
    args = parser.parse_args(arguments)

    poses = simulate(args.shots, args.seed)
    swung = sweep(seed=args.seed)
    one, two, three = hand_eye(poses), robot_world(poses), moving(swung)
    if args.data:
        args.data.mkdir(parents=True, exist_ok=True)
        one.write(args.data / "hand_eye.json")
        two.write(args.data / "robot_world.json")
        three.write(args.data / "hand_eye_offset.json")
    print("\n".join(report("A X = X B", one, one.solve(rel_precision=1e-9), poses)))
    print("\n".join(report("A X = Y B", two, two.solve(rel_precision=1e-9), poses)))
    moved = three.solve(rel_precision=1e-9)
    print("\n".join(report("A(t + offset) X = Y B", three, moved, swung)))
    if args.plot:
        print("wrote", plot(poses, two, args.plot))


if __name__ == "__main__":
    main()
