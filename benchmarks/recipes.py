"""``python -m benchmarks.recipes``: recipes of the documents beside `scipy.optimize.least_squares`.

Models are taken from the documents, so that they are those that users copy. SciPy minimises the
same residuals, vectorised with NumPy, from the same start, with finite differences (by sparsity
where the Jacobian is sparse) and default tolerances. Times are processor times of one thread, least
of several runs: of a new instance with its data (`first`), of an instance that was solved before
(`again`), of `least_squares`. Costs are sums of squares.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import re  # noqa: E402
import time  # noqa: E402
from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any, NamedTuple  # noqa: E402

import numpy as np  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

import arael  # noqa: E402
from arael import geometry  # noqa: E402

DOCS = Path(__file__).parents[1] / "docs"


class Recipe(NamedTuple):
    """One problem for both sides.

    Attributes
    ----------
    name : of the problem
    model : text of the model
    fill : makes an instance from its class
    residuals : the same residuals of a vector, for SciPy
    start : the vector that is the start of the model
    sparsity : of the Jacobian, or None
    """

    name: str
    model: str
    fill: Callable[[Any], Any]
    residuals: Callable[[Any], Any]
    start: Any
    sparsity: Any = None


def model_of(page: str, file: str) -> str:
    """The model that a page writes into `file`, in its text or by its Python."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = re.search(rf"`{file}`[.:]*\n\n```arael\n(.*?)```", text, re.DOTALL) or re.search(
        rf'open\("{file}", "w"\).*?"""\n(.*?)"""', text, re.DOTALL
    )
    assert found is not None, file
    return found[1]


def calibration(rng: np.random.Generator) -> Recipe:
    """Focal lengths, centre and distortion of a camera from twenty views of a board."""
    board = np.array([[i * 0.05, j * 0.05, 0.0] for i in range(-4, 5) for j in range(-3, 4)])
    views, pixels = 20, []
    for tilt in rng.uniform(-0.5, 0.5, (views, 3)):
        seen = board @ geometry.rotation_matrix(tilt).T + [0.02, -0.01, 0.6]
        u = seen[:, :2] / seen[:, 2:]
        u *= 1 - 0.1 * (u**2).sum(axis=1, keepdims=True)
        pixels.append(u * [610, 605] + [325, 236] + rng.normal(0, 0.2, u.shape))
    seen_pixels = np.concatenate(pixels)

    def fill(kind: Any) -> Any:
        cam = kind()
        cam.views.extend(views, r=[1, 0, 0, 0], t=[0, 0, 0.8])
        on = np.tile(board, (views, 1))
        view = np.repeat(np.arange(views), len(board))
        cam.corners.extend(view=view, on=on, pixel=seen_pixels)
        return cam

    def residuals(x: Any) -> Any:
        f, c, k1, poses = x[:2], x[2:4], x[4], x[5:].reshape(views, 6)
        p = np.einsum("vij,bj->vbi", Rotation.from_rotvec(poses[:, :3]).as_matrix(), board)
        p += poses[:, None, 3:]
        u = p[..., :2] / p[..., 2:]
        d = 1 + k1 * (u**2).sum(axis=-1, keepdims=True)
        return ((f * u * d + c).reshape(-1, 2) - seen_pixels).ravel() / 0.2

    start = np.concatenate([[500, 500, 320, 240, 0], np.tile([0, 0, 0, 0, 0, 0.8], views)])
    one = np.ones((2 * len(board), 6))
    sparsity = np.hstack([np.ones((len(one) * views, 5)), np.kron(np.eye(views), one)])
    model = model_of("cookbook.md", "calibrate.arael")
    return Recipe("camera calibration, 20 views", model, fill, residuals, start, sparsity)


def _log(rotations: Any, translations: Any) -> Any:
    """Logarithms (n, 6) of rigid transforms: translation, rotation."""
    phi = rotations.as_rotvec()
    angle = np.linalg.norm(phi, axis=1)[:, None]
    half = np.maximum(angle / 2, 1e-9)
    once = np.cross(phi, translations)
    factor = (1 - half / np.tan(half)) / np.maximum(angle, 2e-9) ** 2
    rho = translations - once / 2 + factor * np.cross(phi, once)
    return np.hstack([rho, phi])


