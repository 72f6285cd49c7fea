"""g2o: Levenberg-Marquardt with Eigen's sparse Cholesky factorisation, landmarks eliminated first.

g2o weighs rotations by the vector part of the quaternion, half of the model's: the information of
an edge is scaled so that the residual is the model's own. Scenes have g2o's depth projection with
depth of no weight in the place of the angular residuals, priors on whole poses, loose but for what
was measured, for GPS and tilt, and no damping towards the start. Bundles and planes,
for which the wheel has no edges with the model's residuals, are left to `g2o_program`.

To the end (`benchmarks.peers.endings`) by Levenberg-Marquardt, Gauss-Newton and dogleg, with the
action that g2o has for ending: a relative gain below 1e-6.
"""

from __future__ import annotations

import tempfile
import time
from functools import partial
from importlib.metadata import version
from pathlib import Path

import g2opy as g2o
import numpy as np

from benchmarks.peers.endings import Path as Recorded
from benchmarks.peers.runner import main

ALGORITHMS = {
    "LM": g2o.OptimizationAlgorithmLevenberg,
    "GN": g2o.OptimizationAlgorithmGaussNewton,
    "dogleg": g2o.OptimizationAlgorithmDogleg,
}
FOCAL = 512 / np.tan(np.deg2rad(40))


class G2o:
    """An optimizer with the start of its vertices."""

    settings = "LM, Eigen's sparse Cholesky, block-wise AMD"
    optimizer: g2o.SparseOptimizer

    def remember(self) -> None:
        """Keep the start."""
        self.vertices = self.optimizer.vertices()
        self.first = {k: v.estimate() for k, v in self.vertices.items()}

    def start(self) -> None:
        for k, vertex in self.vertices.items():
            vertex.set_estimate(self.first[k])
        self.optimizer.initialize_optimization()

    def iterate(self, count: int, to_end: bool) -> int:
        return int(self.optimizer.optimize(count))

    def ways(self) -> dict[str, str]:
        ending = "SparseOptimizerTerminateAction"
        return {name: f"{ALGORITHMS[name].__name__}, {ending}" for name in ALGORITHMS}

    def solver(self) -> object:
        """A block solver of this problem's kind."""
        return g2o.BlockSolverSE3(g2o.LinearSolverEigenSE3())

    def fresh(self) -> None:
        for k, vertex in self.vertices.items():
            vertex.set_estimate(self.first[k])

    def solve(self, way: str, path: Recorded, limit: int) -> str:
        self.algorithm = ALGORITHMS[way](self.solver())
        self.optimizer.set_algorithm(self.algorithm)
        self.optimizer.set_compute_batch_statistics(True)
        ending = g2o.SparseOptimizerTerminateAction()
        ending.set_max_iterations(limit)
        self.optimizer.add_post_iteration_action(ending)
        began, wall = time.process_time(), time.perf_counter()
        self.optimizer.initialize_optimization()
        self.optimizer.compute_active_errors()
        path.mark(self.optimizer.active_chi2(), 0)
        before = time.perf_counter() - wall
        done = int(self.optimizer.optimize(limit))
        self.optimizer.remove_post_iteration_action(ending)
        found = self.optimizer.batch_statistics()[: max(done, 0)]
        # Iterations are timed by the clock; they are scaled to the processor's time.
        scale = (time.process_time() - began) / (time.perf_counter() - wall)
        attempts = 0
        for one in found:
            before += one.time_iteration
            attempts += max(one.levenberg_iterations, 1)
            path.mark(one.chi2, attempts)
            path.times[-1] = scale * before
        return f"ended after {done} iterations" if done < limit else "limit of iterations"


class PoseGraph(G2o):
    """A g2o file; the first pose is held, which leads to the same optimum as a prior on it."""

    def __init__(self, path: str, threads: int) -> None:
        with open(path, encoding="utf-8") as file:
            self.spatial = "SE3" in file.readline()
        self.optimizer = g2o.SparseOptimizer()
        self.optimizer.set_algorithm(g2o.OptimizationAlgorithmLevenberg(self.solver()))
        if not self.optimizer.load(path):
            raise SystemExit(f"g2o cannot read {path}")
        self.vertices = self.optimizer.vertices()
        with open(path, encoding="utf-8") as file:
            first = next(int(line.split()[1]) for line in file if line.startswith("VERTEX"))
        self.vertices[first].set_fixed(True)
        if self.spatial:
            scale = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
            for edge in self.optimizer.edges():
                edge.set_information(scale @ edge.information() @ scale)
        self.remember()

    def solver(self) -> object:
        name = "SE3" if self.spatial else "SE2"
        return getattr(g2o, f"BlockSolver{name}")(getattr(g2o, f"LinearSolverEigen{name}")())

    def answer(self) -> dict[str, np.ndarray]:
        keys = sorted(self.vertices)
        poses = [self.vertices[k].estimate() for k in keys]
        if not self.spatial:
            vectors = np.array([p.to_vector() for p in poses])
            return {"id": np.array(keys), "t": vectors[:, :2], "th": vectors[:, 2]}
        matrices = np.array([p.matrix() for p in poses])
        return {"id": np.array(keys), "t": matrices[:, :3, 3], "q": _quaternions(matrices)}


