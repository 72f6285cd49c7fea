"""Generated pose graphs whose odometry is a hard start, and files without vertices.

Surfaces with many loops (sphere, torus), a corridor with few, a planar ring, and a city of blocks
with strong noise of rotation; noise is normal, and its sigmas are the information of the edges. All
start from the chain of odometry.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Edges = NDArray[np.int64]


def has_vertices(path: Path) -> bool:
    """Whether a g2o file gives its poses start values."""
    with path.open(encoding="utf-8") as file:
        return any(line.startswith("VERTEX") for line in file)


def with_odometry(path: Path, folder: Path) -> Path:
    """A planar file with poses composed along its edges from each pose to the next."""
    lines = path.read_text(encoding="utf-8").splitlines()
    chain: dict[int, Array] = {}
    for line in lines:
        tag, *words = line.split() or [""]
        if tag != "EDGE_SE2" or int(words[1]) != int(words[0]) + 1:
            continue
        x, y, th = chain.setdefault(int(words[0]), np.zeros(3))
        dx, dy, turn = (float(w) for w in words[2:5])
        c, s = np.cos(th), np.sin(th)
        chain[int(words[1])] = np.array([x + c * dx - s * dy, y + s * dx + c * dy, th + turn])
    poses = [f"VERTEX_SE2 {k} {x!r} {y!r} {th!r}" for k, (x, y, th) in _floats(chain.items())]
    out = folder / path.name
    out.write_text("\n".join([*poses, *lines]) + "\n", encoding="utf-8")
    return out


def _floats(rows: Iterable[tuple[int, Array]]) -> Iterable[tuple[int, list[float]]]:
    return ((k, [float(v) for v in row]) for k, row in rows)


def sphere(path: Path, rings: int = 20, around: int = 40, turn: float = 0.15) -> int:
    """Rings from pole to pole of a sphere with a radius of 10 m."""
    lat = np.repeat(np.linspace(-1.3, 1.3, rings), around)
    lon = np.tile(np.arange(around) * 2 * np.pi / around, rings)
    c, s = np.cos(lon), np.sin(lon)
    normal = np.column_stack([np.cos(lat) * c, np.cos(lat) * s, np.sin(lat)])
    turns = _frames(np.column_stack([-s, c, 0 * c]), normal)
    return _spatial(path, turns, 10 * normal, _grid(rings, around, False), turn, 0.05)


def torus(path: Path, rings: int = 40, around: int = 25, turn: float = 0.15) -> int:
    """Rings round the tube of a torus, one beside the other."""
    big = np.repeat(np.arange(rings) * 2 * np.pi / rings, around)
    small = np.tile(np.arange(around) * 2 * np.pi / around, rings)
    out = np.column_stack([np.cos(big), np.sin(big), 0 * big])
    up = np.array([0.0, 0.0, 1.0])
    normal = np.cos(small)[:, None] * out + np.sin(small)[:, None] * up
    along = -np.sin(small)[:, None] * out + np.cos(small)[:, None] * up
    edges = _grid(rings, around, True)
    return _spatial(path, _frames(along, normal), 10 * out + 4 * normal, edges, turn, 0.05)


def corridor(path: Path, poses: int = 1000, turn: float = 0.02) -> int:
    """A long way to and fro in space that is closed at its end, and seen again every 100 poses."""
    s = np.arange(poses) * 2 * np.pi / poses
    position = np.column_stack([200 * np.cos(s), 20 * np.sin(2 * s), 5 * np.sin(3 * s)])
    along = np.roll(position, -1, axis=0) - position
    along /= np.linalg.norm(along, axis=1)[:, None]
    up = np.tile([0.0, 0.0, 1.0], (poses, 1))
    side = np.cross(up, along)
    normal = np.cross(along, side / np.linalg.norm(side, axis=1)[:, None])
    chain = np.column_stack([np.arange(poses - 1), np.arange(1, poses)])
    seen = np.arange(0, poses // 2, 100)
    edges = np.vstack([chain, [[poses - 1, 0]], np.column_stack([seen, poses - 1 - seen])])
    return _spatial(path, _frames(along, normal), position, edges, turn, 0.05)


def ring(path: Path, poses: int = 2000, turn: float = 0.02) -> int:
    """One planar loop, closed at ten places in its last tenth."""
    angle = np.arange(poses) * 2.2 * np.pi / poses
    truth = np.column_stack([100 * np.cos(angle), 100 * np.sin(angle), angle + np.pi / 2])
    late = np.linspace(0.92, 0.999, 10) * poses
    early = late - poses / 1.1
    closing = np.column_stack([np.maximum(early, 0), late]).astype(np.int64)
    chain = np.column_stack([np.arange(poses - 1), np.arange(1, poses)])
    return _planar(path, truth, np.vstack([chain, closing]), turn, 0.05)


def city(path: Path, blocks: int = 3000, turn: float = 0.2, seed: int = 4) -> int:
    """A random way along streets; crossings that were seen before close loops."""
    rng = np.random.Generator(np.random.PCG64(seed))
    at, way, truth = np.zeros(2), 0.0, []
    for _ in range(blocks):
        truth.append([*at, way])
        if rng.random() < 0.3 or np.abs(at).max() > 25:
            home = np.abs(at).max() > 25
            way = np.arctan2(*-at[::-1]) // (np.pi / 2) * (np.pi / 2) if home else way
            way += 0.0 if home else rng.choice([-1, 1]) * np.pi / 2
        at = at + np.round([np.cos(way), np.sin(way)])
    poses = np.array(truth)
    chain = np.column_stack([np.arange(blocks - 1), np.arange(1, blocks)])
    seen: dict[tuple[int, ...], int] = {}
    closing = []
    for k, place in enumerate(poses[:, :2].astype(int)):
        before = seen.get(tuple(place))
        if before is not None and k - before > 10 and rng.random() < 0.5:
            closing.append([before, k])
        seen[tuple(place)] = k
    return _planar(path, poses, np.vstack([chain, closing]), turn, 0.05)


GRAPHS: dict[str, Callable[[Path], int]] = {
    "sphere": sphere,
    "torus": torus,
    "torus-noisy": partial(torus, rings=30, around=20, turn=0.3),
    "corridor": corridor,
    "ring": ring,
    "city": city,
}


def _grid(rings: int, around: int, closed: bool) -> Edges:
    """From each pose to the next, and to the one beside it in the next ring."""
    n = rings * around
    i = np.arange(n)
    beside = np.column_stack([i, (i + around) % n])[: n if closed else n - around]
    return np.concatenate([np.column_stack([i[:-1], i[1:]]), beside])


def _frames(along: Array, normal: Array) -> Rotation:
    return Rotation.from_matrix(np.stack([along, np.cross(normal, along), normal], axis=-1))


def _spatial(
    path: Path, turns: Rotation, position: Array, edges: Edges, turn: float, shift: float
) -> int:
    rng = np.random.Generator(np.random.PCG64(7))
    a, b = edges.T
    between = turns[a].inv() * turns[b]
    moved = turns[a].inv().apply(position[b] - position[a])
    between = between * Rotation.from_rotvec(rng.normal(0, turn, (len(edges), 3)))
    moved = moved + rng.normal(0, shift, moved.shape)
    lines, at, facing = [], position[0], turns[0]
    for k in range(len(position)):
        lines.append(f"VERTEX_SE3:QUAT {k} {_words(at, facing.as_quat())}")
        if k + 1 < len(position):  # edge k leads from pose k to the next
            at = at + facing.apply(moved[k])
            facing = facing * between[k]
    upper = np.diag([shift**-2.0] * 3 + [turn**-2.0] * 3)[np.triu_indices(6)]
    for k, (i, j) in enumerate(edges):
        lines.append(f"EDGE_SE3:QUAT {i} {j} {_words(moved[k], between[k].as_quat(), upper)}")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return len(position)


def _planar(path: Path, truth: Array, edges: Edges, turn: float, shift: float) -> int:
    rng = np.random.Generator(np.random.PCG64(7))
    a, b = truth[edges[:, 0]], truth[edges[:, 1]]
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    d = b - a
    exact = np.column_stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], d[:, 2]])
    found = exact + rng.normal(0, [shift, shift, turn], exact.shape)
    found[:, 2] = np.remainder(found[:, 2] + np.pi, 2 * np.pi) - np.pi
    lines, at = [], truth[0].copy()
    for k in range(len(truth)):
        lines.append(f"VERTEX_SE2 {k} {_words(at)}")
        if k + 1 < len(truth):
            x, y, th = found[k]
            c, s = np.cos(at[2]), np.sin(at[2])
            at = at + np.array([c * x - s * y, s * x + c * y, th])
    upper = np.diag([shift**-2.0] * 2 + [turn**-2.0])[np.triu_indices(3)]
    for k, (i, j) in enumerate(edges):
        lines.append(f"EDGE_SE2 {i} {j} {_words(found[k], upper)}")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return len(truth)


def _words(*parts: Array) -> str:
    return " ".join(repr(float(v)) for part in parts for v in part)
