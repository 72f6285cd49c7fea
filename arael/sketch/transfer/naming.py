"""Names: records under others, and everything that refers to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from arael.sketch.document.document import Document
from arael.sketch.document.records import Dimension, Entity, Group, Option
from arael.sketch.expressions.dependencies import texts_of
from arael.sketch.expressions.renaming import rename_everywhere, renamed
from arael.sketch.transfer.carry import users

#: Options of groups that are handles, or lists of names.
_HANDLES = ("about", "along")
_NAMES = ("rests_on", "pins")


def handle_under(names: Mapping[str, str], handle: str) -> str:
    """A handle with another name of its entity, if it has one: old -> new."""
    name, dot, point = handle.partition(".")
    return f"{names.get(name, name)}{dot}{point}"


def group_under(names: Mapping[str, str], group: Group) -> Group:
    """A group with other names of itself and of its parts, in its options too: old -> new."""

    def under(listed: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(handle_under(names, one) for one in listed)

    options: dict[str, Option] = dict(group.options)
    for key, text in texts_of(group).items():
        options[key] = renamed(text, names)
    for key in _HANDLES:
        if options.get(key):
            options[key] = handle_under(names, str(options[key]))
    for key in _NAMES:
        listed = options.get(key)
        if isinstance(listed, tuple):
            options[key] = under(tuple(map(str, listed)))
    return replace(
        group,
        name=names.get(group.name, group.name),
        sources=under(group.sources),
        results=under(group.results),
        owned=under(group.owned),
        options=options,
    )


def rename(document: Document, record: Entity | Dimension, name: str) -> dict[str, str]:
    """Give an entity or dimension another name, which is free; a transaction is open.

    Constraints, dimensions, groups and expressions that refer to it follow; no number changes.

    Returns
    -------
    New names by the old ones: those of a line's own constraints (``CL0H``) follow its name.
    """
    names = {record.name: name}
    if isinstance(record, Dimension):
        document.rename("dimensions", record.name, replace(record, name=name))
    else:
        document.rename("entities", record.name, replace(record, name=name))
        for user in users(document, record.name):
            args = tuple(handle_under({record.name: name}, one) for one in user.args)
            if isinstance(user, Dimension):
                document.put("dimensions", replace(user, args=args))
            elif user.name in (f"C{record.name}H", f"C{record.name}V"):
                own = f"C{name}{user.name[-1]}"
                names[user.name] = own
                document.rename("constraints", user.name, replace(user, name=own, args=args))
            else:
                document.put("constraints", replace(user, args=args))
    for group in document.groups.values():
        document.put("groups", group_under(names, group))
    rename_everywhere(document, names)
    return names
