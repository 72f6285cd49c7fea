"""Curves at a distance from a chain of lines and arcs: their joints, corners and limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, remainder
from typing import TypeAlias

from arael.sketch.geometry.circular import Arc, Circle
from arael.sketch.geometry.contacts import intersections
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import (
    TURN,
    Point,
    add,
    between,
    cross,
    direction_angle,
    dot,
    gap,
    left,
    subtract,
    times,
)

Piece: TypeAlias = Line | Arc | Circle

#: Sine of the angle below which two curves that follow each other are tangent.
SMOOTH_WITHIN = 1e-6
_TINY = 1e-9
_HALVINGS = 60


class OffsetError(ValueError):
    """An offset that does not exist.

    Attributes
    ----------
    number : of the curve of the chain where it fails
    reason : in words
    """

    def __init__(self, number: int, reason: str) -> None:
        super().__init__(reason)
        self.number = number
        self.reason = reason


@dataclass(frozen=True, slots=True)
class Element:
    """A curve of the result.

    Attributes
    ----------
    source : number of the curve it is beside, or of the one before the corner it goes round
    curve : in the direction of the chain
    corner : whether it is the arc round a corner
    """

    source: int
    curve: Piece
    corner: bool = False


@dataclass(frozen=True, slots=True)
class OffsetSide:
    """What is on one side of a chain.

    Attributes
    ----------
    elements : the curves, one after the other
    joints : how each is joined to the next one: ``smooth`` beside a tangent joint of the sources,
        ``round`` at an end of an arc round a corner, ``sharp`` elsewhere; of a closed chain the
        last one joins the last curve to the first
    vanished : numbers of arcs whose radius is smaller than the distance
    """

    elements: tuple[Element, ...]
    joints: tuple[str, ...]
    vanished: tuple[int, ...]

    @property
    def shape(self) -> tuple[str, ...]:
        """Which curves there are and how they are joined, without sizes."""
        kinds = [f"{'r' if one.corner else 's'}{one.source}" for one in self.elements]
        return (*kinds, *self.joints)


def offset_side(
    curves: Sequence[Piece], closed: bool, shift: float, *, rounded: bool = False
) -> OffsetSide:
    """The curves at a distance to one side of a chain.

    Parameters
    ----------
    curves : one after the other, each in the direction of the chain
    closed : whether the last ends where the first begins
    shift : distance, positive to the left
    rounded : corners that the result goes round are arcs about the corner, else the curves are
        prolonged until they meet

    Raises
    ------
    OffsetError
        where a curve has no length left or is turned round, neighbours do not meet, the chain
        doubles back, or the result crosses itself
    """
    size = max(max(one.bounds().size for one in curves), abs(shift))
    found = _Builder(curves, closed, shift, rounded, _TINY * size).side()
    _require_simple(found, closed, 1e-6 * size)
    return found


def largest(curves: Sequence[Piece], closed: bool, shift: float, *, rounded: bool = False) -> float:
    """The distance up to which a chain has an offset, below one for which it has none.

    By bisection; 0 if there is none however near.
    """
    low, high = 0.0, abs(shift)
    sign = 1.0 if shift > 0.0 else -1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        try:
            offset_side(curves, closed, sign * middle, rounded=rounded)
        except OffsetError:
            high = middle
        else:
            low = middle
    return low


def _beside(curve: Piece, shift: float, tiny: float) -> Piece | None:
    """A curve moved to its left; None if nothing is left of it."""
    if isinstance(curve, Line):
        by = times(left(curve.tangent_at(0.0)), shift)
        return Line(add(curve.p1, by), add(curve.p2, by))
    if isinstance(curve, Circle):
        radius = curve.radius - shift
        return Circle(curve.center, radius) if radius > tiny else None
    radius = curve.radius - shift * (1.0 if curve.sweep > 0.0 else -1.0)
    return Arc(curve.center, radius, curve.angle, curve.sweep) if radius > tiny else None


class _Builder:
    def __init__(
        self, curves: Sequence[Piece], closed: bool, shift: float, rounded: bool, tiny: float
    ) -> None:
        self.curves, self.closed = curves, closed
        self.shift, self.rounded, self.tiny = shift, rounded, tiny
        moved = [_beside(one, shift, tiny) for one in curves]
        self.moved = {i: one for i, one in enumerate(moved) if one is not None}
        self.vanished = tuple(i for i, one in enumerate(moved) if one is None)
        self.starts: dict[int, Point] = {}
        self.ends: dict[int, Point] = {}

    def side(self) -> OffsetSide:
        kept = list(self.moved)
        if not kept:
            raise OffsetError(0, "nothing is left of it: every arc is smaller than the distance")
        first = self.moved[kept[0]]
        if isinstance(first, Circle):
            return OffsetSide((Element(0, first),), (), ())
        if self.closed and len(kept) == 1 and len(self.curves) > 1:
            raise OffsetError(kept[0], "only one curve of the closed chain is left")
        elements: list[Element] = []
        joints: list[str] = []
        last = len(kept) - 1
        corners: list[tuple[str, Arc | None]] = []
        for k, a in enumerate(kept):
            if k < last or self.closed:
                corners.append(self._joint(a, kept[(k + 1) % len(kept)]))
        for k, a in enumerate(kept):
            elements.append(Element(a, self._trimmed(a)))
            if k < len(corners):
                kind, arc = corners[k]
                joints.append(kind)
                if arc is not None:
                    elements.append(Element(a, arc, corner=True))
                    joints.append("round")
        return OffsetSide(tuple(elements), tuple(joints), self.vanished)

    def _joint(self, a: int, b: int) -> tuple[str, Arc | None]:
        """Where the curves beside `a` and `b` are joined, and the arc between them."""
        before, after = self.moved[a], self.moved[b]
        if b == (a + 1) % len(self.curves):
            one, two = self.curves[a].tangent_at(1.0), self.curves[b].tangent_at(0.0)
            turn = cross(one, two)
            if abs(turn) < SMOOTH_WITHIN:
                if dot(one, two) < 0.0:
                    raise OffsetError(b, "the chain doubles back here")
                self.ends[a] = self.starts[b] = before.end
                return "smooth", None
            if self.rounded and turn * self.shift < 0.0:
                self.ends[a], self.starts[b] = before.end, after.start
                corner = self.curves[a].end
                angle = direction_angle(subtract(before.end, corner))
                sweep = direction_angle(two) - direction_angle(one)
                arc = Arc(corner, abs(self.shift), angle, remainder(sweep, TURN))
                return "round", arc
        near = between(before.end, after.start, 0.5)
        meetings = intersections(before, after, extend_a=True, extend_b=True)
        if not meetings:
            raise OffsetError(b, "its offset does not meet that of the curve before it")
        point = min((one.point for one in meetings), key=lambda p: gap(p, near))
        self.ends[a] = self.starts[b] = point
        return "sharp", None

    def _trimmed(self, i: int) -> Line | Arc:
        """The curve beside a source, between its joints."""
        curve = self.moved[i]
        start, end = self.starts.get(i, curve.start), self.ends.get(i, curve.end)
        if isinstance(curve, Line):
            if dot(subtract(end, start), curve.tangent_at(0.0)) <= self.tiny:
                raise OffsetError(i, "no length is left of its offset")
            return Line(start, end)
        assert isinstance(curve, Arc)
        angle = direction_angle(subtract(start, curve.center))
        first = remainder(angle - curve.angle, TURN)
        last = direction_angle(subtract(end, curve.center)) - curve.angle - curve.sweep
        sweep = curve.sweep - first + remainder(last, TURN)
        if sweep * curve.sweep <= 0.0 or abs(sweep) * curve.radius <= self.tiny:
            raise OffsetError(i, "no length is left of its offset")
        if abs(sweep) >= 2.0 * pi:
            raise OffsetError(i, "its offset is more than a full turn")
        return Arc(curve.center, curve.radius, angle, sweep)


def _require_simple(side: OffsetSide, closed: bool, near: float) -> None:
    """OffsetError if curves of the result cross away from their joints."""
    elements = side.elements
    boxes = [one.curve.bounds() for one in elements]
    count = len(elements)
    for i, one in enumerate(elements):
        for j in range(i + 1, count):
            if boxes[i].apart(boxes[j]):
                continue
            joints: list[Point] = []
            if j == i + 1:
                joints.append(one.curve.end)
            if closed and i == 0 and j == count - 1:
                joints.append(one.curve.start)
            follows = [side.joints[i if j == i + 1 else j]] if joints else []
            other = elements[j]
            both_lines = isinstance(one.curve, Line) and isinstance(other.curve, Line)
            if joints and (both_lines or (count > 2 and follows[0] != "sharp")):
                continue
            for contact in intersections(one.curve, other.curve):
                if all(gap(contact.point, joint) > near for joint in joints):
                    raise OffsetError(other.source, "its offset crosses another one")
