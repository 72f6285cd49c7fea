"""g2o: Levenberg-Marquardt with a sparse Cholesky factorisation (Eigen) of the whole system.

g2o weighs rotations by the vector part of the quaternion, half of the model's: the information of
an edge is scaled so that the residual is the model's own.
"""

from __future__ import annotations

import g2opy as g2o
import numpy as np

from benchmarks.peers.runner import main


class PoseGraph:
    """A g2o file; the first pose is held, which leads to the same optimum as a prior on it."""

    settings = "LM, Eigen's sparse Cholesky, block-wise AMD"

    def __init__(self, path: str) -> None:
        with open(path, encoding="utf-8") as file:
            self.spatial = "SE3" in file.readline()
        name = "SE3" if self.spatial else "SE2"
        solver = getattr(g2o, f"BlockSolver{name}")(getattr(g2o, f"LinearSolverEigen{name}")())
        self.optimizer = g2o.SparseOptimizer()
        self.optimizer.set_algorithm(g2o.OptimizationAlgorithmLevenberg(solver))
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
        self.first = {k: v.estimate() for k, v in self.vertices.items()}

    def start(self) -> None:
        for k, vertex in self.vertices.items():
            vertex.set_estimate(self.first[k])
        self.optimizer.initialize_optimization()

    def iterate(self, count: int) -> int:
        return int(self.optimizer.optimize(count))

    def answer(self) -> dict[str, np.ndarray]:
        keys = sorted(self.vertices)
        poses = [self.vertices[k].estimate() for k in keys]
        if not self.spatial:
            vectors = np.array([p.to_vector() for p in poses])
            return {"id": np.array(keys), "t": vectors[:, :2], "th": vectors[:, 2]}
        matrices = np.array([p.matrix() for p in poses])
        return {"id": np.array(keys), "t": matrices[:, :3, 3], "q": _quaternions(matrices)}


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
    main("g2o (g2opy) " + getattr(g2o, "__version__", ""), {"pose_graph": PoseGraph})
