"""Ceres through pyceres, with the compiled cost functions of pycolmap (automatic derivatives).

Pose graphs in space: the relative pose cost; bundles: the reprojection error with two radial
coefficients, principal point held, by Schur elimination of the points; scenes: the reprojection
error of a camera rig, in pixels where the model compares angles, without damping towards the start.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pyceres
import pycolmap
from pycolmap import cost_functions

from benchmarks.peers.endings import Path
from benchmarks.peers.runner import AbsentError, main

FOCAL = 512 / np.tan(np.deg2rad(40))


class Ceres:
    """A problem with parameter blocks that are NumPy arrays."""

    linear_solver = pyceres.LinearSolverType.SPARSE_NORMAL_CHOLESKY
    settings = "LM, SPARSE_NORMAL_CHOLESKY"

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.problem = pyceres.Problem()
        self.blocks: list[np.ndarray] = []

    def remember(self) -> None:
        """Keep the start."""
        self.first = [b.copy() for b in self.blocks]

    def start(self) -> None:
        for block, first in zip(self.blocks, self.first, strict=True):
            block[:] = first

    def iterate(self, count: int, to_end: bool) -> int:
        options = pyceres.SolverOptions()
        options.linear_solver_type = self.linear_solver
        options.max_num_iterations = count
        options.num_threads = self.threads
        options.minimizer_progress_to_stdout = False
        options.logging_type = pyceres.LoggingType.SILENT
        options.function_tolerance = 1e-9 if to_end else 0.0
        if not to_end:
            options.gradient_tolerance = options.parameter_tolerance = 0.0
        summary = pyceres.SolverSummary()
        pyceres.solve(options, self.problem, summary)
        # The first entry is the start.
        return int(summary.num_successful_steps + summary.num_unsuccessful_steps - 1)

    def ways(self) -> dict[str, str]:
        return {
            "LM": "defaults",
            "LM, non-monotone": "use_nonmonotonic_steps",
            "dogleg": "DOGLEG, TRADITIONAL_DOGLEG",
        }

    def fresh(self) -> None:
        self.start()

    def solve(self, way: str, path: Path, limit: int) -> str:
        options = pyceres.SolverOptions()
        options.linear_solver_type = self.linear_solver
        options.max_num_iterations = limit
        options.num_threads = self.threads
        options.minimizer_progress_to_stdout = False
        options.logging_type = pyceres.LoggingType.SILENT
        options.use_nonmonotonic_steps = way.endswith("non-monotone")
        if way == "dogleg":
            options.trust_region_strategy_type = pyceres.TrustRegionStrategyType.DOGLEG
        marking = _Marking(path)
        options.callbacks = [marking]
        summary = pyceres.SolverSummary()
        pyceres.solve(options, self.problem, summary)
        path.mark(summary.final_cost, path.counts[-1])
        return str(summary.termination_type).rpartition(".")[2]

    def pose(self, rotation: np.ndarray, translation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Make the blocks of a pose from quaternion x y z w and translation."""
        blocks = (np.array(rotation, dtype=float), np.array(translation, dtype=float))
        for block in blocks:
            self.blocks.append(block)
            self.problem.add_parameter_block(block, len(block))
        self.problem.set_manifold(blocks[0], pyceres.EigenQuaternionManifold())
        return blocks


class _Marking(pyceres.IterationCallback):
    """Records cost and attempts at the start and after each iteration, which is one attempt."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path

    def __call__(self, now: pyceres.IterationSummary) -> pyceres.CallbackReturnType:
        self.path.mark(now.cost, now.iteration)
        return pyceres.CallbackReturnType.SOLVER_CONTINUE


def matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a quaternion x y z w."""
    return np.asarray(pycolmap.Rotation3d(q).matrix())


