"""Rank, freedom and dependencies by QR on matrices like those of drawings.

`python -m benchmarks.orthogonal` prints medians in milliseconds, all from Python, and NumPy's SVD
for comparison where it takes less than a minute.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from arael.runtime.orthogonal import RankQR

Doubles = NDArray[np.float64]
Row = tuple[list[int], list[float]]
Matrix = tuple[int, int, NDArray[np.int32], NDArray[np.int32], Doubles]


def matrix(n: int, rows: list[Row]) -> Matrix:
    """Compressed rows."""
    indptr = np.concatenate([[0], np.cumsum([len(at) for at, _ in rows])]).astype(np.int32)
    indices = np.array([u for at, _ in rows for u in at], dtype=np.int32)
    return len(rows), n, indptr, indices, np.array([v for _, w in rows for v in w], dtype=float)


def rectangles(count: int) -> Matrix:
    """Rectangles of four points, turned, joined at corners: distances, parallels, right angles."""
    rng = np.random.default_rng(0)
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    rows: list[Row] = [([0], [1.0]), ([1], [1.0]), ([1, 3], [-1.0, 1.0])]
    origin = np.zeros(2)
    for i in range(count):
        a, b, c, d = (list(range(8 * i + 2 * k, 8 * i + 2 * k + 2)) for k in range(4))
        u, v = turn @ [rng.uniform(1, 3), 0], turn @ [0, rng.uniform(1, 2)]
        along, across = u / np.hypot(*u), v / np.hypot(*v)
        rows.append((a + b, [*-along, *along]))
        rows.append((b + c, [*-across, *across]))
        for one, other, normal in ((a + b, d + c, across), (a + d, b + c, along)):
            rows.append((one + other, [*normal, *-normal, *-normal, *normal]))
        rows.append((a + b + d, [*(-across - along), *across, *along]))
        if i:
            e, f, g = ([j - 8 for j in k] for k in (a, b, c))
            rows += [([g[k], a[k]], [1.0, -1.0]) for k in range(2)]
            rows.append((e + f + a + b, [*across, *-across, *-across, *across]))
        origin = origin + u + v
    return matrix(8 * count, rows)


def polygon(corners: int) -> Matrix:
    """Lines of equal length, circles of equal radius at the corners, the first two fixed."""
    points = np.random.default_rng(0).normal(size=(corners, 2))
    rows: list[Row] = []
    sides = np.roll(points, -1, axis=0) - points
    sides /= np.hypot(*sides.T)[:, None]
    for i in range(1, corners):
        j = (i + 1) % corners
        at = [0, 1, 2, 3, 2 * i, 2 * i + 1, 2 * j, 2 * j + 1]
        rows.append((at, [*-sides[0], *sides[0], *sides[i], *-sides[i]]))
        rows.append(([2 * corners, 2 * corners + i], [1.0, -1.0]))
    return matrix(3 * corners, rows)


def truss(count: int) -> Matrix:
    """Bars between the points of a square grid, in directions at random."""
    rng = np.random.default_rng(0)
    rows: list[Row] = []
    for i in range(count - 1):
        for j in range(count - 1):
            for k in ((i + 1) * count + j, i * count + j + 1):
                angle = rng.uniform(0, 2 * np.pi)
                u, h = np.array([np.cos(angle), np.sin(angle)]), i * count + j
                rows.append(([2 * h, 2 * h + 1, 2 * k, 2 * k + 1], [*-u, *u]))
    return matrix(2 * count * count, rows)


def median(use: Callable[[], object], repetitions: int) -> float:
    """Median processor time in milliseconds."""
    times = []
    for _ in range(repetitions):
        begin = time.process_time_ns()
        use()
        times.append((time.process_time_ns() - begin) / 1e6)
    return statistics.median(times)


def line(name: str, made: Matrix, repetitions: int) -> str:
    """Measure one matrix."""
    m, n, indptr, indices, entries = made
    factor = RankQR(m, n, indptr, indices)
    factor.factor(entries)

    def whole() -> None:
        all_ = RankQR(m, n, indptr, indices)
        all_.factor(entries)
        _ = all_.dependent

    candidate = np.array([0, n - 1], dtype=np.int32)
    near = slice(int(indptr[m // 2]), int(indptr[m // 2 + 1]))
    columns = [
        lambda: RankQR(m, n, indptr, indices),
        lambda: factor.factor(entries),
        whole,
        lambda: factor.dependency_of(indices[near], entries[near]),
        lambda: factor.dependency_of(candidate, [1.0, -1.0]),
        lambda: factor.least_norm(np.ones(m)),
        factor.null_vectors,
    ]
    times = [f"{median(use, repetitions):.3f}" for use in columns]
    svd = "-"
    if m < 3000:
        dense = np.zeros((m, n))
        np.add.at(dense, (np.repeat(np.arange(m), np.diff(indptr)), indices), entries)
        svd = f"{median(lambda: np.linalg.svd(dense), 3):.0f}"
    cells = [name, m, n, factor.nullity, m - factor.rank, *times, svd]
    return "| " + " | ".join(map(str, cells)) + " |"


def main() -> None:
    """Print the table."""
    head = [
        *("matrix", "equations", "unknowns", "free", "dependent", "analysis", "factor"),
        *("all verdicts", "dependency near", "far", "least norm", "null vectors", "SVD"),
    ]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    print(line("rectangles", rectangles(63), 31))
    print(line("rectangles", rectangles(1251), 11))
    print(line("polygon", polygon(128), 31))
    print(line("polygon", polygon(2000), 5))
    print(line("truss", truss(70), 5))


if __name__ == "__main__":
    main()
