"""g2o writer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io.g2o.kinds import Kind, kind_of
from arael.io.json_writer import refuse_not_finite, shortest
from arael.runtime.store import Store, Table
from arael.runtime.store.messages import error

Array = NDArray[Any]


# TORO's order of the numbers in an upper triangle.
FROM_TRIANGLE = [0, 1, 3, 5, 2, 4]


def dump_toro(store: Store, name: str) -> bytes:
    """Return a planar graph as text of TORO (VERTEX2, EDGE2); reading it gives the same cost.

    Raises
    ------
    AraelError
        As `dump`; E0722 also for spatial graphs, fixed poses and anchors, which TORO does not have.
    """
    kind = kind_of(store, name)
    if kind.name != "SE2":
        raise error("E0722", "cannot write TORO: its graphs here are planar", name)
    lines = []
    for line in dump(store, name).decode().splitlines():
        tag, *words = line.split(" ")
        if tag == kind.vertex:
            lines.append(" ".join(["VERTEX2", *words]))
        elif tag == kind.edge:
            triangle = [words[5:][k] for k in FROM_TRIANGLE]
            lines.append(" ".join(["EDGE2", *words[:5], *triangle]))
        else:
            what = "fixed poses" if tag == "FIX" else "absolute measurements of poses"
            raise error("E0722", f"cannot write TORO: it has no {what}", name, help="write g2o")
    return ("\n".join(lines) + "\n").encode()


def dump(store: Store, name: str) -> bytes:
    """Return the graph as g2o text; reading it gives the same cost.

    Fixed poses are written as FIX, except those that the reader fixed to remove a gauge freedom
    (``held``), which it will fix again. Anchors are written as priors with unit information.

    Raises
    ------
    AraelError
        E0722 for data that g2o cannot express: a model of another structure, half a pose fixed;
        E0705 not finite, E0709 a stale ref, E0719 an id twice.
    """
    kind = kind_of(store, name)
    poses, edges = store.tables["poses"], store.tables["edges"]
    for table in (poses, edges):
        _refuse_not_finite(table)
    ids = _ids(poses)
    fixed = _fixed(poses, kind)
    values = kind.numbers(_columns(poses, kind))
    lines = [_line(kind.vertex, [i], row) for i, row in zip(ids, values, strict=True)]
    lines += [f"FIX {ids[i]}" for i in np.flatnonzero(fixed & ~_held(poses)).tolist()]
    lines += _priors(store, kind, ids)
    lines += _edges(edges, kind, ids)
    return ("\n".join(lines) + "\n").encode()


def _edges(edges: Table, kind: Kind, ids: list[int]) -> Iterator[str]:
    a, b = edges.target_rows("a").tolist(), edges.target_rows("b").tolist()
    factors = edges.column("u").astype(np.float64)
    information = factors.transpose(0, 2, 1) @ factors
    rows, columns = np.triu_indices(kind.tangent)
    numbers = np.column_stack([kind.numbers(_columns(edges, kind)), information[:, rows, columns]])
    for i, row in enumerate(numbers):
        yield _line(kind.edge, [ids[a[i]], ids[b[i]]], row)


def _line(tag: str, ids: list[int], numbers: Array) -> str:
    return " ".join((tag, *map(str, ids), *map(repr, numbers.tolist())))


def _columns(table: Table, kind: Kind) -> dict[str, Array]:
    return {name: shortest(table.column(name)) for name in ("t", kind.rotation_field)}


def _refuse_not_finite(table: Table) -> None:
    for leaf in table.fields.leaves():
        if leaf.column.kind == "real" and leaf.column.role != "ref":
            refuse_not_finite(table, leaf, table.column(leaf.path), table.present(leaf.path))


def _ids(poses: Table) -> list[int]:
    """Ids of the poses: those stored in the model, or else the row numbers."""
    if "id" not in poses.data or not poses.column("id").any():
        return list(range(poses.size))
    ids: list[int] = poses.column("id").tolist()
    if len(set(ids)) < len(ids):
        twice = next(i for i in ids if ids.count(i) > 1)
        raise error("E0719", f"cannot write: two poses have the id {twice}", "poses.id")
    return ids


def _fixed(poses: Table, kind: Kind) -> NDArray[np.bool_]:
    position, rotation = poses.fixed("t"), poses.fixed(kind.rotation_field)
    half = np.flatnonzero(position != rotation)
    if len(half):
        raise _cannot("g2o fixes whole poses, not parts of one", poses.row_name(int(half[0])))
    return position


def _held(poses: Table) -> NDArray[np.bool_]:
    """Poses that the reader fixed to remove a gauge freedom."""
    if "held" not in poses.data:
        return np.zeros(poses.size, np.bool_)
    held: NDArray[np.bool_] = poses.column("held").astype(np.bool_)
    return held


def _priors(store: Store, kind: Kind, ids: list[int]) -> list[str]:
    anchors = store.tables.get("anchors")
    if anchors is None or not anchors.size:
        return []
    _refuse_not_finite(anchors)
    rows = anchors.target_rows("pose").tolist()
    held = kind.numbers(_columns(anchors, kind))
    for name in ("t_isigma", "th_isigma"):
        if name in anchors.data and np.any(anchors.column(name) != 1):
            raise _cannot("priors have unit weight there", f"anchors.{name}")
    unit = kind.unit_information
    lines = [_line(kind.offset, [0], np.array(kind.identity))] if kind.offset else []
    for row, pose in zip(rows, held, strict=True):
        names = [ids[row], 0] if kind.offset else [ids[row]]
        lines.append(_line(kind.prior, names, np.concatenate((pose, unit))))
    return lines


def _cannot(message: str, origin: str) -> AraelError:
    return error("E0722", f"cannot write g2o: {message}", origin, help="write JSON or NPZ instead")
