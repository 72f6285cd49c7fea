"""Classes of points that are one place: what `coincident` and `concentric` say, without equations.

Ties form a graph on points. Each class of connected points is one unknown place. Ties are added
and removed in place; only the classes they touch are worked on. Of the ties of a class those that
close a cycle, taken in the order of their keys, are spare: redundant.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

#: Orders ties: the number in a constraint's name, then the name.
Key = tuple[int, str]


def key_of(name: str) -> Key:
    """Where a constraint stands in the order in which constraints were made."""
    digits = name[len(name.rstrip("0123456789")) :]
    return (int(digits) if digits else -1, name)


@dataclass(slots=True)
class Place:
    """Points that coincide.

    Attributes
    ----------
    members : offsets of the points in ``document.values``
    ties : by name, the two points of each
    spare : names of ties that close nothing new
    source : the member whose numbers the place starts from
    last : key of the latest tie
    """

    members: set[int]
    ties: dict[str, tuple[int, int]] = field(default_factory=dict)
    spare: set[str] = field(default_factory=set)
    source: int = -1
    last: Key = (-2, "")


class Places:
    """All classes of two and more points, and single points that carry a tie to themselves.

    Attributes
    ----------
    touched : points whose class changed since it was last emptied by the caller
    spare : names of all ties that close nothing new
    """

    def __init__(self) -> None:
        self._of: dict[int, Place] = {}
        self._at: dict[str, int] = {}
        self.touched: set[int] = set()
        self.spare: set[str] = set()

    def of(self, point: int) -> Place | None:
        """The class of a point, None while it is alone."""
        return self._of.get(point)

    def members(self, point: int) -> Iterable[int]:
        """Points at the place of a point, itself among them."""
        found = self._of.get(point)
        return found.members if found else (point,)

    def is_spare(self, name: str) -> bool:
        """Whether a tie closes nothing new."""
        at = self._at.get(name)
        return at is not None and name in self._of[at].spare

    def joining(self, name: str) -> tuple[str, ...]:
        """Ties by which the two points of a tie are one place without it; the fewest."""
        a, b = self._of[self._at[name]].ties[name]
        return self.between(a, b, without=name)

    def between(self, a: int, b: int, without: str = "") -> tuple[str, ...]:
        """Ties by which two points are one place, the fewest."""
        place = self._of.get(a)
        if place is None:
            return ()
        beside: dict[int, list[tuple[str, int]]] = {}
        for one, (p, q) in place.ties.items():
            if one != without:
                beside.setdefault(p, []).append((one, q))
                beside.setdefault(q, []).append((one, p))
        came: dict[int, tuple[str, int]] = {a: ("", a)}
        front = [a]
        for point in front:
            for one, q in beside.get(point, ()):
                if q not in came:
                    came[q] = (one, point)
                    front.append(q)
        if b not in came:
            return ()
        found: list[str] = []
        while b != a:
            one, b = came[b]
            found.append(one)
        return tuple(reversed(found))

    def tie(self, name: str, a: int, b: int, weights: tuple[int, int] = (0, 0)) -> None:
        """Two points become one place.

        Parameters
        ----------
        weights : of the two, e.g. how many rows use them; the place starts from the heavier one,
            on equal terms from that of more members, then from `a`
        """
        first = self._of.get(a) or Place({a}, source=a)
        second = self._of.get(b) or Place({b}, source=b)
        key = key_of(name)
        self._at[name] = a
        ordered = key > first.last and key > second.last
        if first is second:
            self._of[a] = first
            first.ties[name] = (a, b)
            first.spare.add(name)
            self.spare.add(name)
            first.last = max(first.last, key)
            if not ordered:
                self._rebuild(first)
            return
        a_stays = (weights[0], len(first.members)) >= (weights[1], len(second.members))
        large, small = (
            (first, second) if len(first.members) >= len(second.members) else (second, first)
        )
        large.source = first.source if a_stays else second.source
        self.touched |= small.members
        if len(large.members) == 1:
            self.touched |= large.members
            self._of.update(dict.fromkeys(large.members, large))
        large.members |= small.members
        large.ties.update(small.ties)
        large.spare |= small.spare
        large.last = max(large.last, small.last, key)
        large.ties[name] = (a, b)
        self._of.update(dict.fromkeys(small.members, large))
        if not ordered:
            self._rebuild(large)

    def untie(self, name: str) -> None:
        """Two points are no longer held together by this tie."""
        place = self._of[self._at.pop(name)]
        spare = name in place.spare
        del place.ties[name]
        place.spare.discard(name)
        self.spare.discard(name)
        place.last = max(map(key_of, place.ties), default=(-2, ""))
        if not spare or not place.ties:
            self._rebuild(place)

    def _rebuild(self, place: Place) -> None:
        """Classes and spare ties of what one class has become."""
        above = {point: point for point in place.members}

        def top(point: int) -> int:
            while above[point] != point:
                above[point] = above[above[point]]
                point = above[point]
            return point

        spare = set()
        for name in sorted(place.ties, key=key_of):
            a, b = (top(point) for point in place.ties[name])
            if a == b:
                spare.add(name)
            else:
                above[max(a, b)] = min(a, b)
        self.spare.difference_update(place.ties)
        self.spare |= spare
        parts: dict[int, Place] = {}
        for point in sorted(place.members):
            parts.setdefault(top(point), Place(set())).members.add(point)
        for name, (a, _) in place.ties.items():
            part = parts[top(a)]
            part.ties[name] = place.ties[name]
            part.last = max(part.last, key_of(name))
            if name in spare:
                part.spare.add(name)
        if len(parts) > 1:
            self.touched |= place.members
        for part in parts.values():
            part.source = place.source if place.source in part.members else min(part.members)
            for point in part.members:
                if part.ties:
                    self._of[point] = part
                else:
                    self._of.pop(point, None)
