"""Which optionals are known to be there: by guards, `if`, and where a body sits."""

from __future__ import annotations

import pytest

from tests.check.models import codes, diagnostics

MODEL = """
struct Fix { pos: vec3; quality: real; note: Note? }
struct Note { weight: real }
struct Pose {
    param pos: vec3
    gps: Fix?
    h: real?
    on: bool
    BODY
}
root Path { poses: list of Pose }
"""


def errors(body: str) -> list[str]:
    return [c for c in codes(MODEL.replace("BODY", body)) if c[0] == "E"]


@pytest.mark.parametrize(
    "body",
    [
        "constraint c when gps { pos - gps.pos }",
        "constraint c when gps and gps.quality > 2 { pos - gps.pos }",
        "constraint c when on and gps and h { (pos - gps.pos) * h }",
        "constraint c when not (not gps) { pos - gps.pos }",
        "constraint c when not (not gps or on) { pos - gps.pos }",
        "constraint c when (gps and on) or (gps and h) { pos - gps.pos }",
        "constraint c { if gps then pos - gps.pos else pos }",
        "constraint c { if not gps then pos else pos - gps.pos }",
        "constraint c { if not h or h < 2 then pos else pos * h }",
        "constraint c when gps.note { pos - gps.note.weight * gps.pos }",
        "constraint c when pose.gps { pos - self.gps.pos }",
    ],
)
def test_proved(body: str) -> None:
    assert errors(body) == []


@pytest.mark.parametrize(
    "body",
    [
        "constraint c { pos - gps.pos }",
        "constraint c when on { pos - gps.pos }",
        "constraint c when not gps { pos - gps.pos }",
        "constraint c when gps or h { pos - gps.pos }",
        "constraint c when gps.quality > 2 and gps { pos - gps.pos }",
        "constraint c when gps { pos - gps.note.weight * gps.pos }",
        "constraint c { if gps then pos else pos - gps.pos }",
        "constraint c { if h then pos * h else pos * h }",
        "constraint c when parent.poses { pos }",
    ],
)
def test_not_proved(body: str) -> None:
    assert set(errors(body)) <= {"E0501", "E0304"}
    assert errors(body)


def test_a_constraint_within_the_optional_needs_no_guard() -> None:
    text = """
    struct Mark { param x: real; constraint c { x - parent.offset - parent.parent.base } }
    struct Extra { offset: real; marks: list of Mark; param b: real; constraint d { b - offset } }
    struct Pose { base: real; extra: Extra? }
    root Path { poses: list of Pose }
    """
    assert codes(text) == []


def test_optionals_of_another_row_are_not_proved_by_ones_own() -> None:
    text = """
    struct Pose { param pos: vec3; gps: Fix? }
    struct Fix { pos: vec3 }
    struct Pair {
        a: ref Pose in root.poses
        b: ref Pose in root.poses
        constraint c when a.gps { a.pos - b.gps.pos }
    }
    root Path { poses: list of Pose; pairs: list of Pair }
    """
    assert codes(text) == ["E0501"]


def test_the_help_names_the_guard_to_add() -> None:
    (found,) = diagnostics(MODEL.replace("BODY", "constraint c { pos - pose.gps.pos }"))
    assert found.help[0].startswith("add `when pose.gps` to the constraint")
