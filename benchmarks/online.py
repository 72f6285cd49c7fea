"""An estimate after every pose: `Model.update` beside GTSAM's iSAM2, by turns.

Poses are taken in one at a time with the measurements whose last pose they are, from guesses by
odometry at the newest estimate. Times include appending the rows, the update, and reading the
newest pose; the guess is computed outside of them. The first step of a file is left out.

A fixed lag: a planar robot with a window of 30 poses, whose oldest pose is marginalised after each
update; times and memory of the second and the last tenth of the way.

``python -m benchmarks.online FILE [--poses N]`` prints the figures of one file,
``python -m benchmarks.online scene [--poses N]`` and ``lag`` those of the SLAM scene and the fixed
lag.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import sys
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import arael
from benchmarks.cases import DATA
from benchmarks.problems import pose_graph_model

FILES = (
    "pose_graph_2d/intel.g2o",
    "pose_graph_2d/M3500.g2o",
    "pose_graph_3d/parking-garage.g2o",
    "pose_graph_3d/sphere2500.g2o",
    "landmark_2d/victoria_park.txt",
)
EVERY = 100
"""Steps between comparisons with the batch optimum."""


@dataclass
class Measured:
    """Milliseconds of each step, and how far costs were above the batch optimum."""

    name: str
    times: list[float] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)
    above: list[float] = field(default_factory=list)
    full: int = 0

    def figures(self) -> str:
        """Mean, 99th percentile and maximum."""
        if not self.times:
            return "-"
        high = np.percentile(self.times, 99)
        return f"{statistics.fmean(self.times):.3g} / {high:.3g} / {max(self.times):.3g}"


class Stream:
    """A file as a sequence of steps: per pose, the rows of the edges that it completes.

    Attributes
    ----------
    whole : the model with all data
    last : (edges,) the later pose of each edge
    order : (edges,) edges by their later pose
    """

    def __init__(self, path: Path, poses: int | None) -> None:
        self.path = path
        name = "pose_graph_2d" if path.suffix == ".txt" else pose_graph_model(path)
        self.flat = name == "pose_graph_2d"
        self.model = arael.load(name)
        self.whole = self.model()
        if path.suffix == ".txt":
            fill_park(self.whole, path)
        else:
            self.whole.read(path)
        edges = self.whole.edges
        self.a, self.b = rows(edges, "a"), rows(edges, "b")
        self.turn = "th" if self.flat else "q"
        names = ["t", self.turn, "u"]
        self.edge = {name: np.array(value_of(getattr(edges, name))) for name in names}
        self.start = {
            name: np.array(getattr(self.whole.poses, name).value) for name in ("t", self.turn)
        }
        self.held = np.array(self.whole.poses.t.fixed)
        self.poses = min(poses or len(self.whole.poses), len(self.whole.poses))
        last = np.maximum(self.a, self.b)
        self.of_pose = [np.flatnonzero(last == k) for k in range(self.poses)]
        self.landmarks = len(self.whole.landmarks)
        if self.landmarks:
            seen = self.whole.observations
            self.pose, self.mark = rows(seen, "a"), rows(seen, "b")
            self.sight = {name: np.array(value_of(getattr(seen, name))) for name in ("t", "u")}
            self.seen_at = [np.flatnonzero(self.pose == k) for k in range(self.poses)]

    def guess(self, k: int, pose_of: Any) -> Any:
        """Pose k by an edge from an earlier one at its estimate, or as the file has it."""
        for e in self.of_pose[k]:
            if self.b[e] == k:
                t, turn = pose_of(int(self.a[e]))
                return compose(self.flat, t, turn, self.edge["t"][e], self.edge[self.turn][e])
        return self.start["t"][k], self.start[self.turn][k]


def fill_park(model: Any, path: Path) -> None:
    """Victoria Park: odometry, sights of trees, covariances, as in GTSAM's examples."""
    number, marks = {0: 0}, {}  # type: tuple[dict[int, int], dict[int, int]]
    pose, turn = np.zeros(2), 0.0
    model.poses.append(t=pose, th=turn)
    for text in path.read_text(encoding="ascii").splitlines():
        kind, *words = text.split()
        values = [float(word) for word in words]
        if kind == "ODOMETRY":
            a, b = number[int(values[0])], len(number)
            number[int(values[1])] = b
            pose, turn = compose(True, pose, turn, values[2:4], values[4])
            model.poses.append(t=pose, th=turn)
            u = np.diag(1 / np.sqrt([values[5], values[8], values[10]]))
            model.edges.append(a=model.poses[a], b=model.poses[b], t=values[2:4], th=values[4], u=u)
            continue
        mark = marks.setdefault(int(values[1]), len(marks))
        if mark == len(model.landmarks):
            model.landmarks.append(t=pose)
        row = model.poses[number[int(values[0])]]
        u = np.diag(1 / np.sqrt([values[4], values[6]]))
        model.observations.append(a=row, b=model.landmarks[mark], t=values[2:4], u=u)


