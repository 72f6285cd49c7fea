"""Which numbers share an unknown, and which are constants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.records import Constraint, Entity
from arael.sketch.layout.laid import acts
from arael.sketch.layout.operands import Operand
from arael.sketch.layout.state import State

#: Places of locks that differ by less than this share of the numbers are one.
LOCK_TOLERANCE = 1e-10

#: What `_axis` says of the second number of a point.
_Y = 2


class Aliases(State):
    """Coincident points get one column; what is locked or fixed becomes a constant."""

    def _hold(self, at: int, name: str, numbers: tuple[float, ...] | None) -> None:
        self._holds.setdefault(at, {})[name] = numbers
        self.places.touched.add(at)

    def _release(self, at: int, name: str) -> None:
        del self._holds[at][name]
        self._impossible.pop((name, at), None)
        if not self._holds[at]:
            del self._holds[at]
        self.places.touched.add(at)

    def _fix(self, entity: Entity, name: str) -> None:
        points = self._point_starts(entity)
        within = {point + k for point in points for k in (0, 1)}
        for point in points:
            self._hold(point, name, None)
        for offset in range(entity.at, entity.at + entity.size):
            if offset not in within:
                self._hold(offset, name, None)

    def _alias(self, dirty: dict[str, None]) -> None:
        """Columns and constants of what `places.touched` lists; users of what moved are dirty."""
        done: set[int] = set()
        touched, self.places.touched = self.places.touched, set()
        values = self.document.values
        for at in touched:
            if at in done or at >= len(self._root) or self._column[at] < 0:
                continue
            if self._axis[at] == _Y:
                # A point began here that is gone since, and another entity took its numbers.
                continue
            width = self._width(at)
            members = list(self.places.members(at)) if width == 2 else [at]
            done.update(members)
            self._settle(members, width, values, dirty)

    def _settle(
        self, members: list[int], width: int, values: NDArray[np.float64], dirty: dict[str, None]
    ) -> None:
        place = self.places.of(members[0]) if width == 2 else None
        source = place.source if place else members[0]
        root = int(self._column[source])
        holds = [
            (name, at, numbers)
            for at in members
            for name, numbers in self._holds.get(at, {}).items()
        ]
        use, constant = root, None
        if holds:
            holds.sort(key=lambda one: (one[2] is None, one[0]))
            constant = self._held(holds, width, values)
            if root in self._constants:
                use = self._constants[root]
                self.rows.set_constant(use, constant)
                self.guards.set_constant(use, constant)
            else:
                use = self._constants[root] = self._take_constant(constant)
        else:
            self._drop_constant(root)
        for at in members:
            own = int(self._column[at])
            if own != root:
                self._drop_constant(own)
                self._source[own : own + width] = -1
            if self._use[at] != use or self._root[at] != root:
                self._dirty_users(self._entity_at[at], dirty)
            for k in range(width):
                self._root[at + k] = root + k
                self._use[at + k] = use if use < 0 else root + k
        for k in range(width):
            self._source[root + k] = source + k if constant is None else -1
            if constant is not None:
                self.x[root + k] = constant[k]

    def _held(
        self,
        holds: list[tuple[str, int, tuple[float, ...] | None]],
        width: int,
        values: NDArray[np.float64],
    ) -> list[float]:
        """Where holds keep a place; those that contradict the first are impossible."""
        places = [
            list(numbers) if numbers is not None else values[at : at + width].tolist()
            for _, at, numbers in holds
        ]
        for (name, at, _), place in zip(holds, places, strict=True):
            self._impossible.pop((name, at), None)
            scale = max(map(abs, [*place, *places[0]]), default=0.0)
            if any(
                abs(a - b) > LOCK_TOLERANCE * scale for a, b in zip(place, places[0], strict=True)
            ):
                self._impossible[name, at] = f"`{holds[0][0]}` holds it at another place"
        return places[0]

    def _dirty_users(self, entity: str, dirty: dict[str, None]) -> None:
        for user in self._users.get(entity, ()):
            laid = self._laid.get(user)
            if laid is None or not acts(laid.record):
                continue
            dirty[user] = None
            if isinstance(laid.record, Constraint) and laid.record.kind == "point_on":
                # what else is in the point's place now lies on the curve, or no longer does
                self._tangents_of(laid.record.args[1], dirty)

    def _touch_tangents(self, args: list[Operand], dirty: dict[str, None]) -> None:
        for arg in args:
            self._tangents_of(arg.entity.name, dirty)

    def _tangents_of(self, entity: str, dirty: dict[str, None]) -> None:
        """Tangents of a curve are written otherwise where it holds a point of the other curve."""
        for user in self._users.get(entity, ()):
            laid = self._laid.get(user)
            if laid is None or not isinstance(laid.record, Constraint):
                continue
            if laid.record.kind == "tangent" and laid.record.active:
                dirty[user] = None
