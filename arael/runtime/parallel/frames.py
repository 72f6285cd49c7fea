"""How much stack generated functions may take, from what is known of them before they run."""

from __future__ import annotations

from collections.abc import Sequence

from arael.runtime.layout import Entity, Group

# Bytes of a variable on all lanes: 8 doubles or 16 floats.
_LANES = 64

# A compiler may keep every variable in memory, and some of them twice.
_COPIES = 2

# Variables of one part of a kernel that is compiled in parts (`arael.compiler.parts`), generously.
_PART = 1000

# What a function takes whatever it computes.
_BASE = 8192


def frame_of(group: Group, entities: Sequence[Entity]) -> int:
    """Return bytes of stack that suffice for every kernel of a constraint.

    An estimate on the safe side, not a guarantee of the compiler: no variable shares its place with
    another. Of three kernels that were measured, GCC 12 reports (``-fstack-usage``) frames of a
    sixth, a ninth and a seventeenth of it.
    """
    if group.workspace:
        return _BASE + _LANES * (group.workspace + len(group.jacobian) + _COPIES * _PART)
    tangent = [entities[use.entity].tangent for use in group.uses]
    width = sum(tangent)
    variables = (
        len(group.states)
        + 2 * (group.residuals + len(group.jacobian))
        + group.residuals * width
        + 2 * (width + width * (width + 1) // 2)
        + max(group.operations_after, len(group.tape.ops))
        + sum(len(tape.ops) for _, tape, _ in group.written)
    )
    return _BASE + _COPIES * _LANES * variables


def refresh_frame_of(entity: Entity) -> int:
    """Return bytes of stack that suffice to move the rows of an entity."""
    return _BASE + _COPIES * _LANES * (entity.state + len(entity.refresh.ops))