def rows(collection: Any, name: str) -> np.ndarray:
    """Rows that a ref of a collection names."""
    return np.array(collection._table.target_rows(name))


def value_of(found: Any) -> Any:
    """Values of data or of a parameter."""
    return getattr(found, "value", found)


def compose(flat: bool, t: Any, turn: Any, dt: Any, dturn: Any) -> tuple[np.ndarray, Any]:
    """A pose followed by a relative one."""
    if flat:
        c, s = np.cos(turn), np.sin(turn)
        return np.array([t[0] + c * dt[0] - s * dt[1], t[1] + s * dt[0] + c * dt[1]]), turn + dturn
    w, v = turn[0], np.asarray(turn[1:])
    moved = dt + 2 * np.cross(v, np.cross(v, dt) + w * np.asarray(dt))
    dw, dv = dturn[0], np.asarray(dturn[1:])
    q = np.array([w * dw - v @ dv, *(w * dv + dw * v + np.cross(v, dv))])
    return t + moved, q / np.linalg.norm(q)


def arael_steps(stream: Stream, check: bool, **settings: Any) -> Iterator[Measured]:
    """Steps of arael; yields after each."""
    model, found = stream.model(), Measured("arael")
    poses, edges, turn = model.poses, model.edges, stream.turn
    refs: list[Any] = []
    marks: dict[int, Any] = {}
    clock = time.thread_time

    def pose_of(k: int) -> Any:
        return np.array(refs[k].t.value), value_of(refs[k][turn])

    for k in range(stream.poses):
        t, th = stream.guess(k, pose_of)
        data = stream.edge
        if stream.landmarks:
            c, s = np.cos(th), np.sin(th)
            sights = [
                (int(stream.mark[o]), t + np.array([[c, -s], [s, c]]) @ stream.sight["t"][o], o)
                for o in stream.seen_at[k]
            ]
        began = clock()
        refs.append(poses.append(t=t, **{turn: th}))
        if k == 0:
            refs[0].t.optimize = refs[0][turn].optimize = False
        for e in stream.of_pose[k]:
            values = {"t": data["t"][e], turn: data[turn][e], "u": data["u"][e]}
            edges.append(a=refs[stream.a[e]], b=refs[stream.b[e]], **values)
        if stream.landmarks:
            for mark, place, o in sights:
                if mark not in marks:
                    marks[mark] = model.landmarks.append(t=place)
                model.observations.append(
                    a=refs[k], b=marks[mark], t=stream.sight["t"][o], u=stream.sight["u"][o]
                )
        if k:
            result = model.update(**settings)
            value_of(refs[-1].t)
            found.times.append(1e3 * (clock() - began))
            found.costs.append(result.cost)
            found.full += result.full
            if check and k % EVERY == 0:
                found.above.append(above(model))
        yield found


def above(model: Any) -> float:
    """How far the cost is above the optimum, relative to it."""
    now = model.cost()
    copy = model.copy()
    best = copy.solve(passes=[], rel_precision=1e-12, abs_precision=0.0, max_iters=100).end_cost
    return max(0.0, now / best - 1) if best > 0 else 0.0


