"""A model for these tests, and places in it by a mark."""

from __future__ import annotations

from pathlib import Path

from arael.diagnostics.records import Source
from arael.lsp.document import Document, analyse
from arael.lsp.workspace import Workspace

MODEL = """\
# Length of a wheel's turn.
const TURN = 2 * pi

# Range of a beacon.
fn beyond(x, limit) = max(x - limit, 0)

struct Beacon {
    param pos: vec2 [m]
}

struct Pose {
    # Where the robot is.
    param pos: vec2 [m]
    param heading: angle [rad]
    prev: ref Pose in root.poses?
    odo: vec2 [m]

    # Wheel odometry.
    constraint odometry when prev {
        let before = prev
        let step = rotation_matrix(before.heading).transpose() * (pos - before.pos)
        (step - odo) / path.sigma
    }
}

struct Sight {
    pose: ref Pose in root.poses
    beacon: ref Beacon in root.beacons
    range: real [m]

    constraint seen loss huber(1.5) {
        (norm(beacon.pos - pose.pos) - range) / path.sigma
    }
}

root Path {
    poses: list of Pose
    beacons: list of Beacon
    sights: list of Sight
    sigma: real [m] = 0.1

    solve {
        pass start { freeze beacons.pos }
    }
}
"""


def document(text: str = MODEL, name: str = "model.arael") -> Document:
    """A text as a document; no other file is open."""
    return analyse(Source(name, text), Workspace())


def at(text: str, mark: str, number: int = 0) -> int:
    """Offset of `|` in `mark`, at the occurrence `number` of `mark` without it."""
    found = -1
    for _ in range(number + 1):
        found = text.index(mark.replace("|", ""), found + 1)
    return found + mark.index("|")


def folder(path: Path, **texts: str) -> None:
    """Write files ``name.arael``."""
    for name, text in texts.items():
        (path / f"{name}.arael").write_text(text)