class PoseGraph(Ceres):
    """A g2o file in space; poses are held as world to body, as the cost function wants them."""

    def __init__(self, path: str, threads: int) -> None:
        super().__init__(threads)
        self.poses: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        edges = []
        with open(path, encoding="utf-8") as file:
            for line in file:
                tag, *words = line.split()
                values = np.array(words, dtype=float)
                if tag == "VERTEX_SE3:QUAT":
                    inverse = pycolmap.Rigid3d(_rotation(values[4:8]), values[1:4]).inverse()
                    self.poses[int(words[0])] = self.pose(
                        inverse.rotation.quat, inverse.translation
                    )
                elif tag == "EDGE_SE3:QUAT":
                    edges.append((int(words[0]), int(words[1]), values[2:9], values[9:]))
        if not self.poses:
            raise AbsentError("pyceres compares poses in space only")
        for a, b, measured, upper in edges:
            information = np.zeros((6, 6))
            information[np.triu_indices(6)] = upper
            information = information + np.triu(information, 1).T
            # Rotation before translation here. With the second pose first the error is the
            # model's, but for a rotation that isotropic covariances do not see.
            swap = [3, 4, 5, 0, 1, 2]
            covariance = np.linalg.inv(information[np.ix_(swap, swap)])
            motion = pycolmap.Rigid3d(_rotation(measured[3:7]), measured[:3])
            cost = cost_functions.RelativePosePriorCost(covariance, motion.inverse())
            self.problem.add_residual_block(cost, None, [*self.poses[b], *self.poses[a]])
        for block in next(iter(self.poses.values())):
            self.problem.set_parameter_block_constant(block)
        self.remember()

    def answer(self) -> dict[str, np.ndarray]:
        found = [
            pycolmap.Rigid3d(pycolmap.Rotation3d(q), t).inverse() for q, t in self.poses.values()
        ]
        q = np.array([p.rotation.quat for p in found])[:, [3, 0, 1, 2]]
        return {
            "id": np.array(list(self.poses)),
            "t": np.array([p.translation for p in found]),
            "q": q,
        }


def _rotation(q: np.ndarray) -> pycolmap.Rotation3d:
    return pycolmap.Rotation3d(q / np.linalg.norm(q))


class Bundle(Ceres):
    """A BAL file."""

    linear_solver = pyceres.LinearSolverType.SPARSE_SCHUR
    settings = "LM, SPARSE_SCHUR (points eliminated)"

    def __init__(self, path: str, threads: int) -> None:
        super().__init__(threads)
        with open(path, encoding="utf-8") as file:
            values = np.array(file.read().split(), dtype=float)
        cameras, _, seen = values[:3].astype(int)
        observed = values[3 : 3 + 4 * seen].reshape(-1, 4)
        rest = values[3 + 4 * seen :]
        turn = np.diag([1.0, -1.0, -1.0])  # BAL looks along -z, these cameras along +z
        self.cameras = []
        for row in rest[: 9 * cameras].reshape(-1, 9):
            rotation = turn @ _matrix_of_vector(row[:3])
            blocks = self.pose(pycolmap.Rotation3d(rotation).quat, turn @ row[3:6])
            lens = np.array([row[6], 0.0, 0.0, row[7], row[8]])
            self.blocks.append(lens)
            self.problem.add_parameter_block(lens, 5)
            self.problem.set_manifold(lens, pyceres.SubsetManifold(5, [1, 2]))
            self.cameras.append((*blocks, lens))
        self.points = rest[9 * cameras :].reshape(-1, 3)
        self.point_blocks = [row.copy() for row in self.points]
        self.blocks += self.point_blocks
        for c, p, x, y in observed:
            rotation, translation, lens = self.cameras[int(c)]
            cost = cost_functions.ReprojErrorCost(pycolmap.CameraModelId.RADIAL, np.array([x, -y]))
            self.problem.add_residual_block(
                cost, None, [rotation, translation, self.point_blocks[int(p)], lens]
            )
        self.remember()

    def answer(self) -> dict[str, np.ndarray]:
        turn = np.diag([1.0, -1.0, -1.0])
        rotations = [turn @ matrix(q) for q, _, _ in self.cameras]
        lens = np.array([lens for _, _, lens in self.cameras])
        return {
            "r": np.array([_vector_of_matrix(r) for r in rotations]),
            "t": np.array([turn @ t for _, t, _ in self.cameras]),
            "f": lens[:, 0],
            "k1": lens[:, 3],
            "k2": lens[:, 4],
            "pos": np.array(self.point_blocks),
        }


def _matrix_of_vector(v: np.ndarray) -> np.ndarray:
    angle = np.linalg.norm(v)
    axis = v / angle if angle > 0 else v
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def _vector_of_matrix(m: np.ndarray) -> np.ndarray:
    q = np.asarray(pycolmap.Rotation3d(m).quat)
    q = q if q[3] >= 0 else -q
    length = np.linalg.norm(q[:3])
    return 2 * np.arctan2(length, q[3]) / max(length, 1e-300) * q[:3]


