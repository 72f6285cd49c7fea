"""Records of another document into the one that is edited, under free names."""

from __future__ import annotations

from dataclasses import replace

from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import PREFIXES
from arael.sketch.document.records import Amount
from arael.sketch.expressions.renaming import renamed
from arael.sketch.transfer.naming import group_under, handle_under


def take_over(session: Session, other: Document) -> dict[str, str]:
    """Add everything of another document; new name of each of its records by the old one.

    Names stay where they are free in this sketch.
    """
    document = session.document
    names: dict[str, str] = {}
    taken: set[str] = set()

    def name_for(old: str) -> str:
        prefix = old.rstrip("0123456789")
        counted = prefix != old and prefix in PREFIXES
        new = document.next_name(prefix) if counted else old
        while new in taken or document.find(new) is not None:
            if prefix == old:
                new = f"{new}_"
            elif counted:
                new = document.next_name(prefix)
            else:
                new = f"{prefix}{int(new[len(prefix) :]) + 1}"
        names[old] = new
        taken.add(new)
        return new

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
            args = tuple(handle_under(names, one) for one in constraint.args)
            document.put("constraints", replace(constraint, name=name, args=args))
        for dimension in other.dimensions.values():
            document.put(
                "dimensions",
                replace(
                    dimension,
                    name=names[dimension.name],
                    args=tuple(handle_under(names, one) for one in dimension.args),
                    value=dimension.value and amount(dimension.value),
                    low=dimension.low and amount(dimension.low),
                    high=dimension.high and amount(dimension.high),
                ),
            )
        for group in other.groups.values():
            name_for(group.name)
            document.put("groups", group_under(names, group))
        session.editor.solve()
    return names
