"""Look-ups between the rows of a collection: ``track.at(t, pos)``.

Between two neighbouring rows the value is a polynomial of the argument, or a product of turns by
polynomial angles. Its coefficients are data of the interval that the argument lies in. To the
kernel they are lane inputs, which the runtime fills whenever the argument may have changed: before
each cost and each linearisation. Where the interval changes the value is continuous, so that the
coefficients have no derivative; that of the argument enters by the polynomial.

Where the rows have parameters, the record has the weights of the rows as polynomials, and the rows
are entities that the constraint uses: which ones they are is found by the runtime from the
argument. Polynomials of weights are shared by all columns that are looked up at one argument.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from msgspec import structs

from arael.check import typed
from arael.check.typed import ConstraintSite, QuaternionType, TransformType
from arael.compiler.scalarise import Nodes, width
from arael.diagnostics.records import AraelError, Diagnostic
from arael.manifolds import linear, quaternion
from arael.runtime.layout import LookUp
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS


@dataclass(frozen=True)  # no tuple, which would equal a `StateInput` of the same numbers
class RecordInput:
    """A scalar of the record of a look-up; -1 is the number of its interval."""

    look_up: int
    component: int


class LookUps:
    """The look-ups of one constraint.

    Attributes
    ----------
    found : each with the lanes that follow one another from `first` on, counted from 0
    arguments : their arguments, nodes
    """

    def __init__(self, graph: Graph, site: ConstraintSite) -> None:
        self.graph = graph
        self.site = site
        self.found: list[LookUp] = []
        self.arguments: Nodes = []
        self._known: dict[tuple[object, ...], int] = {}

    @property
    def lanes(self) -> Nodes:
        """All lane inputs, in order."""
        return [
            self.graph.input(RecordInput(number, k))
            for number, one in enumerate(self.found)
            for k in range(-1, one.record)
        ]

    def placed(self, first: int) -> tuple[LookUp, ...]:
        """The look-ups with lanes counted from `first` on."""
        return tuple(structs.replace(one, first=first + one.first) for one in self.found)

    def of(self, e: typed.LookUp, argument: int, rows: Sequence[Nodes]) -> Nodes:
        """Scalars of a look-up, from the node of its argument and the scalars of its rows."""
        number = self._number(e, argument)
        if rows:
            return _Weighted(self.graph, number, self.found[number], argument).of(e, rows)
        return _Formula(self.graph, number, self.found[number], argument).nodes(e.derivative)

    def _number(self, e: typed.LookUp, argument: int) -> int:
        slots = tuple(row.slot for row in e.rows if isinstance(row, typed.Read))
        what = slots or (e.column, e.wrapped)
        key = (e.slot, e.collection, what, e.order, e.spline, e.clamp, argument)
        if key not in self._known:
            value = "wrapped" if e.wrapped else "vector"
            if isinstance(e.value, QuaternionType):
                value = "rotation"
            elif isinstance(e.value, TransformType):
                value = "transform"
            if slots:
                value = "weights"
            first = sum(1 + one.record for one in self.found)
            self._known[key] = len(self.found)
            self.arguments.append(argument)
            self.found.append(
                LookUp(
                    slot=e.slot,
                    collection=e.collection,
                    key=e.key,
                    column="" if slots else e.column,
                    order=e.order,
                    spline=e.spline,
                    value=value,  # type: ignore[arg-type]
                    width=e.order if slots else width(e.value),
                    clamp=e.clamp,
                    first=first,
                    where=str(e.span),
                    text=" ".join(e.span.text.split())[:200],
                    rows=slots,
                )
            )
        return self._known[key]

    def require_none(self, where: str) -> None:
        """Raise E0622 if there are look-ups, which `where` cannot have."""
        if self.found:
            one = self.found[0]
            raise AraelError(
                Diagnostic(
                    "E0622",
                    f"a look-up stands in {where}",
                    origin=one.where,
                    notes=(f"`{one.text}` is evaluated while the model is solved",),
                    help=("let the data have the value as a column of its own",),
                )
            )


class _Formula:
    """The value of a look-up as a formula of its argument and the record of its interval."""

    def __init__(self, graph: Graph, number: int, one: LookUp, argument: int) -> None:
        self.graph = g = graph
        self.one = one
        self.at = 0
        self.number = number
        start = self._take(1)[0]
        self.inside: int | None = None
        if one.clamp:
            low, high = self._take(2)
            self.inside = g.op("and", g.op("le", low, argument), g.op("le", argument, high))
            argument = SCALARS["clamp"](g, argument, low, high)
        self.s = g.op("sub", argument, start)

    def nodes(self, derivative: int) -> Nodes:
        """Its scalars, or those of its derivative."""
        one = self.one
        found = [self._at(self._take(one.order), derivative) for _ in range(one.moved)]
        if one.turned:
            q, factors = self._take(4), []
            for _ in range(one.degree):
                axis = self._take(3)
                angle, speed = self.s, self.graph.const(1.0)
                if one.order > 2:
                    coefficients = self._take(one.order)
                    angle, speed = self._at(coefficients, 0), self._at(coefficients, 1)
                factors.append((axis, angle, speed))
            found += self._turn(q, factors, derivative)
        return self._within(found, derivative)

    def _within(self, nodes: Nodes, derivative: int) -> Nodes:
        """Nothing changes where an argument is clamped."""
        if not derivative or self.inside is None:
            return nodes
        zero = self.graph.const(0.0)
        return [self.graph.op("select", self.inside, node, zero) for node in nodes]

    def _turn(self, q: Nodes, factors: Sequence[tuple[Nodes, int, int]], derivative: int) -> Nodes:
        """Cumulative product of turns (Sommer et al. 2020, eq. 15), or its rate in the body.

        The rate follows from factor to factor (eq. 37): it is turned back by each factor, whose own
        rate is added. Of each factor there is the rotation vector, the part of it that is turned
        by, and the rate of that part.
        """
        g = self.graph
        omega = [g.const(0.0)] * 3
        for axis, angle, speed in factors:
            factor = quaternion.exp(g, linear.scale(g, angle, axis))
            q = quaternion.product(g, q, factor)
            back = quaternion.rotate(g, quaternion.conj(g, factor), omega)
            omega = linear.add(g, back, linear.scale(g, speed, axis))
        return list(omega if derivative else q)

    def _take(self, count: int) -> Nodes:
        first, self.at = self.at, self.at + count
        return [self.graph.input(RecordInput(self.number, k)) for k in range(first, first + count)]

    def _polynomial(self, coefficients: Sequence[int]) -> int:
        """By Horner's rule, lowest coefficient first."""
        g, result = self.graph, coefficients[-1]
        for coefficient in reversed(coefficients[:-1]):
            result = g.op("add", coefficient, g.op("mul", self.s, result))
        return result

    def _at(self, coefficients: Sequence[int], derivative: int) -> int:
        """A polynomial, or one of its derivatives."""
        g = self.graph
        for _ in range(derivative):
            coefficients = [g.op("mul", g.const(float(k)), c) for k, c in enumerate(coefficients)][
                1:
            ]
        return self._polynomial(coefficients) if coefficients else g.const(0.0)


