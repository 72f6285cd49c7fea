"""Residuals of a constraint as errors of rotations and points, from its typed formula."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from arael.certificates.rigid import (
    Atom,
    Error,
    Letter,
    Point,
    Rigid,
    Rotation,
    Term,
    Unreadable,
    Weighted,
    inverse,
    joined,
)
from arael.certificates.values import matrices, planar
from arael.check.typed import (
    Apply,
    Component,
    ConstraintSite,
    Formula,
    Literal_,
    LookUp,
    MatrixType,
    Pack,
    QuaternionType,
    Read,
    ScalarType,
    Select,
    Total,
    TransformType,
    Typed,
    VectorType,
)
from arael.check.walk import postorder
from arael.compiler.scalar_programs import Functions
from arael.compiler.scalarise import RawInput, Scalariser
from arael.runtime.layout import Raw
from arael.runtime.machine.programs import columns_of
from arael.runtime.problem import Problem
from arael.runtime.store.access import gather
from arael.symbolic.graph import Graph

Floats = NDArray[np.float64]
Value: TypeAlias = Any
"""Data (n, ...), `Rotation`, `Rigid`, `Point`, `Error` or `Weighted`."""

_TURNS = ("quaternion", "rotation")


class Reader:
    """Evaluates the formulas of one constraint on the data of its instances.

    Parameters
    ----------
    problem : of the model
    number : of the constraint's group
    site : the constraint with its formulas
    """

    def __init__(
        self, problem: Problem, number: int, site: ConstraintSite, functions: Functions
    ) -> None:
        self.problem, self.number, self.site, self.functions = problem, number, site, functions
        self.n = len(problem.structure.active[number])
        self._done: dict[Typed, Value] = {}
        self._moves: dict[Typed, bool] = {}

    def residual(self) -> Weighted:
        """The residual of the constraint.

        Raises
        ------
        Unreadable
        """
        parts = [self._weighted(self.value(part)) for part in self.site.residual]
        return parts[0] if len(parts) == 1 else self._stacked(parts)

    def value(self, node: Typed) -> Value:
        """Value of a formula; the same for the same formula."""
        if node not in self._done:
            self._done[node] = self._data(node) if not self._varies(node) else self._value(node)
        return self._done[node]

    def _varies(self, node: Typed) -> bool:
        if node not in self._moves:
            self._moves[node] = any(
                isinstance(one, Formula | LookUp | Total)
                or (isinstance(one, Read) and one.version != "data")
                for one in postorder([node])
            )
        return self._moves[node]

    # --- data ---------------------------------------------------------------------------------

    def _data(self, node: Typed) -> Floats:
        """(n, ...) of a formula over data alone: a matrix (n, r, c), a quaternion as a matrix."""
        graph = Graph()
        nodes = Scalariser(graph, _no_uses(), self.functions).nodes(node)
        keys = [key for key in graph.inputs if isinstance(key, RawInput)]
        tape = graph.tape(nodes, inputs=keys)
        group, structure = self.problem.layout.groups[self.number], self.problem.structure
        ways = structure.slot_rows[self.number]
        inputs = [gather(self.problem.store, group.slots, ways, Raw(*key)) for key in keys]
        values = columns_of(tape, inputs, np.float64, self.problem.natives)[0]
        flat = np.broadcast_to(values, (len(nodes), self.n)) if values.shape[1] == 1 else values
        columns = np.ascontiguousarray(flat.T)
        if isinstance(node.type, MatrixType):
            return columns.reshape(self.n, node.type.rows, node.type.columns)
        if isinstance(node.type, VectorType | QuaternionType | TransformType):
            return columns
        return columns[:, 0]

    def _rotation(self, node: Typed) -> tuple[Letter, ...]:
        """A rotation as a word; data of quaternions and matrices too."""
        value = self.value(node)
        if isinstance(value, Rotation):
            return value.word
        if isinstance(value, Rigid):
            return value.rotation
        if isinstance(value, np.ndarray):
            if isinstance(node.type, QuaternionType):
                return (Letter(None, matrices(value)),)
            if isinstance(node.type, MatrixType) and _are_rotations(value):
                return (Letter(None, value),)
            if isinstance(node.type, ScalarType):
                return (Letter(None, planar(value)),)
        raise self._unreadable(node)

    def _point(self, node: Typed) -> Point:
        value = self.value(node)
        if isinstance(value, Point):
            return value
        if isinstance(value, np.ndarray) and value.ndim == 2:
            return Point((Term(1.0, (), None, value),), value.shape[1])
        raise self._unreadable(node)

    def _rigid(self, node: Typed) -> Rigid:
        value = self.value(node)
        if isinstance(value, Rigid):
            return value
        if isinstance(value, np.ndarray) and isinstance(node.type, TransformType):
            position = Point((Term(1.0, (), None, value[:, :3]),), 3)
            return Rigid((Letter(None, matrices(value[:, 3:7])),), position)
        raise self._unreadable(node)

    # --- formulas -----------------------------------------------------------------------------

    def _value(self, node: Typed) -> Value:
        if isinstance(node, Read):
            return self._read(node)
        if isinstance(node, Pack):
            return self._stacked([self._weighted(self.value(item)) for item in node.items])
        if isinstance(node, Component):
            part = self._weighted(self.value(node.of))
            if not isinstance(node.of.type, VectorType):
                raise self._unreadable(node)
            row = np.zeros((self.n, 1, part.rows))
            row[:, 0, node.index] = 1
            return part.times(row)
        if isinstance(node, Apply):
            made = getattr(self, f"_{node.name}_of", None)
            if made is not None:
                return made(node, *node.args)
        raise self._unreadable(node)

    def _read(self, node: Read) -> Value:
        if node.version != "trial":
            raise self._unreadable(node)
        kind, slot, column = node.parameter, node.slot, node.column
        if kind in _TURNS or kind == "angle":
            return Rotation((Letter(Atom(slot, column, "R")),))
        if kind == "transform":
            position = Point((Term(1.0, (), Atom(slot, column, "t")),), 3)
            return Rigid((Letter(Atom(slot, column, "R")),), position)
        if kind == "vec" and isinstance(node.type, VectorType) and node.type.n in (2, 3):
            return Point((Term(1.0, (), Atom(slot, column, "t")),), node.type.n)
        if kind == "euler":
            return _Angles(Atom(slot, column, "R"))
        raise self._unreadable(node)

    def _rotation_matrix_of(self, node: Apply, of: Typed) -> Value:
        value = self.value(of)
        if isinstance(value, _Angles):
            return Rotation((Letter(value.atom),))
        return Rotation(self._rotation(of))

    def _transpose_of(self, node: Apply, of: Typed) -> Value:
        return Rotation(inverse(self._rotation(of)))

    _conj_of = _transpose_of

    def _inverse_of(self, node: Apply, of: Typed) -> Value:
        if isinstance(of.type, TransformType):
            return self._rigid(of).inverted()
        return Rotation(inverse(self._rotation(of)))

    def _transform_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        vector, turn = (a, b) if isinstance(a.type, VectorType) else (b, a)
        return Rigid(self._rotation(turn), self._point(vector))

    def _rotation_of(self, node: Apply, of: Typed) -> Value:
        return Rotation(self._rigid(of).rotation)

    def _translation_of(self, node: Apply, of: Typed) -> Value:
        return self._rigid(of).position

    def _rotate_of(self, node: Apply, turn: Typed, vector: Typed) -> Value:
        return self._point(vector).moved(self._rotation(turn))

    def _neg_of(self, node: Apply, of: Typed) -> Value:
        return self._weighted(self.value(of)).times(np.broadcast_to(-1.0, (self.n, 1, 1)))

    def _add_of(self, node: Apply, a: Typed, b: Typed, sign: float = 1.0) -> Value:
        if isinstance(node.type, VectorType) and all(map(self._is_point, (a, b))):
            return self._point(a).plus(self._point(b), sign)
        if isinstance(node.type, ScalarType) and all(map(self._is_angle, (a, b))):
            other = self._rotation(b)
            return Rotation(joined(self._rotation(a), other if sign > 0 else inverse(other)))
        return self._weighted(self.value(a)).plus(self._weighted(self.value(b)), sign)

    def _sub_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        return self._add_of(node, a, b, -1.0)

    _rad_diff_of = _sub_of
    _rad_sum_of = _add_of

    def _is_point(self, node: Typed) -> bool:
        value = self.value(node)
        return isinstance(value, Point) or (isinstance(value, np.ndarray) and value.ndim == 2)

    def _is_angle(self, node: Typed) -> bool:
        return isinstance(self.value(node), Rotation | np.ndarray)

    def _mul_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        if isinstance(a.type, TransformType):
            if isinstance(b.type, TransformType):
                return self._rigid(a).times(self._rigid(b))
            rigid = self._rigid(a)
            return self._point(b).moved(rigid.rotation).plus(rigid.position, 1.0)
        if isinstance(a.type, QuaternionType) and isinstance(b.type, QuaternionType):
            return Rotation(joined(self._rotation(a), self._rotation(b)))
        if isinstance(a.type, MatrixType) and isinstance(b.type, MatrixType):
            return Rotation(joined(self._rotation(a), self._rotation(b)))
        if isinstance(a.type, MatrixType) and isinstance(self.value(a), Rotation):
            return self._point(b).moved(self._rotation(a))
        if isinstance(a.type, MatrixType) and isinstance(self.value(a), np.ndarray):
            if self._is_point(b) and self._is_turn(a):
                return self._point(b).moved(self._rotation(a))
            return self._weighted(self.value(b)).times(self.value(a))
        return self._scaled(node, a, b)

    def _is_turn(self, node: Typed) -> bool:
        try:
            self._rotation(node)
        except Unreadable:
            return False
        return True

    def _scaled(self, node: Apply, a: Typed, b: Typed) -> Value:
        """A product with a scalar of data, or with a choice between plus and minus of one."""
        for factor, other in ((a, b), (b, a)):
            if isinstance(factor.type, ScalarType):
                number = _either_sign(factor)
                if number is None and not self._varies(factor):
                    number = self.value(factor)
                if number is not None:
                    scale = np.broadcast_to(number, (self.n,))[:, None, None]
                    part = self._weighted(self.value(other))
                    return Weighted(part.errors, tuple(scale * w for w in part.weights))
        raise self._unreadable(node)

    def _div_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        if self._varies(b):
            raise self._unreadable(node)
        part, scale = self._weighted(self.value(a)), 1 / self.value(b)[:, None, None]
        return Weighted(part.errors, tuple(scale * w for w in part.weights))

    def _emul_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        for factor, other in ((a, b), (b, a)):
            if not self._varies(factor):
                value = self.value(factor)
                return self._weighted(self.value(other)).times(
                    value[:, :, None] * np.eye(value.shape[1])
                )
        raise self._unreadable(node)

    def _dot_of(self, node: Apply, a: Typed, b: Typed) -> Value:
        for factor, other in ((a, b), (b, a)):
            if not self._varies(factor):
                return self._weighted(self.value(other)).times(self.value(factor)[:, None, :])
        raise self._unreadable(node)

    def _quat_vec_of(self, node: Apply, of: Typed) -> Value:
        # Half of the vector whose length is 2 sin(angle / 2).
        error = Error(self._rotation(of), True, 3)
        return Weighted((error,), (np.broadcast_to(0.5 * np.eye(3), (self.n, 3, 3)),))

    def _quat_log_of(self, node: Apply, of: Typed) -> Value:
        return Error(self._rotation(of), False, 3)

    _rotation_vector_of = _quat_log_of

    def _tf_log_of(self, node: Apply, of: Typed) -> Value:
        rigid = self._rigid(of)
        turned = Error(rigid.rotation, False, 3)
        return self._stacked([self._weighted(rigid.position), self._weighted(turned)])

    # --- weights ------------------------------------------------------------------------------

    def _weighted(self, value: Value) -> Weighted:
        if isinstance(value, Weighted):
            return value
        if isinstance(value, Point | Error):
            return Weighted.of(value, self.n)
        if isinstance(value, Rotation) and _is_planar(value):
            return Weighted.of(Error(value.word, False, 1), self.n)
        if isinstance(value, np.ndarray):
            flat = value.reshape(self.n, -1)
            return Weighted.of(Point((Term(1.0, (), None, flat),), flat.shape[1]), self.n)
        raise Unreadable("a rotation as a residual")

    def _stacked(self, parts: Sequence[Weighted]) -> Weighted:
        rows = sum(part.rows for part in parts)
        found: Weighted | None = None
        first = 0
        for part in parts:
            place = np.zeros((1, rows, part.rows))
            place[0, first : first + part.rows] = np.eye(part.rows)
            first += part.rows
            moved = part.times(place)
            found = moved if found is None else found.plus(moved, 1.0)
        assert found is not None
        return found

    def _unreadable(self, node: Typed) -> Unreadable:
        text = " ".join(node.span.text.split())
        return Unreadable(f"`{text:.60}`")


class _Angles:
    """Euler angles of a parameter, which only a rotation matrix reads."""

    def __init__(self, atom: Atom) -> None:
        self.atom = atom


def _either_sign(node: Typed) -> float | None:
    """The number of ``if .. then -2 else 2``, whose sign the norm of a residual forgets."""
    if isinstance(node, Select):
        arms = [_literal(node.then), _literal(node.otherwise)]
        if None not in arms and abs(arms[0]) == abs(arms[1]):  # type: ignore[arg-type]
            return abs(arms[0])  # type: ignore[arg-type]
    return None


def _literal(node: Typed) -> float | None:
    if isinstance(node, Literal_):
        return node.value
    if isinstance(node, Apply) and node.name == "neg" and isinstance(node.args[0], Literal_):
        return -node.args[0].value
    return None


def _are_rotations(value: Floats) -> bool:
    rows, columns = value.shape[1:]
    if rows != columns:
        return False
    square = value @ value.transpose(0, 2, 1)
    return bool(np.allclose(square, np.eye(rows), atol=1e-9) and (np.linalg.det(value) > 0).all())


def _is_planar(value: Rotation) -> bool:
    return all(letter.data is None or letter.data.shape[1] == 2 for letter in value.word)


class _no_uses:
    """What data reads of parameters: nothing."""

    def stored(self, slot: int, column: str) -> list[tuple[int, int]]:
        raise Unreadable(f"`{column}`")

    def cached(self, slot: int, column: str, cache: str) -> list[tuple[int, int]]:
        raise Unreadable(f"`{column}`")

    def formula(self, slot: int, column: str) -> list[tuple[int, int]] | None:
        raise Unreadable(f"`{column}`")
