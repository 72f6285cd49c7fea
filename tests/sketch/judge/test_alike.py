"""Many motions in few sentences."""

from __future__ import annotations

import numpy as np
import pytest

from arael.sketch.commands.session import Session
from arael.sketch.judge.alike import Alike, alike
from arael.sketch.judge.motions import Motion


def said(*commands: str) -> list[tuple[str, int]]:
    session = Session()
    session.run("\n".join(commands))
    return [(one.sentence, one.count) for one in alike(session.editor.judge.free())]


def motion(sentence: str, *entities: str) -> Motion:
    return Motion(sentence, entities, np.zeros(0))


def test_few_motions_stay_as_they_are() -> None:
    found = said("add_line 0,0 5,0", "horizontal L0")
    assert found == [
        ("L0 can move along x", 1),
        ("L0 can move along y", 1),
        ("L0 can become longer at p1", 1),
    ]


def test_motions_of_the_same_words_are_one() -> None:
    lines = [f"add_line {10 * i},0 {10 * i + 8},{i}" for i in range(5)]
    assert said(*lines) == [
        ("L0..L4 can each move along x", 5),
        ("L0..L4 can each move along y", 5),
        ("L0..L4 can each turn about a point", 5),
        ("L0..L4 can each become longer at p1", 5),
    ]


def test_bodies_are_named_by_their_parts() -> None:
    found = said(*(f"add_rect {10 * i},0 {10 * i + 8},5 hv" for i in range(3)))
    assert found[0] == ("(L0..L3), (L4..L7) and (L8..L11) can each move along x", 3)
    assert found[2] == ("L0, L1, L4, L5 and 2 more can each move sideways", 6)
    assert sum(count for _, count in found) == 12


def test_one_thing_about_several_points_and_motions_of_several_things() -> None:
    found = alike(
        [
            *(motion(f"L0 can turn about ({i}, 2)", "L0") for i in range(3)),
            *(motion(f"pole {i} of S0 can move along x", "S0") for i in range(1, 4)),
            *(motion(f"the start of A{i} can move along it", f"A{i}") for i in range(2)),
            motion("L1 can slide along itself", "L1"),
            motion("L2 can slide along itself", "L2"),
            motion("L3 can turn and L4 can move together", "L3", "L4"),
        ]
    )
    assert found == [
        Alike("L0 can turn about a point", ("L0",), 3),
        Alike("the poles of S0 can move along x", ("S0",), 3),
        Alike("the start of A0 and A1 can each move along it", ("A0", "A1"), 2),
        Alike("L1 and L2 can each slide along themselves", ("L1", "L2"), 2),
        Alike("L3 can turn and L4 can move together", ("L3", "L4"), 1),
    ]


@pytest.mark.parametrize("count", [6, 7])
def test_the_command_counts_the_rest(count: int) -> None:
    session = Session()
    kinds = ["slide along itself", "move sideways", "grow", "turn", "bend", "leave", "stay"]
    motions = [motion(f"L{i} can {kind}", f"L{i}") for i, kind in enumerate(kinds[:count])]
    session.editor.judge.free = lambda: motions  # type: ignore[method-assign]
    (reply,) = session.run("free")
    lines = reply.text.splitlines()
    assert len(lines) == (7 if count == 6 else 8)
    assert (lines[-1] == "  and 1 more") == (count == 7)
    assert len(reply.data["motions"]) == count