class _Weighted(_Formula):
    """The same from the parameters of the rows and the weights in the record."""

    def of(self, e: typed.LookUp, rows: Sequence[Nodes]) -> Nodes:
        """Scalars of a look-up, or of its derivative."""
        order, derivative = self.one.order, e.derivative
        coefficients = [self._take(order) for _ in range(order)]
        if e.derivative == 2 and order == 2:
            return [self.graph.const(0.0)] * len(rows[0])
        weights = [self._at(one, derivative) for one in coefficients]
        if isinstance(e.value, QuaternionType):
            return self._within(self._turned(coefficients, rows, derivative), derivative)
        if isinstance(e.value, TransformType):
            moved = self._mixed(weights, [row[:3] for row in rows])
            return [*moved, *self._turned(coefficients, [row[3:] for row in rows], 0)]
        if not e.wrapped:
            return self._within(self._mixed(weights, rows), derivative)
        # From row to row the short way.
        g, found = self.graph, [] if derivative else [rows[0][0]]
        for j, share in enumerate(self._from_each_on(weights)[1:]):
            step = SCALARS["rad_diff"](g, rows[j + 1][0], rows[j][0])
            found.append(g.op("mul", share, step))
        return self._within([self._sum(found)], derivative)

    def _mixed(self, weights: Nodes, rows: Sequence[Nodes]) -> Nodes:
        g = self.graph
        return [
            self._sum([g.op("mul", w, x) for w, x in zip(weights, column, strict=True)])
            for column in zip(*rows, strict=True)
        ]

    def _turned(
        self, coefficients: Sequence[Nodes], rows: Sequence[Nodes], derivative: int
    ) -> Nodes:
        parts = self._from_each_on([self._at(one, 0) for one in coefficients])
        speeds = self._from_each_on([self._at(one, 1) for one in coefficients])
        g, factors = self.graph, []
        for j in range(1, len(rows)):
            step = quaternion.product(g, quaternion.conj(g, rows[j - 1]), rows[j])
            factors.append((list(quaternion.log(g, step)), parts[j], speeds[j]))
        return self._turn(list(rows[0]), factors, derivative)

    def _from_each_on(self, weights: Nodes) -> Nodes:
        """Sums of the weights from each on; the first is 1, as all are together."""
        found = [weights[-1]]
        for weight in reversed(weights[:-1]):
            found.insert(0, self.graph.op("add", weight, found[0]))
        return found

    def _sum(self, nodes: Nodes) -> int:
        total = nodes[0]
        for node in nodes[1:]:
            total = self.graph.op("add", total, node)
        return total