def gtsam_steps(stream: Stream, check: bool) -> Iterator[Measured]:
    """Steps of iSAM2 on the same stream; yields after each."""
    import gtsam

    found = Measured("iSAM2")
    parameters = gtsam.ISAM2Params()
    parameters.setRelinearizeThreshold(0.01)
    smoother = gtsam.ISAM2(parameters)
    clock = time.thread_time
    landmarks = set()
    whole = gtsam.NonlinearFactorGraph()
    if stream.flat:
        between, wide = gtsam.BetweenFactorPose2, 3

        def edge(e: int) -> Any:
            return gtsam.Pose2(*stream.edge["t"][e], float(stream.edge["th"][e]))
    else:
        graph, _ = gtsam.readG2o(str(stream.path), True)
        between, wide = gtsam.BetweenFactorPose3, 6

    def noise(u: Any) -> Any:
        return gtsam.noiseModel.Gaussian.SqrtInformation(np.asarray(u))

    estimate: Any = None

    def pose_of(k: int) -> Any:
        if stream.flat:
            pose = smoother.calculateEstimatePose2(k)
            return np.array([pose.x(), pose.y()]), pose.theta()
        pose = smoother.calculateEstimatePose3(k)
        q = pose.rotation().toQuaternion()
        return pose.translation(), np.array([q.w(), q.x(), q.y(), q.z()])

    for k in range(stream.poses):
        t, turn = stream.guess(k, pose_of)
        values, factors = gtsam.Values(), gtsam.NonlinearFactorGraph()
        if stream.landmarks:
            c, s = np.cos(turn), np.sin(turn)
            sights = [
                (int(stream.mark[o]), t + np.array([[c, -s], [s, c]]) @ stream.sight["t"][o], o)
                for o in stream.seen_at[k]
            ]
        began = clock()
        if stream.flat:
            pose = gtsam.Pose2(t[0], t[1], float(turn))
        else:
            pose = gtsam.Pose3(gtsam.Rot3(*turn), np.asarray(t))
        values.insert(k, pose)
        if k == 0:
            held = gtsam.noiseModel.Isotropic.Sigma(wide, 1e-6)
            prior = gtsam.PriorFactorPose2 if stream.flat else gtsam.PriorFactorPose3
            factors.add(prior(0, pose, held))
        for e in stream.of_pose[k]:
            if stream.flat:
                model = noise(stream.edge["u"][e])
                factors.add(between(int(stream.a[e]), int(stream.b[e]), edge(e), model))
            else:
                factors.add(graph.at(int(e)))
        if stream.landmarks:
            for mark, place, o in sights:
                key = 10_000_000 + mark
                if mark not in landmarks:
                    landmarks.add(mark)
                    values.insert(key, gtsam.Point2(*place))
                x, y = stream.sight["t"][o]
                bearing = gtsam.Rot2(float(np.arctan2(y, x)))
                distance = float(np.hypot(x, y))
                factors.add(
                    gtsam.BearingRangeFactor2D(
                        k, key, bearing, distance,
                        polar_noise(gtsam, stream.sight["u"][o], x, y),
                    )
                )  # fmt: skip
        smoother.update(factors, values)
        if stream.flat:
            smoother.calculateEstimatePose2(k)
        else:
            smoother.calculateEstimatePose3(k)
        if k:
            found.times.append(1e3 * (clock() - began))
        if check:
            whole.push_back(factors)
        if check and k and k % EVERY == 0:
            estimate = smoother.calculateEstimate()
            now = whole.error(estimate)
            stop = gtsam.LevenbergMarquardtParams()
            stop.setRelativeErrorTol(1e-12)
            best = gtsam.LevenbergMarquardtOptimizer(whole, estimate, stop).optimize()
            found.above.append(max(0.0, now / whole.error(best) - 1))
        yield found


def polar_noise(gtsam: Any, u: Any, x: float, y: float) -> Any:
    """Noise of a Cartesian sight as one of bearing and range."""
    r = float(np.hypot(x, y))
    by = np.array([[-y, x / r], [x, y / r]])  # d(x, y) by (bearing, range)
    return gtsam.noiseModel.Gaussian.SqrtInformation(
        np.linalg.cholesky((np.asarray(u) @ by).T @ (np.asarray(u) @ by)).T
    )


def measure(path: Path, poses: int | None, check: bool, peers: bool) -> list[Measured]:
    """Both by turns, a step of one and a step of the other."""
    stream = Stream(path, poses)
    runs = [arael_steps(stream, check)]
    if peers:
        runs.append(gtsam_steps(stream, check))
    found: list[Measured] = []
    for found in map(list, zip(*runs, strict=True)):  # noqa: B007
        pass
    return found


def line(path: Path, one: Measured) -> str:
    """A row of the table."""
    worst = f"{max(one.above):.1e}" if one.above else "-"
    return f"| {path.stem} | {one.name} | {one.figures()} | {worst} | {one.full or ''} |"


def scene_steps(poses: int, check: bool) -> Measured:
    """The SLAM scene of the demo, a pose with its observations at a time, from its starts."""
    from arael.online.recording import Recording
    from arael.scenes import SceneConfig, columns, fill, make_scene

    load, clock = arael.load("slam"), time.thread_time
    whole, found = load(), Measured("arael")
    scene = make_scene(SceneConfig(trajectory="s-curve", poses=poses))
    fill(whole, whole._store.layout, columns(scene))
    model = load()
    steps = Recording(whole, "poses").replay(model)
    for k in range(poses):
        began = clock()
        next(steps)
        result = model.update()
        value_of(model.poses[-1].pos)
        if k:
            found.times.append(1e3 * (clock() - began))
            found.full += result.full
        if check and k and k % EVERY == 0:
            found.above.append(above(model))
    return found


