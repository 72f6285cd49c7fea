"""Completion on half-typed texts, signature help, hints."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import Source
from arael.lsp.completion import completions
from arael.lsp.document import Document, analyse
from arael.lsp.hints import hints
from arael.lsp.signatures import signature
from arael.lsp.workspace import Workspace
from tests.lsp.texts import MODEL, at, document


def typed(before: str, after: str) -> tuple[Document, int]:
    """`MODEL` with a change that ends at `|`, as an editor has it while the change is typed."""
    text = MODEL.replace(before, after.replace("|", ""), 1)
    offset = MODEL.index(before) + after.index("|")
    return analyse(Source("model.arael", text), Workspace(), document()), offset


@pytest.mark.parametrize(
    ("before", "after", "there", "absent"),
    [
        ("beacon.pos - pose.pos", "beacon.| - pose.pos", ["pos", "parent"], ["heading", "sin"]),
        ("(step - odo)", "(before.| - odo)", ["heading", "pos", "prev", "odo"], ["beacons"]),
        ("(step - odo)", "(before.pos.|", ["x", "y", "value", "norm"], ["z", "inverse"]),
        ("(step - odo)", "(st|", ["step", "before", "heading", "path", "max", "if"], ["beacon"]),
        ("huber(1.5)", "h|", ["huber", "cauchy"], ["norm"]),
        ("range: real [m]", "range: |", ["real", "vec3", "Beacon", "list"], ["Path", "norm"]),
        ("range: real [m]", "range: real [|", ["m", "rad"], ["real"]),
        ("ref Beacon in", "ref | in", ["Beacon", "Pose"], ["real"]),
        ("range: real [m]", "con|", ["constraint", "param"], ["norm"]),
        ("freeze beacons.pos", "freeze |", ["beacons", "poses", "max_iters"], ["norm"]),
        ("freeze beacons.pos", "freeze beacons.|", ["pos"], ["range"]),
        ("root Path {", "str|\n\nroot Path {", ["struct", "const"], ["constraint"]),
        ("max(x - limit, 0)", "max(li|", ["limit", "x", "TURN", "max"], ["pos"]),
    ],
)
def test_completion(before: str, after: str, there: list[str], absent: list[str]) -> None:
    found = {c.label for c in completions(*typed(before, after))}
    assert set(there) <= found
    assert not found & set(absent)


def test_own_names_come_first() -> None:
    labels = [c.label for c in completions(*typed("(step - odo)", "(|"))]
    assert labels.index("step") < labels.index("odo") < labels.index("TURN") < labels.index("sin")
    assert len(labels) == len(set(labels))


@pytest.mark.parametrize(
    ("after", "label", "active"),
    [
        ("(atan2(|", "atan2(y, x)", 0),
        ("(atan2(pos.y, |", "atan2(y, x)", 1),
        ("(beyond(norm(odo), |", "beyond(x, limit)", 1),
        ("(beyond(norm(|", "norm(x)", 0),
        ("(max(1, 2, 3, |", "max(a, b, ...)", 2),
    ],
)
def test_signature(after: str, label: str, active: int) -> None:
    found = signature(*typed("(step - odo)", after))
    assert found is not None
    assert (found.label, found.active) == (label, active)


def test_no_signature_outside_of_a_call() -> None:
    assert signature(*typed("(step - odo)", "(step - |")) is None


def test_hints_show_types_and_units_of_lets_and_constants() -> None:
    found = {MODEL[: h.offset].split()[-1]: h.text for h in hints(document(), 0, len(MODEL))}
    assert found == {"TURN": ": real", "before": ": the struct Pose", "step": ": vec2 [m]"}
    assert not hints(document(), 0, at(MODEL, "con|st"))
