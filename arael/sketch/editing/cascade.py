"""What goes with a record that is deleted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.sketch.document.document import Document


@dataclass(slots=True)
class Doomed:
    """Records that are deleted together, by table, in the order they were found.

    Attributes
    ----------
    dissolved : groups that lose a part, and why; their geometry stays
    """

    entities: dict[str, None] = field(default_factory=dict)
    constraints: dict[str, None] = field(default_factory=dict)
    dimensions: dict[str, None] = field(default_factory=dict)
    parameters: dict[str, None] = field(default_factory=dict)
    groups: dict[str, None] = field(default_factory=dict)
    dissolved: dict[str, str] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """All of them, entities first."""
        return [
            *self.entities,
            *self.constraints,
            *self.dimensions,
            *self.parameters,
            *self.groups,
        ]


def doomed(document: Document, names: Iterable[str]) -> Doomed:
    """Everything that goes when the records with these names are deleted.

    With an entity go its constraints and dimensions; a group that loses a source, a result or
    something it owns is dissolved. Expressions that read what is gone stay and are broken.

    Raises
    ------
    AraelError
        E1201: no record of this name
    """
    found = Doomed()
    for name in names:
        record = document.find(name)
        if record is None:
            known = [n for t in _tables(document) for n in t]
            near = closest(name, known)
            raise AraelError(
                Diagnostic(
                    "E1201",
                    f"nothing in the sketch is called `{name}`",
                    help=(f"did you mean `{near[0]}`?" if near else "`list` shows what there is",),
                )
            )
        for table in ("entities", "constraints", "dimensions", "parameters", "groups"):
            if name in getattr(document, table):
                getattr(found, table)[name] = None
    _with_entities(document, found)
    _dissolve(document, found)
    return found


def _tables(document: Document) -> tuple[Iterable[str], ...]:
    return (
        document.entities,
        document.constraints,
        document.dimensions,
        document.parameters,
        document.groups,
    )


def _entity_of(handle: str) -> str:
    return handle.partition(".")[0]


def _with_entities(document: Document, found: Doomed) -> None:
    if not found.entities:
        return
    for constraint in document.constraints.values():
        if any(_entity_of(arg) in found.entities for arg in constraint.args):
            found.constraints[constraint.name] = None
    for dimension in document.dimensions.values():
        if any(_entity_of(arg) in found.entities for arg in dimension.args):
            found.dimensions[dimension.name] = None


def _dissolve(document: Document, found: Doomed) -> None:
    for group in document.groups.values():
        if group.name in found.groups:
            continue
        lost = next(
            (
                name
                for name in (*group.sources, *group.results, *group.owned)
                if name in found.entities or name in found.constraints or name in found.dimensions
            ),
            None,
        )
        if lost is not None:
            found.dissolved[group.name] = lost


def disowned(document: Document, name: str) -> list[str]:
    """Dissolve the groups that own a dimension which is changed by itself; notices.

    What such a group was given does not say any more what it is; its geometry stays as it is held.
    """
    found = [group for group in document.groups.values() if name in group.owned]
    for group in found:
        document.remove("groups", group.name)
    return [
        f"notice: {group.name} ({group.kind}) is dissolved: {name} was changed; "
        f"`{group.kind} {group.name} ...` changes it as a whole"
        for group in found
    ]