class Slam(Ceres):
    """A scene; the tilt sensor is a prior on the whole pose, loose but for roll and pitch.

    In a localisation the landmarks are `known`: constant.
    """

    settings = "LM, SPARSE_SCHUR (landmarks eliminated)"
    residuals = "of scenes: pixels instead of angles"
    linear_solver = pyceres.LinearSolverType.SPARSE_SCHUR

    def __init__(self, path: str, threads: int, known: bool = False) -> None:
        super().__init__(threads)
        if known:
            self.linear_solver = pyceres.LinearSolverType.SPARSE_NORMAL_CHOLESKY
            self.settings = "LM, SPARSE_NORMAL_CHOLESKY"
        data = dict(np.load(path))
        bodies = [
            pycolmap.Rigid3d(pycolmap.Rotation3d(_matrix_of_euler(ea)), pos).inverse()
            for ea, pos in zip(data["ea"], data["pos"], strict=True)
        ]
        self.poses = [self.pose(b.rotation.quat, b.translation) for b in bodies]
        self.landmarks = [row.copy() for row in data["true_landmarks" if known else "landmarks"]]
        self.blocks += self.landmarks
        lens = np.array([FOCAL, FOCAL, 512.0, 384.0])
        self.lens = lens
        self.problem.add_parameter_block(lens, 4)
        self.problem.set_parameter_block_constant(lens)
        sensors = [
            pycolmap.Rigid3d(pycolmap.Rotation3d(axes), pos).inverse()
            for axes, pos in zip(data["camera_axes"], data["camera_pos"], strict=True)
        ]
        for i, j, c, pixel in zip(
            data["obs_pose"], data["obs_landmark"], data["obs_camera"], data["obs_pixel"],
            strict=True,
        ):  # fmt: skip
            cost = cost_functions.RigReprojErrorCost(
                pycolmap.CameraModelId.PINHOLE, pixel, sensors[c]
            )
            blocks = [*self.poses[i], self.landmarks[j], lens]
            self.problem.add_residual_block(cost, None, blocks)
        if known:
            for landmark in self.landmarks:
                self.problem.set_parameter_block_constant(landmark)
        for k in range(1, len(self.poses)):
            sigmas = np.concatenate([data["delta_ea_sigma"][k], data["delta_pos_sigma"][k]])
            rotation = pycolmap.Rotation3d(_matrix_of_euler(data["delta_ea"][k]))
            motion = pycolmap.Rigid3d(rotation, data["delta_pos"][k])
            cost = cost_functions.RelativePosePriorCost(np.diag(sigmas**2), motion)
            self.problem.add_residual_block(cost, None, [*self.poses[k - 1], *self.poses[k]])
        for blocks, gps in zip(self.poses, [] if known else data["gps"], strict=not known):
            cost = cost_functions.AbsolutePosePositionPriorCost(np.eye(3) * 2.5**2, gps)
            self.problem.add_residual_block(cost, None, list(blocks))
        loose = np.diag([np.deg2rad(0.25) ** 2] * 2 + [1e4] + [1e10] * 3)
        for blocks, ea, tilt in zip(self.poses, data["ea"], data["tilt"], strict=True):
            rotation = pycolmap.Rotation3d(_matrix_of_euler(np.array([*tilt, ea[2]]))).inverse()
            level = pycolmap.Rigid3d(rotation, np.zeros(3))
            cost = cost_functions.AbsolutePosePriorCost(loose, level)
            self.problem.add_residual_block(cost, None, list(blocks))
        self.remember()

    def answer(self) -> dict[str, np.ndarray]:
        bodies = [pycolmap.Rigid3d(pycolmap.Rotation3d(q), t).inverse() for q, t in self.poses]
        return {
            "pos": np.array([b.translation for b in bodies]),
            "rotation": np.array([b.rotation.matrix() for b in bodies]),
            "landmarks": np.array(self.landmarks),
        }


def _matrix_of_euler(ea: np.ndarray) -> np.ndarray:
    (sr, sp, sy), (cr, cp, cy) = np.sin(ea), np.cos(ea)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


if __name__ == "__main__":
    main(
        f"Ceres {pycolmap.__ceres_version__} (pyceres {pyceres.__version__})"
        if hasattr(pyceres, "__version__")
        else f"Ceres {pycolmap.__ceres_version__}",
        {
            "pose_graph": PoseGraph,
            "bundle": Bundle,
            "slam": Slam,
            "localization": partial(Slam, known=True),
        },
    )
