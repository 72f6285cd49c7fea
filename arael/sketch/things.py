"""What a sketch holds, as objects with properties."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from arael.sketch.commands.describing import record_line
from arael.sketch.commands.session import measure_of
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.records import Constraint, Dimension, Entity, Group, Parameter, Record
from arael.sketch.expressions.properties import property_names, property_of

if TYPE_CHECKING:
    from arael.sketch.sketch import Sketch


class Thing:
    """Something in a sketch: entity, constraint, dimension, parameter or group.

    Attributes
    ----------
    name : ``L0``; text of it is the same, so that it can stand in commands
    """

    def __init__(self, sketch: Sketch, name: str) -> None:
        self._sketch = sketch
        self.name = name

    @property
    def record(self) -> Record:
        """What the document holds of it now; KeyError if it was deleted."""
        found = self._sketch.document.find(self.name)
        if found is None:
            raise KeyError(self.name)
        return found

    def delete(self) -> None:
        """Delete it, with everything that rests on it."""
        self._sketch.run(f"delete {self.name}")

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        found = self._sketch.document.find(self.name)
        if found is None:
            return f"<{self.name}: deleted>"
        return f"<{record_line(self._sketch.session, found)}>"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Thing) and self._sketch is other._sketch and str(self) == str(other)
        )

    def __hash__(self) -> int:
        return hash(str(self))


class Point(Sequence[float]):
    """A point of a sketch: its numbers are where it is now.

    Attributes
    ----------
    handle : ``L0.p1``; text of it is the same
    """

    def __init__(self, sketch: Sketch, handle: str) -> None:
        self._sketch = sketch
        self.handle = handle

    @property
    def _at(self) -> tuple[float, float]:
        at = self._sketch.document.point_at(self.handle)
        x, y = self._sketch.document.values[at : at + 2].tolist()
        return x, y

    @property
    def x(self) -> float:
        """First coordinate."""
        return self._at[0]

    @property
    def y(self) -> float:
        """Second coordinate."""
        return self._at[1]

    def __getitem__(self, index: Any) -> Any:
        return self._at[index]

    def __len__(self) -> int:
        return 2

    def __iter__(self) -> Iterator[float]:
        return iter(self._at)

    def __str__(self) -> str:
        return self.handle

    def __repr__(self) -> str:
        return f"<{self.handle}: {self.x:.6g}, {self.y:.6g}>"


class EntityThing(Thing):
    """Geometry: points by name (``line.p1``) and properties (``line.length``, ``arc.radius``).

    Angles are in degrees.
    """

    @property
    def record(self) -> Entity:
        """What the document holds of it now; KeyError if it was deleted."""
        return self._sketch.document.entities[self.name]

    @property
    def kind(self) -> str:
        """``line``, ``circle``, ..."""
        return self.record.kind

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        entity = self._sketch.document.entities.get(self.name)
        if entity is None:
            raise AttributeError(f"{self.name} was deleted")
        if name in point_offsets(entity):
            handle = self.name if entity.kind == "point" else f"{self.name}.{name}"
            return Point(self._sketch, handle)
        found = property_of(self._sketch.document, entity, name)
        if found is None:
            raise AttributeError(f"{self.name}, a {entity.kind}, has no {name!r}")
        return found

    def __dir__(self) -> list[str]:
        entity = self._sketch.document.entities.get(self.name)
        if entity is None:
            return list(super().__dir__())
        names = [name for name in property_names(entity) if "." not in name]
        return [*super().__dir__(), *names, *point_offsets(entity)]


class DimensionThing(Thing):
    """A dimension: its value can be read and set."""

    @property
    def record(self) -> Dimension:
        """What the document holds of it now; KeyError if it was deleted."""
        return self._sketch.document.dimensions[self.name]

    @property
    def value(self) -> float:
        """What it is to be; of ranges and derived ones what it measures. Angles in degrees."""
        record = self.record
        if record.value is None or record.derived:
            return measure_of(self._sketch.editor)(record)
        return record.value.number

    @value.setter
    def value(self, value: float | str) -> None:
        self._sketch.set_driven(self, value)


def thing(sketch: Sketch, name: str) -> AnyThing:
    """The object of a name; KeyError if there is nothing of this name."""
    record = sketch.document.find(name)
    if record is None:
        raise KeyError(name)
    if isinstance(record, Entity):
        return EntityThing(sketch, name)
    if isinstance(record, Dimension):
        return DimensionThing(sketch, name)
    assert isinstance(record, Constraint | Parameter | Group)
    return Thing(sketch, name)


AnyThing: TypeAlias = EntityThing | DimensionThing | Thing
