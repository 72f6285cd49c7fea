"""g2o reader: poses, landmarks, measurements, and the vertices that fix the gauge."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.g2o.kinds import PARTS, Kind, kind_of
from arael.io.g2o.parse import Graph, Information, Records, parse
from arael.io.report import Report
from arael.runtime.assembly.components import graph_components
from arael.runtime.store import Store
from arael.starts.columns import angles, graph_of, quaternions
from arael.starts.landmarks import place_landmarks
from arael.starts.tree import tree_poses

Array = NDArray[Any]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Vertices that the lines of each part name: poses and landmarks.
_NAMED = {
    "edges": ("poses", "poses"),
    "anchors": ("poses",),
    "observations": ("poses", "landmarks"),
    "bearings": ("poses", "landmarks"),
    "landmark_anchors": ("landmarks",),
}

# Relative to the largest, eigenvalues of an information matrix below this are rounding.
_ROUNDING = 1e-12


def read(
    store: Store, content: bytes, name: str, information: Information | None = None
) -> list[str]:
    """Replace the data of a pose graph model by that of a g2o file.

    Poses and landmarks keep the order of the file and their ids (where the model has ``skip id:
    int``). Without any vertex the poses are composed along a spanning tree of the edges, in order
    of their ids, and landmarks follow from their observations. Measurements keep the upper Cholesky
    factor ``u`` of their information (``u' u``); `information` of positions and rotations is for
    lines that give none. FIX fixes vertices, a prior becomes an anchor, vertices that EQUIV joins
    become one. In each connected component without any of these, the first pose is fixed at its
    value in the file and marked as ``held`` (if the model has ``skip held: bool``), since relative
    measurements do not determine the position of the component.

    Returns
    -------
    What the model has no place for: the ids of vertices that EQUIV joins to others.

    Raises
    ------
    AraelError
        With file and line, several at once: E0716 malformed, E0717 unknown tag, E0719 a vertex
        twice, E0720 an unknown vertex, E0723 information that is not positive definite, E0705 not
        finite, E0721 a zero quaternion; E0722 model and file have different structure.
    """
    kind = kind_of(store, name)
    report = Report(name)
    graph = parse(content, name, kind, report, information)
    fresh = store.fresh()
    lost: list[str] = []
    report.run(lambda: lost.extend(_fill(fresh, graph, kind)))
    store.adopt(fresh)
    return lost


def _fill(store: Store, graph: Graph, kind: Kind) -> list[str]:
    report = graph.text.report
    _refuse_missing_parts(store, graph, kind)
    joined = _join(graph)
    rows = _Rows(graph)
    ends = {part: _ends(graph, part, rows) for part in _NAMED}
    fixed = _fixed(graph, rows)
    for part in ("poses", "edges", "anchors", "offsets"):
        _refuse_zero_quaternions(graph, graph[part], kind)
    offsets = {part: _offsets(graph, part, kind) for part in ("anchors", "observations")}
    _refuse_unheld(store, graph, kind, offsets["anchors"])
    if not report.found:
        _move_to_pose(graph["observations"], offsets["observations"], kind)
        for part in ("edges", "anchors"):
            measured = graph[part]
            if len(measured):
                information = kind.in_model(part, measured.values, measured.information)
                measured.information = information
    factors = {part: _factors(graph, part) for part in _NAMED}
    if report.found:
        return []

    for part in ("poses", "landmarks"):
        if part in store.tables:
            _put_vertices(store, part, kind, list(rows[part]), graph[part].values, fixed[part])
    for part, records in ((p, graph[p]) for p in _NAMED):
        if part in store.tables and len(records):
            more = offsets[part] if part == "anchors" else None
            _put_measured(store, part, kind, ends[part], records, factors[part], more)
    _hold(store, graph, kind, ends, fixed)
    if not len(graph["poses"]) and len(rows["poses"]):
        _start(store, kind)
    return joined


class _Rows:
    """Rows of the poses and landmarks by id: in order of the file; without vertices, of the ids."""

    def __init__(self, graph: Graph) -> None:
        self.of: dict[str, dict[int, int]] = {"poses": {}, "landmarks": {}}
        seen: dict[int, int] = {}
        for part, rows in self.of.items():
            records = graph[part]
            for (id,), line in zip(records.ids, records.lines, strict=True):
                if id in seen:
                    first, last = sorted((seen[id], line))
                    graph.text.add(
                        "E0719",
                        f"vertex {id} is given twice",
                        last,
                        notes=(f"first given in line {first + 1}",),
                    )
                else:
                    seen[id] = line
                    rows[id] = len(rows)
        if not seen:
            for part, rows in self.of.items():
                ids = {
                    ids[i]
                    for source, named in _NAMED.items()
                    for i, target in enumerate(named)
                    if target == part
                    for ids in graph[source].ids
                }
                rows.update({id: row for row, id in enumerate(sorted(ids))})

    def __getitem__(self, part: str) -> dict[int, int]:
        return self.of[part]


def _refuse_missing_parts(store: Store, graph: Graph, kind: Kind) -> None:
    """E0722 for lines that the model has no collection for."""
    for part in PARTS:
        if len(graph[part]) and part not in store.tables:
            graph.text.add(
                "E0722",
                f"the model has no collection `{part}`",
                graph[part].lines[0],
                help=f"`{kind.model}` has it",
            )


def _join(graph: Graph) -> list[str]:
    """Name joined vertices by one id each, that of the first in the file; what is lost by it."""
    if not graph.equal:
        return []
    named = [ids[0] for part in ("poses", "landmarks") for ids in graph[part].ids]
    order = {
        id: i for i, id in enumerate([*named, *(i for a, b, _ in graph.equal for i in (a, b))])
    }
    for i, id in enumerate(named):
        order[id] = i
    ids = sorted(order, key=order.__getitem__)
    row = {id: i for i, id in enumerate(ids)}
    a, b = (np.array([row[pair[i]] for pair in graph.equal], np.int64) for i in (0, 1))
    into = {id: ids[first] for id, first in zip(ids, graph_components(len(ids), a, b), strict=True)}
    graph.fixed = [(into.get(id, id), line) for id, line in graph.fixed]
    for part, records in graph.parts.items():
        if part in ("poses", "landmarks"):
            records.keep([into.get(id, id) == id for (id,) in records.ids])
        elif part != "offsets":
            before = records.ids
            records.ids = [[into.get(id, id) for id in row] for row in before]
            if part == "edges":  # within one vertex now
                records.keep(
                    [a != b or old[0] == old[1]
                     for (a, b), old in zip(records.ids, before, strict=True)]
                )  # fmt: skip
    gone = sorted(id for id, other in into.items() if id != other)
    shown = ", ".join(map(str, gone[:5])) + (", ..." if len(gone) > 5 else "")
    return [f"the ids of vertices that EQUIV joins to others ({shown})"] if gone else []


def _ends(graph: Graph, part: str, rows: _Rows) -> Ints:
    """Rows (n, k) of the vertices that the lines of a part name."""
    named, records = _NAMED[part], graph[part]
    found = np.zeros((len(records), len(named)), np.int64)
    for i, (ids, line) in enumerate(zip(records.ids, records.lines, strict=True)):
        for word, (id, target) in enumerate(zip(ids, named, strict=True), 1):
            row = rows[target].get(id)
            if row is not None:
                found[i, word - 1] = row
                continue
            other = "landmarks" if target == "poses" else "poses"
            if id in rows[other]:
                message = f"vertex {id} is one of the {other}, expected one of the {target}"
            else:
                message = f"vertex {id} is not in the file"
            graph.text.add("E0720", message, line, word)
        if part == "edges" and ids[0] == ids[1]:
            graph.text.add("E0716", f"the edge leads from vertex {ids[0]} to itself", line)
    return found


def _fixed(graph: Graph, rows: _Rows) -> dict[str, Bools]:
    fixed = {part: np.zeros(len(ids), np.bool_) for part, ids in rows.of.items()}
    for id, line in graph.fixed:
        for part, ids in rows.of.items():
            if id in ids:
                fixed[part][ids[id]] = True
                break
        else:
            graph.text.add("E0720", f"vertex {id} is not in the file", line)
    return fixed


def _refuse_zero_quaternions(graph: Graph, records: Records, kind: Kind) -> None:
    if kind.size != 7 or not len(records):
        return
    norms = np.linalg.norm(records.values[:, 3:7], axis=1)
    for i in np.flatnonzero(norms < 1e-6).tolist():
        graph.text.add("E0721", "the quaternion is zero", records.lines[i])


def _offsets(graph: Graph, part: str, kind: Kind) -> Array:
    """Sensor offsets (n, size) of the lines of a part, in the form of the file.

    A file without any parameter has sensors at the poses, as many are written.
    """
    given, records = graph["offsets"], graph[part]
    by_id = {ids[0]: row for ids, row in zip(given.ids, given.values, strict=True)}
    found = np.tile(kind.identity, (len(records), 1))
    for i, (id, line) in enumerate(zip(records.offsets, records.lines, strict=True)):
        if id in by_id:
            found[i] = by_id[id]
        elif id != -1 and by_id:
            word = 1 + len(records.ids[i])
            graph.text.add("E0720", f"the offset {id} is not in the file", line, word)
    return found


def _move_to_pose(records: Records, offsets: Array, kind: Kind) -> None:
    """Measure landmarks in the axes of the pose in place of those of the sensor.

    Exact: ``P^-1 X^-1 l - z`` is the rotated ``X^-1 l - P z``.
    """
    if not len(records):
        return
    moved = np.flatnonzero((offsets != kind.identity).any(axis=1))
    turn, at = kind.matrices(offsets[moved]), offsets[moved, : kind.dimension]
    records.values[moved] = np.einsum("nij,nj->ni", turn, records.values[moved]) + at
    records.information[moved] = turn @ records.information[moved] @ turn.transpose(0, 2, 1)


def _factors(graph: Graph, part: str) -> Array:
    """Upper Cholesky factors (m, n, n) of the information of every line.

    An anchor may have no information in some directions.
    """
    records = graph[part]
    information = records.information
    if not len(records):
        return information
    try:
        return np.ascontiguousarray(np.linalg.cholesky(information).transpose(0, 2, 1))
    except np.linalg.LinAlgError:
        pass
    found = np.zeros_like(information)
    for i, matrix in enumerate(information):
        try:
            found[i] = np.linalg.cholesky(matrix).T
            continue
        except np.linalg.LinAlgError:
            values, vectors = np.linalg.eigh(matrix)
        least = float(values[0])
        if "anchors" in part and values[-1] > 0 and least >= -_ROUNDING * values[-1]:
            root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
            found[i] = _upper(np.where(np.abs(root) < 1e-15 * root.max(), 0.0, root))
            continue
        graph.text.add(
            "E0723",
            "the information matrix is not positive definite",
            records.lines[i],
            notes=(f"its smallest eigenvalue is {least:.3g}",),
        )
    return found


def _upper(root: Array) -> Array:
    """The upper triangular factor of ``root' root``, with a diagonal that is not negative."""
    upper: Array = np.linalg.qr(root).R
    return upper * np.where(np.diag(upper) < 0, -1.0, 1.0)[:, None]


def _put_vertices(
    store: Store, part: str, kind: Kind, ids: list[int], values: Array, fixed: Bools
) -> None:
    table = store.tables[part]
    if len(values):
        fields = kind.fields(values) if part == "poses" else {"t": values}
    elif part == "poses":
        fields = kind.fields(np.tile(kind.identity, (len(ids), 1)))
    else:
        fields = {"t": np.zeros((len(ids), kind.dimension))}
    more: dict[str, Any] = {f"{name}.fixed": fixed.copy() for name in fields}
    if "id" in table.data:
        more["id"] = np.array(ids, np.int64)
    if "held" in table.data:
        more["held"] = False
    table.extend(len(ids), **fields, **more)


def _put_measured(
    store: Store,
    part: str,
    kind: Kind,
    ends: Ints,
    records: Records,
    factors: Array,
    offsets: Array | None,
) -> None:
    table, values = store.tables[part], records.values
    named = _NAMED[part]
    fields: dict[str, Any] = {"t": values}
    if part in ("edges", "anchors"):
        fields = kind.fields(values)
    elif part == "bearings":
        fields = {"th": values[:, 0]}
    if part == "bearings":
        fields["isigma"] = factors[:, 0, 0]
    elif part != "anchors" or "u" in table.data:
        fields["u"] = factors
    if part == "anchors" and "offset_t" in table.data and offsets is not None:
        placed = kind.fields(offsets)
        fields |= {f"offset_{name}": column for name, column in placed.items()}
    names = ("a", "b") if len(named) == 2 else (named[0].removesuffix("s"),)
    fields |= {name: ends[:, i] for i, name in enumerate(names)}
    table.extend(len(records), **fields)


def _refuse_unheld(store: Store, graph: Graph, kind: Kind, offsets: Array) -> None:
    """E0722 for priors that anchors of another model than the standard ones cannot hold."""
    anchors, table = graph["anchors"], store.tables.get("anchors")
    if table is None:
        return
    for i, line in enumerate(anchors.lines):
        unit = np.array_equal(anchors.information[i], np.eye(kind.tangent))
        if "u" not in table.data and not unit:
            graph.text.add(
                "E0722",
                "the model's anchors have unit weight, this prior has another",
                line,
                help=f"give the struct of `anchors` a factor `u`, as in `{kind.model}`",
            )
        if "offset_t" not in table.data and offsets[i].tolist() != kind.identity:
            graph.text.add(
                "E0722",
                "the model's anchors have no sensor offset, this prior has one",
                line,
                help=f"give the struct of `anchors` `offset_t` and `offset_q` as in `{kind.model}`",
            )


def _hold(
    store: Store, graph: Graph, kind: Kind, ends: dict[str, Ints], fixed: dict[str, Bools]
) -> None:
    """Fix what no line determines: in each component, at its first pose.

    One known position leaves a component free to turn about it, two leave it free in space about
    their line, which is left to the solver: fixing a rotation would take three freedoms for one.
    """
    poses, landmarks = len(fixed["poses"]), len(fixed["landmarks"])
    count = poses + landmarks
    joins = [ends["edges"]]
    joins += [ends[part] + np.array([0, poses]) for part in ("observations", "bearings")]
    pairs = np.concatenate(joins)
    component = graph_components(count, pairs[:, 0], pairs[:, 1])

    d, anchored = kind.dimension, ends["anchors"][:, 0]
    known = np.einsum(
        "nii->ni", graph["anchors"].information.reshape(-1, kind.tangent, kind.tangent)
    )
    located = np.zeros(count, np.bool_)
    located[:poses], located[poses:] = fixed["poses"], fixed["landmarks"]
    located[anchored[(known[:, :d] > 0).any(axis=1)]] = True
    located[poses + ends["landmark_anchors"][:, 0]] = True
    positions = np.bincount(component[located], minlength=count)
    turned = np.zeros(count, np.bool_)
    turned[component[:poses][fixed["poses"]]] = True
    turned[component[anchored[(known[:, d:] > 0).any(axis=1)]]] = True

    first = component == np.arange(count)
    hold_position = first & (positions == 0)
    hold_rotation = first & ~turned & (positions <= 1)
    for part, start, size in (("poses", 0, poses), ("landmarks", poses, landmarks)):
        table = store.tables.get(part)
        if table is None:
            continue
        here = slice(start, start + size)
        held = hold_position[here].copy()
        table.fixed("t")[hold_position[here]] = True
        if part == "poses":
            table.fixed(kind.rotation_field)[hold_rotation[here]] = True
            held |= hold_rotation[here]
        if "held" in table.data:
            table.column("held")[:] = held


def _start(store: Store, kind: Kind) -> None:
    """Compose poses along the edges; then place landmarks.

    Each connected component starts at the pose of its first prior, or at the origin.
    """
    graph, table = graph_of(store), store.tables["poses"]
    free = np.zeros(table.size, np.bool_)
    found = tree_poses(replace(graph, fixed_position=free, fixed_rotation=free))
    turned = (angles if kind.dimension == 2 else quaternions)(found.rotation)
    table.column("t")[...] = found.position
    table.column(kind.rotation_field)[...] = turned
    place_landmarks(store)
