"""Hover: declaration, type, unit, documentation, operations."""

from __future__ import annotations

import pytest

from arael.lsp.counting import counted
from arael.lsp.hover import hover
from tests.lsp.texts import MODEL, at, document


def shown(mark: str, number: int = 0) -> str:
    found = hover(document(), at(MODEL, mark, number), {})
    assert found is not None
    return found[0]


@pytest.mark.parametrize(
    ("mark", "parts"),
    [
        (
            "pos|: vec2 [m]\n    param heading",
            ["param pos: vec2 [m]", "of `Pose`", "Where the robot"],
        ),
        ("before.po|s", ["param pos: vec2 [m]", "type `vec2 [m]`"]),
        ("st|ep - odo", ["let step = rotation_matrix", "type `vec2 [m]`"]),
        ("let before = pre|v", ["prev: ref Pose in root.poses?", "type `the struct Pose`"]),
        ("pat|h.sigma", ["root Path"]),
        ("TU|RN", ["const TURN = 2 * pi", "type `real`", "Length of a wheel"]),
        ("bey|ond", ["fn beyond(x, limit)", "Range of a beacon"]),
        ("ma|x(", ["max(...)", "takes scalars"]),
        ("hub|er(", ["loss huber(scale)"]),
        ("constr|aint odometry", ["constraint NAME when GUARD"]),
        ("nor|m(", ["takes a vector"]),
        ("free|ze", ["held in this pass"]),
        ("beacons.po|s }", ["param pos: vec2 [m]", "of `Beacon`"]),
    ],
)
def test_hover(mark: str, parts: list[str]) -> None:
    text = shown(mark)
    for part in parts:
        assert part in text, text


def test_operations_of_a_constraint() -> None:
    counts = counted(document().source)
    assert set(counts) == {"Pose.odometry", "Sight.seen"}
    found = hover(document(), at(MODEL, "constraint se|en"), counts)
    assert found is not None
    assert "1 residual, " in found[0]
    assert "operations (" in found[0]
    assert "Wheel odometry" in hover(document(), at(MODEL, "constraint odo|metry"), {})[0]  # type: ignore[index]


def test_nothing_of_numbers_and_blanks() -> None:
    assert hover(document(), at(MODEL, "huber(1|.5)"), {}) is None
    assert hover(document(), at(MODEL, "root Path {|"), {}) is None


def test_a_broken_text_keeps_the_declarations_of_the_last_complete_one() -> None:
    from arael.diagnostics.records import Source
    from arael.lsp.document import analyse
    from arael.lsp.workspace import Workspace

    text = MODEL.replace("(step - odo) / path.sigma", "(step - odo) / (path.sigma")
    broken = analyse(Source("model.arael", text), Workspace(), document())
    assert not broken.complete
    assert broken.errors
    found = hover(broken, at(text, "beacon.po|s - pose"), {})
    assert found is not None
    assert "of `Beacon`" in found[0]
