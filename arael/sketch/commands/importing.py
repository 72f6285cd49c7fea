"""Records of another document into the one that is edited, under free names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Group, Option
from arael.sketch.expressions.dependencies import texts_of
from arael.sketch.expressions.renaming import renamed


def take_over(session: Session, other: Document) -> dict[str, str]:
    """Add everything of another document; new name of each of its records by the old one.

    Names stay where they are free in this sketch.
    """
    document = session.document
    names: dict[str, str] = {}

    def name_for(old: str) -> str:
        prefix = old.rstrip("0123456789")
        new = old if prefix == old else document.next_name(prefix)
        while document.find(new) is not None:
            new = document.next_name(prefix) if prefix != old else f"{new}_"
        names[old] = new
        return new

    def handle(text: str) -> str:
        name, dot, point = text.partition(".")
        return f"{names.get(name, name)}{dot}{point}"

    def amount(one: Amount) -> Amount:
        return Amount(renamed(one.text, names), one.number)

    with document.transaction("import"):
        for entity in other.entities.values():
            document.add_entity(
                entity.kind,
                other.numbers_of(entity.name),
                name=name_for(entity.name),
                construction=entity.construction,
                quiet=entity.quiet,
                style=entity.style,
                text=entity.text,
                clockwise=entity.clockwise,
            )
        for record in [*other.parameters, *other.dimensions]:
            name_for(record)
        for parameter in other.parameters.values():
            new = replace(parameter, name=names[parameter.name], amount=amount(parameter.amount))
            document.put("parameters", new)
        for constraint in other.constraints.values():
            own = constraint.name[1:-1] in other.entities
            name = (
                f"C{names[constraint.name[1:-1]]}{constraint.name[-1]}"
                if own
                else name_for(constraint.name)
            )
            names[constraint.name] = name
            args = tuple(map(handle, constraint.args))
            document.put("constraints", replace(constraint, name=name, args=args))
        for dimension in other.dimensions.values():
            document.put(
                "dimensions",
                replace(
                    dimension,
                    name=names[dimension.name],
                    args=tuple(map(handle, dimension.args)),
                    value=dimension.value and amount(dimension.value),
                    low=dimension.low and amount(dimension.low),
                    high=dimension.high and amount(dimension.high),
                ),
            )
        for group in other.groups.values():
            document.put(
                "groups",
                replace(
                    group,
                    name=name_for(group.name),
                    sources=tuple(names[one] for one in group.sources),
                    results=tuple(names[one] for one in group.results),
                    owned=tuple(names[one] for one in group.owned),
                    options=_options(group, names, handle),
                ),
            )
        session.editor.solve()
    return names


#: Options of groups that are handles, or lists of names.
_HANDLES = ("about", "along")
_NAMES = ("rests_on", "pins")


def _options(
    group: Group, names: Mapping[str, str], handle: Callable[[str], str]
) -> dict[str, Option]:
    """Options of a group with the names that its parts have now."""
    found = dict(group.options)
    for key, text in texts_of(group).items():
        found[key] = renamed(text, names)
    for key in _HANDLES:
        if found.get(key):
            found[key] = handle(str(found[key]))
    for key in _NAMES:
        listed = found.get(key)
        if isinstance(listed, tuple):
            found[key] = tuple(names.get(str(one), str(one)) for one in listed)
    return found
