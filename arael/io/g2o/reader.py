"""g2o reader: poses, edges, anchors, and the poses that fix the gauge."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.g2o.kinds import Kind, kind_of
from arael.io.g2o.parse import Graph, parse
from arael.io.report import Report
from arael.runtime.assembly.components import graph_components
from arael.runtime.store import Store, rotations
from arael.starts.columns import angles, planar, quaternions
from arael.starts.graph import Anchors, PoseGraph, Poses
from arael.starts.tree import tree_poses

Array = NDArray[Any]


def read(store: Store, content: bytes, name: str) -> None:
    """Replace the data of a pose graph model by that of a g2o file.

    Poses keep the order of the file and their ids (where the model has ``skip id: int``). Without
    any vertex the poses are composed along a spanning tree of the edges, in order of their ids.
    Edges keep the upper Cholesky factor ``u`` of their information (``u' u``). FIX fixes poses, a
    prior with unit information becomes an anchor. In each connected component without either, the
    first pose is fixed at its value in the file and marked as ``held`` (if the model has ``skip
    held: bool``), since relative measurements do not determine the position of the component.

    Raises
    ------
    AraelError
        With file and line, several at once: E0716 malformed, E0717 unknown tag, E0719 a vertex
        twice, E0720 an unknown vertex, E0723 information that is not positive definite, E0705 not
        finite, E0721 a zero quaternion; E0722 model and file have different structure.
    """
    kind = kind_of(store, name)
    report = Report(name)
    graph = parse(content, name, kind, report)
    fresh = store.fresh()
    report.run(lambda: _fill(fresh, graph, kind))
    store.adopt(fresh)


def _fill(store: Store, graph: Graph, kind: Kind) -> None:
    report = graph.text.report
    row_of = _rows_by_id(graph)
    ends = _ends(graph, row_of)
    fixed = _fixed(graph, row_of)
    anchored = _anchored(graph, row_of)
    for records in (graph.vertices, graph.edges, graph.priors):
        _refuse_zero_quaternions(graph, records.numbers, records.lines, kind)
    factors = _factors(graph, kind)
    if report.found:
        return
    measured = graph.edges.numbers[:, : kind.size] if ends else np.empty((0, kind.size))
    rows = np.array(ends, np.int64).reshape(-1, 2)
    if graph.vertices.lines:
        start = graph.vertices.numbers
    else:
        start = _start(graph, kind, len(row_of), rows, factors, anchored)
    held = _held(len(row_of), rows, fixed, anchored)
    _put(store, kind, list(row_of), start, rows, measured, factors, fixed, held)
    if "anchors" in store.tables:
        fields = kind.fields(graph.priors.numbers[:, : kind.size].reshape(-1, kind.size))
        store.tables["anchors"].extend(len(anchored), pose=np.array(anchored, np.int64), **fields)


def _held(
    count: int, ends: NDArray[np.int64], fixed: NDArray[np.bool_], anchored: list[int]
) -> NDArray[np.bool_]:
    """The first pose of each connected component in which nothing is fixed or anchored."""
    component = graph_components(count, ends[:, 0], ends[:, 1])
    holding = np.concatenate((np.flatnonzero(fixed), np.array(anchored, np.int64)))
    loose = np.ones(count, np.bool_)
    loose[component[holding]] = False
    held: NDArray[np.bool_] = loose & (component == np.arange(count))
    return held


def _start(
    graph: Graph,
    kind: Kind,
    count: int,
    ends: NDArray[np.int64],
    factors: Array,
    anchored: list[int],
) -> Array:
    """Poses (count, size) in the form of a file, composed along the edges.

    Each connected component starts at the pose of its first prior, or at the origin.
    """
    d = 2 if kind.size == 3 else 3
    none, units = np.zeros(count, np.bool_), np.ones(len(anchored))
    anchors = Anchors(
        np.array(anchored, np.int64), _transforms(kind, graph.priors.numbers), units, units
    )
    found = tree_poses(
        PoseGraph(
            Poses.identity(count, d),
            ends[:, 0],
            ends[:, 1],
            _transforms(kind, graph.edges.numbers),
            factors.transpose(0, 2, 1) @ factors,
            none,
            none,
            anchors,
        )
    )
    turned = (angles if d == 2 else quaternions)(found.rotation)
    return kind.numbers({"t": found.position, kind.rotation_field: turned})


def _transforms(kind: Kind, numbers: Array) -> Poses:
    """Poses as transforms from lines of numbers that begin with them."""
    columns = kind.fields(numbers[:, : kind.size].reshape(-1, kind.size))
    if kind.rotation_field == "th":
        return Poses(planar(columns["th"]), columns["t"])
    return Poses(rotations.matrix_from_quaternion(columns["q"]), columns["t"])


def _rows_by_id(graph: Graph) -> dict[int, int]:
    """Id -> row: vertices in order of the file; without any, the ids of the edges in order."""
    if not graph.vertices.lines:
        ids = sorted({i for pair in graph.edges.ids for i in pair})
        return {id: row for row, id in enumerate(ids)}
    rows: dict[int, int] = {}
    for (id,), line in zip(graph.vertices.ids, graph.vertices.lines, strict=True):
        if id in rows:
            before = graph.vertices.lines[rows[id]] + 1
            graph.text.add(
                "E0719",
                f"vertex {id} is given twice",
                line,
                notes=(f"first given in line {before}",),
            )
        else:
            rows[id] = len(rows)
    return rows


def _ends(graph: Graph, row_of: dict[int, int]) -> list[tuple[int, int]]:
    ends = []
    for (a, b), line in zip(graph.edges.ids, graph.edges.lines, strict=True):
        for word, id in enumerate((a, b), 1):
            if id not in row_of:
                graph.text.add("E0720", f"vertex {id} is not in the file", line, word)
        if a == b:
            graph.text.add("E0716", f"the edge leads from vertex {a} to itself", line)
        ends.append((row_of.get(a, 0), row_of.get(b, 0)))
    return ends


def _fixed(graph: Graph, row_of: dict[int, int]) -> NDArray[np.bool_]:
    fixed = np.zeros(len(row_of), np.bool_)
    for id, line in graph.fixed:
        if id in row_of:
            fixed[row_of[id]] = True
        else:
            graph.text.add("E0720", f"vertex {id} is not in the file", line)
    return fixed


def _anchored(graph: Graph, row_of: dict[int, int]) -> list[int]:
    """Rows of the poses with priors."""
    for ids, line in zip(graph.priors.ids, graph.priors.lines, strict=True):
        if ids[0] not in row_of:
            graph.text.add("E0720", f"vertex {ids[0]} is not in the file", line, 1)
    return [row_of.get(ids[0], 0) for ids in graph.priors.ids]


def _refuse_zero_quaternions(graph: Graph, numbers: Array, lines: list[int], kind: Kind) -> None:
    if kind.size != 7 or not lines:
        return
    norms = np.linalg.norm(numbers[:, 3:7], axis=1)
    for i in np.flatnonzero(norms < 1e-6).tolist():
        graph.text.add("E0721", "the quaternion is zero", lines[i])


def _factors(graph: Graph, kind: Kind) -> Array:
    """Upper Cholesky factors (m, n, n) of the information of every edge."""
    n, edges = kind.tangent, graph.edges
    if not edges.lines:
        return np.empty((0, n, n))
    information = np.zeros((len(edges.lines), n, n))
    rows, columns = np.triu_indices(n)
    triangle = edges.numbers[:, kind.size :]
    information[:, rows, columns] = triangle
    information[:, columns, rows] = triangle
    try:
        lower = np.linalg.cholesky(information)
    except np.linalg.LinAlgError:
        for i, matrix in enumerate(information):
            try:
                np.linalg.cholesky(matrix)
            except np.linalg.LinAlgError:
                least = float(np.linalg.eigvalsh(matrix)[0])
                graph.text.add(
                    "E0723",
                    "the information matrix is not positive definite",
                    edges.lines[i],
                    notes=(f"its smallest eigenvalue is {least:.3g}",),
                )
        return information
    return np.ascontiguousarray(lower.transpose(0, 2, 1))


def _put(
    store: Store,
    kind: Kind,
    ids: list[int],
    start: Array,
    ends: NDArray[np.int64],
    measured: Array,
    factors: Array,
    fixed: NDArray[np.bool_],
    held: NDArray[np.bool_],
) -> None:
    poses, edges = store.tables["poses"], store.tables["edges"]
    fields = kind.fields(start)
    more: dict[str, Any] = {f"{name}.fixed": fixed | held for name in fields}
    if "id" in poses.data:
        more["id"] = np.array(ids, np.int64)
    if "held" in poses.data:
        more["held"] = held
    poses.extend(len(ids), **fields, **more)
    edges.extend(len(ends), a=ends[:, 0], b=ends[:, 1], **kind.fields(measured), u=factors)
