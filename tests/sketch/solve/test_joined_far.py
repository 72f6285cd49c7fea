"""Places that are joined from far: only sides of what is joined may turn over."""

from __future__ import annotations

import random

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session

DRAWING = """
add_arc 0,0 4,0 2,2
add_line 4,0 9,1
add_line 9,1 12,6
add_arc 20,0 24,0 22,1.5
add_circle 30,3 2
add_line 28,8 33,7
add_arc 12,6 15,9 14,7
tangent L0 A0
tangent L1 A3
length L1 5
angle L0 L1 60
tangent L2 A2
"""

POINTS = [
    "A0.start",
    "A0.end",
    "A0.center",
    "L0.p2",
    "L1.p2",
    "A1.start",
    "A1.end",
    "A1.center",
    "A2.center",
    "L2.p1",
    "L2.p2",
    "A3.end",
    "A3.center",
]


def sides(session: Session) -> dict[str, list[bool]]:
    """Signs of the sides that are kept, by record."""
    layout = session.editor.layout
    layout.refresh()
    found: dict[str, list[bool]] = {}
    signs = layout.guards.evaluate(layout.gather().copy()).tolist()
    for name, sign in zip(layout.guard_owner, signs, strict=False):
        if name:
            found.setdefault(name, []).append(sign > 0.0)
    return found


def joined(session: Session, handles: list[str]) -> set[str]:
    """Entities with a point at the place of one of the handles."""
    document, layout = session.document, session.editor.layout
    return {
        point.partition(".")[0]
        for point in (*POINTS, "L0.p1", "L1.p1", "A3.start")
        if any(layout.same(document.point_at(point), document.point_at(one)) for one in handles)
    }


@pytest.mark.sweep(4)
@pytest.mark.parametrize("seed", range(24))
def test_only_sides_of_joined_geometry_turn_over(seed: int) -> None:
    chance = random.Random(seed)
    session = Session()
    session.run(DRAWING)
    for _ in range(5):
        a, b = chance.sample(POINTS, 2)
        place = f"{chance.uniform(-20, 40):.1f},{chance.uniform(-20, 20):.1f}"
        command, handles = chance.choice(
            [(f"coincident {a} {b}", [a, b]), (f"lock {a} {place}", [a])]
        )
        before, touched = sides(session), joined(session, handles)
        numbers = session.document.values.copy()
        try:
            session.run(command)
        except AraelError:
            assert np.array_equal(session.document.values, numbers), command
            continue
        after = sides(session)
        for name, signs in before.items():
            record = session.document.constraints.get(name) or session.document.dimensions.get(name)
            of = {one.partition(".")[0] for one in record.args} if record else {name}
            if not of & touched:
                # a side that an earlier join had left wrong may come right
                kept = zip(signs, after[name], strict=True)
                assert all(now for was, now in kept if was), (command, name)
