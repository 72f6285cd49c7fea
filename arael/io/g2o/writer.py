"""g2o writer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io.g2o.kinds import Kind, kind_of
from arael.io.json_writer import refuse_not_finite, shortest
from arael.runtime.store import Store, Table, rotations
from arael.runtime.store.messages import error
from arael.starts.columns import has_landmarks

Array = NDArray[Any]


# TORO's order of the numbers in an upper triangle.
FROM_TRIANGLE = [0, 1, 3, 5, 2, 4]


def dump_toro(store: Store, name: str) -> bytes:
    """Return a graph as text of TORO (VERTEX2, EDGE2; VERTEX3, EDGE3); reading it gives the cost.

    Raises
    ------
    AraelError
        As `dump`; E0722 also for fixed poses, absolute measurements and landmarks, which TORO does
        not have.
    """
    kind = kind_of(store, name)
    if has_landmarks(store) and store.tables["landmarks"].size:
        raise error("E0722", "cannot write TORO: it has no landmarks", name, help="write g2o")
    lines, vertex = [], kind.tag("poses")
    for line in dump(store, name).decode().splitlines():
        tag, *words = line.split(" ")
        if tag not in (vertex, kind.tag("edges")):
            what = "fixed poses" if tag == "FIX" else "absolute measurements of poses"
            raise error("E0722", f"cannot write TORO: it has no {what}", name, help="write g2o")
        ids, numbers = (words[:1], words[1:]) if tag == vertex else (words[:2], words[2:])
        pose, triangle = numbers[: kind.size], numbers[kind.size :]
        if kind.dimension == 3:
            q = np.array([float(pose[i]) for i in (6, 3, 4, 5)])
            euler = rotations.euler_from_matrix(rotations.matrix_from_quaternion(q))
            pose = [*pose[:3], *map(repr, euler.tolist())]
        elif triangle:
            triangle = [triangle[k] for k in FROM_TRIANGLE]
        new = f"{'VERTEX' if tag == vertex else 'EDGE'}{kind.dimension}"
        lines.append(" ".join([new, *ids, *pose, *triangle]))
    return ("\n".join(lines) + "\n").encode()


def dump(store: Store, name: str) -> bytes:
    """Return the graph as g2o text; reading it gives the same cost.

    Fixed vertices are written as FIX, except those that the reader fixed to remove a gauge freedom
    (``held``), which it will fix again. Anchors are written as priors, those of positions alone as
    priors of positions.

    Raises
    ------
    AraelError
        E0722 for data that g2o cannot express: a model of another structure, half a pose fixed;
        E0705 not finite, E0709 a stale ref, E0719 an id twice.
    """
    return "".join(
        f"{line}\n" for line in _Writer(store, kind_of(store, name), _line).lines()
    ).encode()


def check(store: Store, name: str) -> None:
    """Raise what `dump` would, without its text, which takes most of its time."""
    for _ in _Writer(store, kind_of(store, name), lambda tag, ids, numbers: "").lines():
        pass


class _Writer:
    """The lines of a graph, part by part; `line` makes one of a tag, ids and numbers."""

    def __init__(
        self, store: Store, kind: Kind, line: Callable[[str, list[int], Array], str]
    ) -> None:
        self.store = store
        self.line = line
        self.kind = kind
        parts = ["poses", "edges", "anchors"]
        if has_landmarks(store):
            parts += ["landmarks", "observations", "bearings", "landmark_anchors"]
        self.tables = {part: store.tables[part] for part in parts if part in store.tables}
        for table in self.tables.values():
            _refuse_not_finite(table)
        self.ids = _ids(self.tables)
        self.offsets: list[list[float]] = []

    def lines(self) -> Iterator[str]:
        """All lines; the parameters that measurements name come first."""
        kind = self.kind
        measured = [*self._anchors(), *self._of_landmarks()]
        for number, offset in enumerate(self.offsets):
            yield self.line(kind.tag("offsets"), [number], np.array(offset))
        poses = self.tables["poses"]
        yield from self._vertices("poses", kind.tag("poses"), kind.numbers(_columns(poses, kind)))
        if (landmarks := self.tables.get("landmarks")) is not None:
            yield from self._vertices(
                "landmarks", kind.tag("landmarks"), shortest(landmarks.column("t"))
            )
        yield from (f"FIX {id}" for id in self._fixed())
        yield from measured
        edges = self.tables["edges"]
        numbers = kind.numbers(_columns(edges, kind))
        yield from self._measured(
            "edges", kind.tag("edges"), ("poses", "poses"), numbers, edges.column("u")
        )

    def _vertices(self, part: str, tag: str, values: Array) -> Iterator[str]:
        for id, row in zip(self.ids.get(part, []), values, strict=True):
            yield self.line(tag, [id], row)

    def _measured(
        self, part: str, tag: str, targets: tuple[str, str], numbers: Array, factors: Array
    ) -> Iterator[str]:
        """Lines of measurements between two vertices."""
        table = self.tables[part]
        ends = [
            [self.ids[target][row] for row in table.target_rows(end).tolist()]
            for end, target in zip("ab", targets, strict=True)
        ]
        named = (
            [self._offset(self.kind.identity)]
            if self.kind.forms[tag].offset and len(numbers)
            else []
        )
        information = _squared(factors)
        if part == "edges":
            information = self.kind.in_model(part, numbers, information, back=True)
        rows = np.column_stack([numbers, _triangles(information)])
        for a, b, row in zip(*ends, rows, strict=True):
            yield self.line(tag, [a, b, *named], row)

    def _of_landmarks(self) -> Iterator[str]:
        kind, tables = self.kind, self.tables
        between = ("poses", "landmarks")
        if (table := tables.get("landmark_anchors")) is not None:
            rows = table.target_rows("landmark").tolist()
            numbers = np.column_stack(
                [shortest(table.column("t")), _triangles(_squared(table.column("u")))]
            )
            for row, line in zip(rows, numbers, strict=True):
                yield self.line(kind.tag("landmark_anchors"), [self.ids["landmarks"][row]], line)
        if (table := tables.get("observations")) is not None:
            yield from self._measured(
                "observations", kind.tag("observations"), between, shortest(table.column("t")),
                table.column("u"),
            )  # fmt: skip
        if (table := tables.get("bearings")) is not None:
            yield from self._measured(
                "bearings", kind.tag("bearings"), between,
                shortest(table.column("th"))[:, None], table.column("isigma")[:, None, None],
            )  # fmt: skip

    def _anchors(self) -> Iterator[str]:
        kind, anchors = self.kind, self.tables.get("anchors")
        if anchors is None or not anchors.size:
            return
        d, n = kind.dimension, kind.tangent
        scale = np.ones((anchors.size, n))
        for path, part in (("t_isigma", slice(d)), ("th_isigma", slice(d, n))):
            if path in anchors.data:
                scale[:, part] = anchors.column(path)[:, None]
        u = anchors.column("u") if "u" in anchors.data else np.tile(np.eye(n), (anchors.size, 1, 1))
        information = _squared(u * scale[:, None, :])
        values = kind.numbers(_columns(anchors, kind))
        information = kind.in_model("anchors", values, information, back=True)
        offsets = np.tile(kind.identity, (anchors.size, 1))
        if "offset_t" in anchors.data:
            offsets = kind.numbers(_columns(anchors, kind, "offset_"))
        rows = anchors.target_rows("pose").tolist()
        for i, row in enumerate(rows):
            # Without information about the rotation, and in the axes of the world.
            alone = not information[i, d:].any() and values[i, d:].tolist() == kind.identity[d:]
            tag, k = kind.tag("anchors", rotations=not alone), d if alone else n
            named = [self.ids["poses"][row]]
            if kind.forms[tag].offset:
                named.append(self._offset(offsets[i].tolist()))
            measured = values[i, :d] if alone else values[i]
            triangle = _triangles(information[i : i + 1, :k, :k])[0]
            yield self.line(tag, named, np.concatenate((measured, triangle)))

    def _offset(self, offset: list[float]) -> int:
        """The number of a sensor offset."""
        if offset not in self.offsets:
            self.offsets.append(offset)
        return self.offsets.index(offset)

    def _fixed(self) -> Iterator[int]:
        for part in ("poses", "landmarks"):
            if part not in self.tables:
                continue
            table = self.tables[part]
            fixed, held = table.fixed("t"), _held(table)
            if part == "poses":
                half = np.flatnonzero((fixed != table.fixed(self.kind.rotation_field)) & ~held)
                if len(half):
                    what = "g2o fixes whole poses, not parts of one"
                    raise _cannot(what, table.row_name(int(half[0])))
            for row in np.flatnonzero(fixed & ~held).tolist():
                yield self.ids[part][row]


def _squared(factors: Array) -> Array:
    """Information matrices of factors."""
    u = factors.astype(np.float64)
    found: Array = u.transpose(0, 2, 1) @ u
    return found


def _triangles(information: Array) -> Array:
    rows, columns = np.triu_indices(information.shape[1])
    found: Array = information[:, rows, columns]
    return found


def _line(tag: str, ids: list[int], numbers: Array) -> str:
    return " ".join((tag, *map(str, ids), *map(repr, numbers.tolist())))


def _columns(table: Table, kind: Kind, prefix: str = "") -> dict[str, Array]:
    names = ("t", kind.rotation_field)
    return {name: shortest(table.column(f"{prefix}{name}")) for name in names}


def _refuse_not_finite(table: Table) -> None:
    for leaf in table.fields.leaves():
        if leaf.column.kind == "real" and leaf.column.role != "ref":
            refuse_not_finite(table, leaf, table.column(leaf.path), table.present(leaf.path))


def _ids(tables: dict[str, Table]) -> dict[str, list[int]]:
    """Ids of poses and landmarks: those stored in the model, or else numbers in order."""
    found: dict[str, list[int]] = {}
    parts: list[str] = [part for part in ("poses", "landmarks") if part in tables]
    stored = [
        part for part in parts if "id" in tables[part].data and tables[part].column("id").any()
    ]
    for part in stored:
        found[part] = tables[part].column("id").tolist()
    for part in (p for p in parts if p not in stored):
        used = {id for ids in found.values() for id in ids}
        size = tables[part].size
        start = 1 + max(used) if any(id in used for id in range(size)) else 0
        found[part] = list(range(start, start + size))
    whose: dict[int, str] = {}
    for part, ids in found.items():
        for id in ids:
            if id in whose:
                both = f"two {part}" if whose[id] == part else "a pose and a landmark"
                raise error("E0719", f"cannot write: {both} have the id {id}", f"{part}.id")
            whose[id] = part
    return found


def _held(table: Table) -> NDArray[np.bool_]:
    """Rows that the reader fixed to remove a gauge freedom."""
    if "held" not in table.data:
        return np.zeros(table.size, np.bool_)
    held: NDArray[np.bool_] = table.column("held").astype(np.bool_)
    return held


def _cannot(message: str, origin: str) -> AraelError:
    return error("E0722", f"cannot write g2o: {message}", origin, help="write JSON or NPZ instead")
