"""Random groups and edits of them: freedoms as expected, undo bit by bit."""

from __future__ import annotations

import random

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.groups.support import freedom, sketch

SOURCES = (
    "add_line 0,0 10,0 10,6 4,9",
    "add_rect 0,0 10,6",
    "add_rect 0,0 10,6\nfillet L0 L1 L1 L2 L2 L3 L3 L0 1",
    "add_line 0,0 6,0\nadd_arc 6,0 10,4 8.82842712,1.17157288\nadd_line 10,4 14,4",
    "add_circle 3,3 2",
    "add_ellipse 3,3 4 2 20",
)


def _made(chance: random.Random, s: Session) -> str:
    names = " ".join(n for n in s.document.entities if not n.startswith("P"))
    d = round(chance.uniform(0.1, 1.5), 2)
    sides = ["", "right", "symmetric", f"{d + 0.3:g}", "flip round", "symmetric round", "nopin"]
    offset = f"offset sequence {names.split()[0]} {d}"
    offsets = [
        f"{offset} {chance.choice(sides)}",
        f"{offset} symmetric caps {chance.choice(['line', 'round'])}",
    ]
    patterns = [
        f"pattern rect {names} {chance.randint(2, 4)} {20 * d:g}",
        f"pattern circular {names} about P0 {chance.randint(2, 5)}",
        f"pattern circular {names} about P0 3 partial {40 * d:g}",
    ]
    return chance.choice(offsets + patterns)


def _edit(chance: random.Random, kind: str) -> str:
    d = round(chance.uniform(0.1, 1.5), 2)
    if kind == "offset":
        words = ["", "flip", "round", "sharp", "symmetric", "one", "caps line", "caps none", "pin"]
        return f"offset M0 {d} {chance.choice(words)}"
    return f"pattern M0 {chance.randint(2, 5)}"


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    "seed", [*range(12), *(pytest.param(k, marks=pytest.mark.slow) for k in range(12, 200))]
)
def test_random_groups_and_edits(seed: int) -> None:
    chance = random.Random(seed)
    s = sketch(f"{chance.choice(SOURCES)}\nadd_point -15,-9")
    before = freedom(s)
    states = [s.document.values.tobytes()]
    steps = [len(s.document.history.done)]
    for _ in range(6):
        group = next(iter(s.document.groups.values()), None)
        command = _made(chance, s) if group is None else _edit(chance, group.kind)
        try:
            s.run(command)
        except AraelError as error:
            # nothing is left of what is refused
            assert error.diagnostics[0].code in ("E1273", "E1256"), command
            assert s.document.values.tobytes() == states[-1]
            continue
        states.append(s.document.values.tobytes())
        steps.append(len(s.document.history.done))
        loose = any(g.options.get("pinned") is False for g in s.document.groups.values())
        assert (freedom(s) == before) or loose, command
    for state, step in zip(reversed(states), reversed(steps), strict=True):
        while len(s.document.history.done) > step:
            s.document.undo()
        assert s.document.values.tobytes() == state