class Slam(G2o):
    """A scene, by way of a file in g2o's format: the wheel cannot set a camera's calibration."""

    residuals = "of scenes: pixels instead of angles"

    def __init__(self, path: str, threads: int, known: bool = False) -> None:
        data = dict(np.load(path))
        self.poses, self.known = len(data["pos"]), known
        self.optimizer = g2o.SparseOptimizer()
        self.optimizer.set_algorithm(g2o.OptimizationAlgorithmLevenberg(self.solver()))
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "scene.g2o"
            file.write_text("\n".join(_scene(data, known)) + "\n", encoding="ascii")
            if not self.optimizer.load(str(file)):
                raise SystemExit("g2o cannot read the scene")
        for k, vertex in self.optimizer.vertices().items():
            if k >= self.poses:
                (vertex.set_fixed if known else vertex.set_marginalized)(True)
        self.remember()

    def answer(self) -> dict[str, np.ndarray]:
        matrices = np.array([self.vertices[k].estimate().matrix() for k in range(self.poses)])
        points = [self.vertices[k].estimate() for k in sorted(self.vertices) if k >= self.poses]
        return {
            "pos": matrices[:, :3, 3],
            "rotation": matrices[:, :3, :3],
            "landmarks": np.array(points),
        }


def _scene(data: dict[str, np.ndarray], known: bool) -> list[str]:
    """Lines of g2o's format: poses are 0 .. n, landmarks follow, parameter 0 is the body."""
    poses = len(data["pos"])
    lines = ["PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1"]
    for c, (pos, axes) in enumerate(zip(data["camera_pos"], data["camera_axes"], strict=True)):
        lens = [FOCAL, FOCAL, 512.0, 384.0]
        lines.append(_line("PARAMS_CAMERACALIB", [c + 1], pos, _xyzw(axes), lens))
    turns = [_matrix(ea) for ea in data["ea"]]
    for k in range(poses):
        lines.append(_line("VERTEX_SE3:QUAT", [k], data["pos"][k], _xyzw(turns[k])))
    for j, point in enumerate(data["true_landmarks" if known else "landmarks"]):
        lines.append(_line("VERTEX_TRACKXYZ", [poses + j], point))
    weights = _upper(np.diag([1.0, 1.0, 0.0]))
    for i, j, c, pixel in zip(
        data["obs_pose"], data["obs_landmark"], data["obs_camera"], data["obs_pixel"],
        strict=True,
    ):  # fmt: skip
        ends = [int(i), poses + int(j), int(c) + 1]
        lines.append(_line("EDGE_PROJECT_DEPTH", ends, pixel, [0.0], weights))
    for k in range(1, poses):
        # Half of the rotation vector is what g2o compares.
        sigmas = np.concatenate([data["delta_pos_sigma"][k], data["delta_ea_sigma"][k] / 2])
        turn = _xyzw(_matrix(data["delta_ea"][k]))
        weights = _upper(np.diag(sigmas**-2.0))
        lines.append(_line("EDGE_SE3:QUAT", [k - 1, k], data["delta_pos"][k], turn, weights))
    tilt = (np.deg2rad(0.25) / 2) ** -2.0
    for k in range(poses):
        level = _xyzw(_matrix(np.array([*data["tilt"][k], data["ea"][k, 2]])))
        loose = _upper(np.diag([0.0, 0.0, 0.0, tilt, tilt, 0.0]))
        lines.append(_line("EDGE_SE3_PRIOR", [k, 0], np.zeros(3), level, loose))
        if not known:
            fix = _upper(np.diag([2.5**-2.0] * 3 + [0.0] * 3))
            # Compared in the frame of the body: isotropic, so the same.
            lines.append(_line("EDGE_SE3_PRIOR", [k, 0], data["gps"][k], level, fix))
    return lines


def _line(tag: str, numbers: list[int], *values: object) -> str:
    reals = [repr(float(v)) for part in values for v in np.asarray(part).ravel()]
    return " ".join([tag, *(str(n) for n in numbers), *reals])


def _upper(matrix: np.ndarray) -> np.ndarray:
    return np.asarray(matrix[np.triu_indices(len(matrix))])


def _xyzw(matrix: np.ndarray) -> np.ndarray:
    return _quaternions(matrix[None])[0, [1, 2, 3, 0]]


def _matrix(ea: np.ndarray) -> np.ndarray:
    (sr, sp, sy), (cr, cp, cy) = np.sin(ea), np.cos(ea)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _quaternions(matrices: np.ndarray) -> np.ndarray:
    """Unit quaternions (n, 4), w x y z, of rotations, by the largest eigenvector of Bar-Itzhack."""
    found = []
    for m in matrices[:, :3, :3]:
        k = np.array(
            [
                [np.trace(m), m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
                [0.0, m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
                [0.0, 0.0, m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1]],
                [0.0, 0.0, 0.0, m[2, 2] - m[0, 0] - m[1, 1]],
            ]
        )
        vectors = np.linalg.eigh(k, UPLO="U")[1]
        found.append(vectors[:, -1])
    return np.array(found)


if __name__ == "__main__":
    main(
        f"g2o {version('g2opy')}",
        {
            "pose_graph": PoseGraph,
            "slam": Slam,
            "localization": partial(Slam, known=True),
        },
    )
