"""Corrections: offered only where they remove the error."""

from __future__ import annotations

import pytest

from arael.lsp.actions import actions
from arael.lsp.workspace import Workspace
from tests.lsp.texts import MODEL, document


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("(step - odo)", "(stepp - odo)"),
        ("pose.pos)", "pose.poss)"),
        ("norm(beacon", "nrm(beacon"),
        ("ref Beacon in", "ref Becon in"),
        ("in root.beacons", "in root.beacon"),
        ("in root.beacons", "in beacons"),
        ("huber(1.5)", "hubr(1.5)"),
        ("odometry when prev {", "odometry {"),
        ("path.sigma\n    }\n}\n\nroot", "sigma\n    }\n}\n\nroot"),
        ("real [m] = 0.1", "rea [m] = 0.1"),
        ("freeze beacons.pos", "freeze beacons.poss"),
        ("list of Sight", "list of Sigt"),
    ],
)
def test_the_correction_restores_the_model(right: str, wrong: str) -> None:
    text = MODEL.replace(right, wrong, 1)
    model = document(text)
    assert model.errors, wrong
    found = actions(model, 0, len(text), Workspace())
    assert found, [d.help for d in model.errors]
    for one in found:
        changed = text[: one.span.start] + one.text + text[one.span.end :]
        assert len(document(changed).errors) < len(model.errors)
    texts = [text[: a.span.start] + a.text + text[a.span.end :] for a in found]
    assert any(not document(one).findings for one in texts)


def test_a_guard_joins_one_that_is_there() -> None:
    text = MODEL.replace("odometry when prev {", "odometry when odo.x > 0 {")
    found = actions(document(text), 0, len(text), Workspace())
    changed = [text[: a.span.start] + a.text + text[a.span.end :] for a in found]
    assert any("when prev and odo.x > 0 {" in one for one in changed)


def test_nothing_is_offered_that_does_not_help() -> None:
    text = MODEL.replace("(step - odo)", "(step - range)")  # no field of a pose
    model = document(text)
    assert model.errors
    assert actions(model, 0, len(text), Workspace()) == []
    assert actions(document(), 0, len(MODEL), Workspace()) == []
