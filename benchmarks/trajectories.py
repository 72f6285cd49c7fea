"""``python -m benchmarks.trajectories``: trajectories of the examples beside SciPy.

`scipy.optimize.least_squares` minimises the same residuals, vectorised with NumPy, from the same
start, with finite differences by the sparsity of the Jacobian. Times are processor times of one
thread, least of several runs: of a new instance with its data and its solve (`first`), of an
instance that was solved before (`again`), of `least_squares`. Costs are sums of squares. The
residuals are those that the tests of the examples compare with.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import importlib.util  # noqa: E402
import sys  # noqa: E402
from collections.abc import Callable  # noqa: E402
from functools import partial  # noqa: E402
from pathlib import Path  # noqa: E402
from types import ModuleType  # noqa: E402
from typing import Any, NamedTuple  # noqa: E402

import numpy as np  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402
from scipy.optimize._numdiff import approx_derivative, group_columns  # noqa: E402
from scipy.sparse import csr_matrix, lil_matrix  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

from benchmarks.recipes import least  # noqa: E402

EXAMPLES = Path(__file__).parents[1] / "examples"


class Beside(NamedTuple):
    """One problem for both sides.

    Attributes
    ----------
    name : of the problem
    make : new instance of the model at its start
    residuals : the same residuals of a vector, for SciPy
    start : the vector that is the start of the model
    reads : for each residual the numbers of the variables that it reads
    exact : SciPy factorises the dense Jacobian, differentiated by its sparsity; its iterative
        solver takes minutes on badly scaled problems
    last : pass of the model that is the problem; None: all
    """

    name: str
    make: Callable[[], Any]
    residuals: Callable[[Any], Any]
    start: Any
    reads: list[Any]
    exact: bool = False
    last: str | None = None

    def sparsity(self) -> csr_matrix:
        """Pattern of the Jacobian."""
        found = lil_matrix((len(self.reads), len(self.start)), dtype=int)
        for row, columns in enumerate(self.reads):
            found[row, columns] = 1
        return csr_matrix(found)

    def by_scipy(self, pattern: csr_matrix | None = None, **settings: Any) -> Any:
        """The solution of `least_squares`."""
        pattern = self.sparsity() if pattern is None else pattern
        if self.exact:
            groups = group_columns(pattern)

            def jacobian(x: Any) -> Any:
                found = approx_derivative(
                    self.residuals, x, method="2-point", sparsity=(pattern, groups)
                )
                return found.toarray()

            return least_squares(
                self.residuals, self.start, jac=jacobian, x_scale="jac", **settings
            )
        return least_squares(
            self.residuals, self.start, jac_sparsity=pattern, x_scale="jac", **settings
        )


def example(name: str) -> ModuleType:
    """The script of an example as a module."""
    spec = importlib.util.spec_from_file_location(f"beside_{name}", EXAMPLES / name / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def cauchy(s: Any, c: float) -> Any:
    """Robust residual of a residual `s`: its square is ``c^2 log(1 + s^2 / c^2)``."""
    return np.sign(s) * c * np.sqrt(np.log1p((s / c) ** 2))


def wrapped(angle: Any) -> Any:
    """The angle within half a turn."""
    return np.arctan2(np.sin(angle), np.cos(angle))


def range_slam(script: ModuleType, field: Any) -> Beside:
    """Path, beacons and scale of the ranges. Variables: poses but the first, beacons, scale."""
    n, k = len(field.moved) + 1, len(field.ids)
    path, th = script.dead_reckoning(field)
    beacons, scale = script.beacon_starts(field)
    held = np.array([*path[0], th[0]])

    def residuals(x: Any) -> Any:
        poses = np.vstack([held, x[: 3 * n - 3].reshape(-1, 3)])
        places = x[3 * n - 3 : -1].reshape(k, 2)
        c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
        d = np.diff(poses[:, :2], axis=0)
        wrong = np.column_stack([
            c * d[:, 0] + s * d[:, 1] - field.moved[:, 0],
            c * d[:, 1] - s * d[:, 0] - field.moved[:, 1],
            wrapped(np.diff(poses[:, 2]) - field.turned),
        ])  # fmt: skip
        away = np.linalg.norm(places[field.beacon] - poses[field.pose, :2], axis=1)
        ranges = cauchy((x[-1] * away - field.range) / field.range_sigma, 3.0)
        return np.concatenate([(wrong / field.sigma).ravel(), ranges, [(x[-1] - 1) / 0.1]])

    # Of the first pose, which is held, nothing is read.
    def pose(row: int) -> list[int]:
        return [] if row == 0 else list(range(3 * row - 3, 3 * row))

    last = 3 * n - 3 + 2 * k
    reads: list[Any] = []
    for row in range(n - 1):
        reads += [pose(row) + pose(row + 1)] * 3
    for p, b in zip(field.pose, field.beacon, strict=True):
        reads.append([*pose(p)[:2], 3 * n - 3 + 2 * b, 3 * n - 2 + 2 * b, last])
    reads.append([last])
    start = np.concatenate([np.column_stack([path, th])[1:].ravel(), beacons.ravel(), [scale]])
    return Beside("range SLAM", lambda: script.problem(field), residuals, start, reads)


def landmark_slam(script: ModuleType, park: Any) -> Beside:
    """Poses but the first, and landmarks; the start of the model."""
    model = script.problem(park)
    poses = np.column_stack([np.array(model.poses.pos.value), np.array(model.poses.th.value)])
    n, k = len(poses), len(park.ids)
    held = poses[0]

    def residuals(x: Any) -> Any:
        p = np.vstack([held, x[: 3 * n - 3].reshape(-1, 3)])
        trees = x[3 * n - 3 :].reshape(k, 2)
        moved = script.into_frame(p[:-1, :2], p[:-1, 2], p[1:, :2]) - park.moved
        turned = wrapped(np.diff(p[:, 2]) - park.turned)
        steps = np.column_stack([moved / park.sigma[:, :1], turned / park.sigma[:, 1]])
        seen = script.into_frame(p[park.pose, :2], p[park.pose, 2], trees[park.landmark])
        wrong = np.column_stack([
            wrapped(np.arctan2(seen[:, 1], seen[:, 0]) - park.bearing) / np.deg2rad(2),
            (np.linalg.norm(seen, axis=1) - park.range) / 0.3,
        ])  # fmt: skip
        # One loss for both residuals of a sight, by the length of the two.
        size = np.maximum(np.linalg.norm(wrong, axis=1), 1e-12)
        return np.concatenate([
            steps.ravel(), (wrong * (cauchy(size, 2.0) / size)[:, None]).ravel()
        ])  # fmt: skip

    def pose(row: int) -> list[int]:
        return [] if row == 0 else list(range(3 * row - 3, 3 * row))

    reads: list[Any] = []
    for row in range(n - 1):
        reads += [pose(row) + pose(row + 1)] * 3
    for p, tree in zip(park.pose, park.landmark, strict=True):
        reads += [[*pose(p), 3 * n - 3 + 2 * tree, 3 * n - 2 + 2 * tree]] * 2
    start = np.concatenate([poses[1:].ravel(), np.array(model.landmarks.pos.value).ravel()])

    def make() -> Any:
        return script.problem(park, poses[:, :2], poses[:, 2])

    return Beside(
        "landmark SLAM, 300 poses", make, residuals, start, reads, exact=True, last="fine"
    )


def rotation_of(q: Any) -> Rotation:
    """Rotations of quaternions (..., 4), scalar first."""
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def visual_inertial(script: ModuleType, run: Any) -> Beside:
    """States of position, rotation vector, velocity, biases; then scale and direction of gravity.

    The residual is written with the rotations of SciPy, from the columns of the preintegration.
    """
    model = script.problem(run)
    n = len(run.pos)
    nav = model.states.nav
    imu = {name: np.array(value) for name, value in script.motions(run).columns().items()}
    t = imu["duration"][:, None]
    base = rotation_of(np.array(nav.q.value))
    down = np.array(model.down.value)
    plane = np.linalg.svd(down[None])[2][1:]  # two axes across the start of gravity

    def times(name: str, v: Any) -> Any:
        return np.einsum("nij,nj->ni", imu[name], v)

    def residuals(x: Any) -> Any:
        p, turn, v, bg, ba = np.split(x[:-3].reshape(n, 15), 5, axis=1)
        q = base * Rotation.from_rotvec(turn)
        g = down + x[-2:] @ plane
        g = 9.81 * g / np.linalg.norm(g)
        dg, da = bg[:-1] - imu["gyro_bias"], ba[:-1] - imu["accel_bias"]
        middle = rotation_of(imu["rotation"]) * Rotation.from_rotvec(times("rotation_by_gyro", dg))
        back = q[:-1].inv()
        dv = back.apply(v[1:] - v[:-1] - g * t) - imu["velocity"]
        dp = back.apply(p[1:] - p[:-1] - v[:-1] * t - g * t**2 / 2) - imu["position"]
        motion = np.hstack([
            (middle.inv() * back * q[1:]).as_rotvec(),
            dv - times("velocity_by_gyro", dg) - times("velocity_by_accel", da),
            dp - times("position_by_gyro", dg) - times("position_by_accel", da),
        ])  # fmt: skip
        walk = np.hstack([np.diff(bg, axis=0) / 1e-4, np.diff(ba, axis=0) / 1e-3]) / np.sqrt(t)
        sight = np.hstack([
            (x[-3] * p - run.seen_pos) / script.POS_SIGMA,
            (rotation_of(run.seen_q).inv() * q).as_rotvec() / script.Q_SIGMA,
        ])  # fmt: skip
        return np.concatenate([times("whiten", motion).ravel(), walk.ravel(), sight.ravel()])

    common = [15 * n, 15 * n + 1, 15 * n + 2]
    reads: list[Any] = []
    for row in range(n - 1):
        reads += [[*range(15 * row, 15 * row + 30), *common[1:]]] * 9
    for row in range(n - 1):
        reads += [[*range(15 * row + 9, 15 * row + 15), *range(15 * row + 24, 15 * row + 30)]] * 6
    for row in range(n):
        reads += [[*range(15 * row, 15 * row + 6), common[0]]] * 6
    states = np.hstack([
        np.array(nav.pos.value), np.zeros((n, 3)), np.array(nav.vel.value),
        np.array(nav.gyro_bias.value), np.array(nav.accel_bias.value),
    ])  # fmt: skip
    start = np.concatenate([states.ravel(), [1, 0, 0]])
    make = partial(script.problem, run)
    return Beside("visual-inertial, 51 pictures", make, residuals, start, reads, exact=True)


def spline(script: ModuleType, flight: Any, make: Callable[[], Any]) -> Beside:
    """Knots: positions, and rotation vectors on the right of their starts."""
    knots = script.start(flight)
    base = rotation_of(knots[:, 3:])
    at_pos, at_q = script.place(flight.pos_times), script.place(flight.q_times)
    seen = rotation_of(flight.q).inv()

    def residuals(x: Any) -> Any:
        found = x.reshape(-1, 6)
        turns = base * Rotation.from_rotvec(found[:, 3:])
        pos = script.evaluate(turns, found[:, :3], *at_pos)[1] - flight.pos
        turn = (seen * script.evaluate(turns, found[:, :3], *at_q)[0]).as_rotvec()
        return np.concatenate([pos.ravel() / script.POS_SIGMA, turn.ravel() / script.Q_SIGMA])

    reads: list[Any] = []
    for first in np.concatenate([at_pos[0], at_q[0]]):
        reads += [list(range(6 * first, 6 * first + 24))] * 3
    start = np.hstack([knots[:, :3], np.zeros((len(knots), 3))]).ravel()
    return Beside("spline, 23 knots", make, residuals, start, reads, exact=True)


def gnss(script: ModuleType, drive: Any) -> Beside:
    """Positions and clocks of the epochs; the loss in the residual."""
    n = len(drive.true_pos)
    made = script.problem(drive)
    made.solve(passes=["rough", "wide"])
    start = np.column_stack([np.array(made.epochs.pos.value), np.array(made.epochs.clock.value)])
    begun = made.serialize()

    def make() -> Any:
        model = script.problem(drive)
        model.deserialize(begun)
        return model

    def residuals(x: Any) -> Any:
        at = x.reshape(n, 4)[drive.epoch]
        away = np.linalg.norm(drive.satellite - at[:, :3], axis=1)
        wrong = (away + at[:, 3] - drive.range) / drive.sigma
        return cauchy(wrong, 3.0)

    reads: list[Any] = [list(range(4 * row, 4 * row + 4)) for row in drive.epoch]
    name = f"GNSS, {n} epochs"
    return Beside(name, make, residuals, start.ravel(), reads, n < 50, "fine")


def cases() -> list[Beside]:
    """The problems of the table."""
    ranges = example("range_slam")
    inertial = example("imu_preintegration")
    landmarks = example("landmark_slam_2d")
    receiver = example("gnss")
    splines = example("spline_trajectory")
    flight = splines.make_flight()
    return [
        range_slam(ranges, ranges.make_field()),
        visual_inertial(inertial, inertial.make_run()),
        landmark_slam(landmarks, landmarks.make_park()),
        gnss(receiver, receiver.make_drive()),
        spline(splines, flight, lambda: splines.problem(flight)),
    ]


def measured(one: Beside) -> str:
    """A row of the table."""
    result = one.make().solve(passes=one.last)
    first = least(lambda: one.make().solve(passes=one.last), 5)
    kept = one.make()
    start = kept.serialize()
    kept.solve(passes=one.last)

    def again() -> None:
        kept.deserialize(start)
        kept.solve(passes=one.last)

    pattern = one.sparsity()
    beside: dict[str, Any] = {}

    def scipy() -> None:
        beside["found"] = one.by_scipy(pattern)

    slow = least(scipy, 1)
    seconds = least(again, 9)
    return (
        f"| {one.name} | {len(one.start)} | {1e3 * first:.2f} | {1e3 * seconds:.2f} "
        f"| {1e3 * slow:.0f} | {slow / first:.0f} | {slow / seconds:.0f} "
        f"| {result.end_cost:.8g} | {2 * beside['found'].cost:.8g} |"
    )


def main() -> None:
    """Print the table."""
    print(
        "| problem | variables | first [ms] | again [ms] | SciPy [ms] | SciPy / first "
        "| SciPy / again | cost | of SciPy |"
    )
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    for one in cases():
        print(measured(one), flush=True)


if __name__ == "__main__":
    main()
