"""What was let in with a reservation, in words."""

from __future__ import annotations

from arael.sketch.document.document import Document
from arael.sketch.editing.refusals import listed
from arael.sketch.judge.judge import Verdict


def only_here(label: str, verdict: Verdict) -> str:
    """Of equations that follow from others in this position only."""
    if not verdict.freedoms:
        return (
            f"notice: `{label}` takes no degree of freedom in this position, only when the "
            "geometry is moved"
        )
    rest = verdict.most - verdict.freedoms
    return (
        f"notice: `{label}` takes {verdict.freedoms} of its {verdict.most} degrees of freedom in "
        f"this position, the other{'' if rest == 1 else f' {rest}'} only when the geometry is moved"
    )


def partly(label: str, verdict: Verdict) -> str:
    """Of equations some of which follow from others."""
    rest = verdict.most - verdict.freedoms
    follow = "the other follows" if rest == 1 else f"the other {rest} follow"
    others = [name for name in verdict.members if name != verdict.name]
    return (
        f"notice: `{label}` takes {verdict.freedoms} of its {verdict.most} degrees of freedom: "
        f"{follow} from {listed(others)}"
    )


def kept_by(document: Document, name: str, verdict: Verdict) -> list[str]:
    """What a dimension holds besides its value, if nothing else does: it goes with it."""
    record = document.dimensions[name]
    # A range has an equation, with a slack, for each of its ends.
    own = (record.low is not None) + (record.high is not None) or 1
    if record.kind != "distance" or verdict.freedoms <= own:
        return []
    one, two = record.args
    how = "parallel" if document.entities[one].kind == "line" else "concentric"
    return [f"notice: {one} and {two} stay {how} as long as {name} is there"]
