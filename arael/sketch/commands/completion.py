"""Words that may be completed at a prompt."""

from __future__ import annotations

from arael.sketch.commands import table
from arael.sketch.commands.asking import list_words
from arael.sketch.commands.session import Session
from arael.sketch.document.handles import point_offsets
from arael.sketch.expressions.functions import GEOMETRY, scalar_functions
from arael.sketch.expressions.properties import property_names


def completions(session: Session) -> list[str]:
    """Commands, their keywords, and what a value may be made of; sorted."""
    found = {*table.words(), *table.GROUPS, *list_words(), *value_words(session)}
    for command in table.commands().values():
        found.update(command.keywords)
    return sorted(found)


def value_words(session: Session) -> list[str]:
    """Names of the sketch, variables, functions; sorted."""
    document = session.document
    found = {*GEOMETRY, *scalar_functions()}
    for entity in document.entities.values():
        found.add(entity.name)
        parts = [*point_offsets(entity), *property_names(entity)]
        aliases = [name for name, value in session.state.variables.items() if value == entity.name]
        for name in (entity.name, *aliases):
            found.update(f"{name}.{part}" for part in parts)
    for names in (
        document.constraints,
        document.dimensions,
        document.parameters,
        document.groups,
        session.state.variables,
    ):
        found.update(names)
    return sorted(found)
