"""Look-ups of data between the rows of a collection: ``track.at(t, pos)``.

Between two neighbouring rows the value is a polynomial of the argument, or a product of turns by
polynomial angles. Its coefficients are data of the interval that the argument lies in. To the
kernel they are lane inputs, which the runtime fills whenever the argument may have changed: before
each cost and each linearisation. Where the interval changes the value is continuous, so that the
coefficients have no derivative; that of the argument enters by the polynomial.
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

    def of(self, e: typed.LookUp, argument: int) -> Nodes:
        """Scalars of a look-up, from the node of its argument."""
        number = self._number(e, argument)
        return _Formula(self.graph, number, self.found[number], argument).nodes(e.rate)

    def _number(self, e: typed.LookUp, argument: int) -> int:
        key = (e.slot, e.collection, e.column, e.order, e.spline, e.wrapped, e.clamp, argument)
        if key not in self._known:
            value = "wrapped" if e.wrapped else "vector"
            if isinstance(e.value, QuaternionType):
                value = "rotation"
            elif isinstance(e.value, TransformType):
                value = "transform"
            first = sum(1 + one.record for one in self.found)
            self._known[key] = len(self.found)
            self.arguments.append(argument)
            self.found.append(
                LookUp(
                    slot=e.slot,
                    collection=e.collection,
                    key=e.key,
                    column=e.column,
                    order=e.order,
                    spline=e.spline,
                    value=value,  # type: ignore[arg-type]
                    width=width(e.value),
                    clamp=e.clamp,
                    first=first,
                    where=str(e.span),
                    text=" ".join(e.span.text.split())[:200],
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

    def nodes(self, rate: bool) -> Nodes:
        """Its scalars, or those of its derivative."""
        one, found = self.one, []
        for _ in range(one.moved):
            coefficients = self._take(one.order)
            found.append(self._slope(coefficients) if rate else self._polynomial(coefficients))
        if one.turned:
            found += self._turn(rate)
        if not rate or self.inside is None:
            return found
        zero = self.graph.const(0.0)
        return [self.graph.op("select", self.inside, node, zero) for node in found]

    def _turn(self, rate: bool) -> Nodes:
        """Cumulative product of turns (Sommer et al. 2020, eq. 15), or its rate in the body.

        The rate follows from factor to factor (eq. 37): it is turned back by each factor, whose own
        rate is added.
        """
        g, one = self.graph, self.one
        q = self._take(4)
        omega = [g.const(0.0)] * 3
        for _ in range(one.degree):
            axis = self._take(3)
            if one.order == 2:
                angle, speed = self.s, g.const(1.0)
            else:
                coefficients = self._take(one.order)
                angle, speed = self._polynomial(coefficients), self._slope(coefficients)
            factor = quaternion.exp(g, linear.scale(g, angle, axis))
            q = quaternion.product(g, q, factor)
            back = quaternion.rotate(g, quaternion.conj(g, factor), omega)
            omega = linear.add(g, back, linear.scale(g, speed, axis))
        return list(omega if rate else q)

    def _take(self, count: int) -> Nodes:
        first, self.at = self.at, self.at + count
        return [self.graph.input(RecordInput(self.number, k)) for k in range(first, first + count)]

    def _polynomial(self, coefficients: Sequence[int]) -> int:
        """By Horner's rule, lowest coefficient first."""
        g, result = self.graph, coefficients[-1]
        for coefficient in reversed(coefficients[:-1]):
            result = g.op("add", coefficient, g.op("mul", self.s, result))
        return result

    def _slope(self, coefficients: Sequence[int]) -> int:
        g = self.graph
        return self._polynomial(
            [g.op("mul", g.const(float(k)), c) for k, c in enumerate(coefficients)][1:]
        )
