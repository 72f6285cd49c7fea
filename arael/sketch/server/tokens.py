"""Tokens of a server: kept for a file at a port, so that open pages connect to it again."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
from pathlib import Path

_TOKEN = re.compile(r"[\w-]{32}\Z")


def tokens(file: Path, port: int) -> tuple[str, str]:
    """Tokens for pages and for agents.

    Parameters
    ----------
    file : that is served
    port : as the person chose it; 0 for a free one, which no page can expect again: the tokens are
        new each time

    Returns
    -------
    Two texts of 192 random bits. Those of a chosen port are kept in the user's state folder, where
    only the user can read them.
    """
    if port == 0:
        return new(), new()
    # imported here: start-up time
    from platformdirs import user_state_path

    name = hashlib.sha256(f"{port} {file.resolve()}".encode()).hexdigest()[:32]
    path = user_state_path("arael", appauthor=False) / "sketch" / name
    return _kept(path.with_suffix(".page")), _kept(path.with_suffix(".agents"))


def new() -> str:
    """A new token."""
    return secrets.token_urlsafe(24)


def _kept(path: Path) -> str:
    """The token of a file, which is made if it is not there; a new one if it cannot be kept."""
    with contextlib.suppress(OSError, UnicodeDecodeError):
        found = path.read_text("ascii")
        if _TOKEN.match(found) and not path.stat().st_mode & 0o077 * (os.name == "posix"):
            return found
    token = new()
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        path.unlink(missing_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
        with os.fdopen(os.open(path, flags, 0o600), "w", encoding="ascii") as file:
            file.write(token)
    return token