def fixed_lag(poses: int, window: int = 30) -> list[str]:
    """Rows of a table: a window that slides, times and memory by tenths of the way."""
    rng = np.random.default_rng(1)
    model = arael.load("pose_graph_2d")()
    clock, u = time.thread_time, np.diag([50.0, 50.0, 200.0])
    refs = deque([model.poses.append(t=[0, 0], th=0)], maxlen=window + 1)
    model.anchors.append(pose=refs[0], t=[0, 0], th=0, u=2 * u)
    times, memory, full = np.zeros(poses), np.zeros(poses), 0
    place, fix = np.zeros(3), np.diag([1.0, 1.0, 10.0])
    for k in range(poses):
        # The way bends to and fro; odometry, every third step a sight of three poses back, and
        # every tenth a coarse fix, without which the covariance of the window grows without end.
        bend = 0.1 * np.cos(0.01 * k)
        c, s = np.cos(place[2]), np.sin(place[2])
        place += np.array([c, s, bend])
        last, back = refs[-1], refs[-3] if k % 3 == 2 and len(refs) > 3 else None
        d, turn = [1.0, 0.0] + 0.02 * rng.normal(size=2), bend + 0.005 * rng.normal()
        t, th = compose(True, last.t.value, last.th.value, d, turn)
        if back is not None:
            ways = np.cumsum([0, 0.1 * np.cos(0.01 * (k - 2)), 0.1 * np.cos(0.01 * (k - 1))])
            way = np.array([np.cos(ways).sum(), np.sin(ways).sum()]) + 0.02 * rng.normal(size=2)
            far = ways[-1] + bend + 0.005 * rng.normal()
        began = clock()
        pose = model.poses.append(t=t, th=th)
        model.edges.append(a=last, b=pose, t=d, th=turn, u=u)
        if back is not None:
            model.edges.append(a=back, b=pose, t=way, th=far, u=u)
        if k % 10 == 0:
            model.anchors.append(pose=pose, t=place[:2] + rng.normal(size=2), th=place[2], u=fix)
        full += model.update().full
        value_of(pose.t)
        if len(model.poses) > window:
            model.marginalise(model.poses[0])
        times[k] = 1e3 * (clock() - began)
        refs.append(pose)
        memory[k] = resident()
    tenth = poses // 10
    rows = []
    for name, part in (("second", slice(tenth, 2 * tenth)), ("last", slice(-tenth, None))):
        mean, high = times[part].mean(), np.percentile(times[part], 99)
        rows.append(
            f"| {name} | {mean:.3g} / {high:.3g} / {times[part].max():.3g} |"
            f" {memory[part].mean():.1f} | {full} |"
        )
    return rows


def resident() -> float:
    """Megabytes of memory of this process."""
    fields = Path("/proc/self/statm").read_text(encoding="ascii").split()
    return int(fields[1]) * resource.getpagesize() / 1e6


def run(plan: Any, picture: Path | None = None) -> list[str]:
    """The suite."""
    lines = [
        "## online", "",
        "One pose at a time; milliseconds mean / 99th percentile / maximum; the largest distance of"
        " the cost to the batch optimum, of every hundredth step.", "",
        "| data | system | ms | above optimum | full solves |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for name in FILES:
        path = DATA / name
        if not path.exists():
            lines.append(f"| {path.stem} | not there (`ARAEL_DATA`) | | | |")
            continue
        poses = 300 if plan.quick else None
        for one in measure(path, poses, not plan.quick, "gtsam" in plan.peers):
            lines.append(line(path, one))
    scene = scene_steps(60 if plan.quick else 900, not plan.quick)
    lines.append(line(Path("SLAM scene"), scene))
    poses = 2000 if plan.quick else 100_000
    lines += [
        "", f"A window of 30 poses over {poses} poses: append, update, read, marginalise.", "",
        "| tenth of the way | ms | MB | full solves |", "|---|---|---|---|",
    ]  # fmt: skip
    return lines + fixed_lag(poses)


def main() -> None:
    """Figures of one file."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.online")
    parser.add_argument("file", type=Path, help="or `scene`, or `lag`")
    parser.add_argument("--poses", type=int)
    parser.add_argument("--check", action="store_true", help="compare with the batch optimum")
    parser.add_argument("--alone", action="store_true", help="without iSAM2")
    chosen = parser.parse_args()
    if str(chosen.file) == "scene":
        one = scene_steps(chosen.poses or 900, chosen.check)
        sys.stdout.write(line(chosen.file, one) + "\n")
        return
    if str(chosen.file) == "lag":
        sys.stdout.write("\n".join(fixed_lag(chosen.poses or 100_000)) + "\n")
        return
    for one in measure(chosen.file, chosen.poses, chosen.check, not chosen.alone):
        sys.stdout.write(line(chosen.file, one) + "\n")


if __name__ == "__main__":
    main()
