"""Commands on the session itself."""

from __future__ import annotations

from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command


@command(
    "exit",
    group="session",
    usage=["exit"],
    summary="Leave the editor.",
    aliases=["quit"],
    arguments=(),
    outside=True,
)
def leave(session: Session, words: Words) -> Reply:
    """Leave."""
    return Reply("", leaves=True, remembered=False)