def hand_eye(rng: np.random.Generator) -> Recipe:
    """Camera on the hand of a robot, from forty shots of a fixed target."""
    shots = 40
    eye = Rotation.from_euler("xyz", [0.1, -0.2, 1.5]), np.array([0.05, 0.02, 0.1])
    target = Rotation.from_euler("xyz", [0, 0.5, 2.0]), np.array([1.5, 0.2, 0.3])
    hand_q = Rotation.from_rotvec(rng.normal(0, 0.5, (shots, 3)))
    hand_t = rng.normal(0, 0.3, (shots, 3))
    out_q = (hand_q * eye[0]).inv()
    seen_q = out_q * target[0] * Rotation.from_rotvec(rng.normal(0, 0.001, (shots, 3)))
    away = target[1] - hand_t - hand_q.apply(eye[1])
    seen_t = out_q.apply(away) + rng.normal(0, 0.001, (shots, 3))

    def fill(kind: Any) -> Any:
        robot = kind()
        robot.shots.extend(
            hand_t=hand_t,
            hand_q=hand_q.as_quat()[:, [3, 0, 1, 2]],
            seen_t=seen_t,
            seen_q=seen_q.as_quat()[:, [3, 0, 1, 2]],
        )
        return robot

    def residuals(x: Any) -> Any:
        eye_q, target_q = Rotation.from_rotvec(x[:3]), Rotation.from_rotvec(x[6:9])
        turn = target_q.inv() * hand_q * eye_q * seen_q
        place = hand_t + hand_q.apply(x[3:6] + eye_q.apply(seen_t))
        return _log(turn, target_q.inv().apply(place - x[9:])).ravel() / 0.002

    start = np.array([0.0] * 9 + [1, 0, 0])
    model = model_of("cookbook.md", "handeye.arael")
    return Recipe("hand-eye, 40 shots", model, fill, residuals, start)


def alignment(rng: np.random.Generator) -> Recipe:
    """A similarity between 500 matched points."""
    a = rng.normal(size=(500, 3))
    b = 1.7 * a @ geometry.rotation_matrix([0.3, -0.2, 2.0]).T + [1, 2, 3]
    b += rng.normal(0, 0.01, a.shape)

    def fill(kind: Any) -> Any:
        align = kind()
        align.matches.extend(a=a, b=b)
        return align

    def residuals(x: Any) -> Any:
        return (np.exp(x[6]) * Rotation.from_rotvec(x[:3]).apply(a) + x[3:6] - b).ravel()

    model = model_of("cookbook.md", "align.arael")
    return Recipe("alignment of 500 points", model, fill, residuals, np.zeros(7))


def epochs(rng: np.random.Generator) -> Recipe:
    """Positions and clocks of a receiver at 200 epochs, eight satellites each."""
    count = 200
    up = np.array([0.36, 0.48, 0.8])
    ways = rng.normal(size=(count, 8, 3)) + 2 * up
    satellites = 6.371e6 * up + 2.2e7 * ways / np.linalg.norm(ways, axis=2, keepdims=True)
    ranges = np.linalg.norm(satellites - 6.371e6 * up, axis=2)
    ranges += 3e5 * rng.normal(size=(count, 1)) + rng.normal(0, 5, (count, 8))

    def fill(kind: Any) -> Any:
        track = kind()
        track.epochs.extend(count, pos=[0, 0, 0], clock=0)
        rows = np.repeat(np.arange(count), 8)
        track.epochs.satellites.extend(
            parent=rows, pos=satellites.reshape(-1, 3), range=ranges.ravel()
        )
        return track

    def residuals(x: Any) -> Any:
        at = x.reshape(count, 1, 4)
        found = np.linalg.norm(satellites - at[..., :3], axis=2) + at[..., 3] - ranges
        return found.ravel() / 5

    sparsity = np.kron(np.eye(count), np.ones((8, 4)))
    model = model_of("solving.md", "track.arael")
    return Recipe("GNSS, 200 epochs", model, fill, residuals, np.zeros(4 * count), sparsity)


def least(work: Callable[[], Any], runs: int) -> float:
    """Least processor time of a call, in seconds."""
    found = []
    for _ in range(runs):
        began = time.process_time()
        work()
        found.append(time.process_time() - began)
    return min(found)


def measured(one: Recipe) -> str:
    """A row of the table."""
    kind = arael.loads(one.model)
    result = one.fill(kind).solve()
    first = least(lambda: one.fill(kind).solve(), 5)
    kept = one.fill(kind)
    start = kept.serialize()
    kept.solve()

    def again() -> None:
        kept.deserialize(start)
        kept.solve()

    sparse = {} if one.sparsity is None else {"jac_sparsity": one.sparsity, "x_scale": "jac"}
    beside: dict[str, Any] = {}

    def scipy() -> None:
        beside["found"] = least_squares(one.residuals, one.start, **sparse)

    slow = least(scipy, 2)
    lines = len([line for line in one.model.splitlines() if line.strip()])
    seconds = least(again, 9)
    return (
        f"| {one.name} | {lines} | {1e3 * first:.2f} | {1e3 * seconds:.2f} | {1e3 * slow:.1f} | "
        f"{slow / first:.0f} | {result.end_cost:.6g} | {2 * beside['found'].cost:.6g} |"
    )


def main() -> None:
    """Print the table."""
    print("| problem | lines | first [ms] | again [ms] | SciPy [ms] | ratio | cost | of SciPy |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for make in (calibration, hand_eye, alignment, epochs):
        print(measured(make(np.random.default_rng(7))), flush=True)


if __name__ == "__main__":
    main()
