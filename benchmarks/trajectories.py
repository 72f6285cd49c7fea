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
from pathlib import Path  # noqa: E402
from types import ModuleType  # noqa: E402
from typing import Any, NamedTuple  # noqa: E402

import numpy as np  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402
from scipy.sparse import csr_matrix, lil_matrix  # noqa: E402

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
    """

    name: str
    make: Callable[[], Any]
    residuals: Callable[[Any], Any]
    start: Any
    reads: list[Any]

    def sparsity(self) -> csr_matrix:
        """Pattern of the Jacobian."""
        found = lil_matrix((len(self.reads), len(self.start)), dtype=int)
        for row, columns in enumerate(self.reads):
            found[row, columns] = 1
        return csr_matrix(found)

    def by_scipy(self, pattern: csr_matrix | None = None, **settings: Any) -> Any:
        """The solution of `least_squares`."""
        pattern = self.sparsity() if pattern is None else pattern
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


def cases() -> list[Beside]:
    """The problems of the table."""
    ranges = example("range_slam")
    return [range_slam(ranges, ranges.make_field())]


def measured(one: Beside) -> str:
    """A row of the table."""
    result = one.make().solve()
    first = least(lambda: one.make().solve(), 5)
    kept = one.make()
    start = kept.serialize()
    kept.solve()

    def again() -> None:
        kept.deserialize(start)
        kept.solve()

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
