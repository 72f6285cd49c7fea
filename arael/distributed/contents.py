"""Content that was sent to this process, by its hash."""

from __future__ import annotations

from arael.compiler.cache import digest
from arael.diagnostics.records import AraelError, Diagnostic

ARRIVED: dict[str, bytes] = {}
"""Content that this process was given, by hash."""


def arrive(vouched: str, data: bytes) -> None:
    """Keep content that was sent to this process.

    Raises
    ------
    AraelError
        E0883 if it is not that of the hash; nothing is kept then.
    """
    if digest(data) != vouched:
        raise unvouched(vouched, f"its content has the hash {digest(data)[:16]}...")
    ARRIVED[vouched] = data


def forget(vouched: str) -> None:
    """Drop the content of a hash from this process."""
    ARRIVED.pop(vouched, None)


def unvouched(vouched: str, why: str) -> AraelError:
    """The error E0883."""
    return AraelError(
        Diagnostic(
            "E0883",
            f"a compiled model was refused: {why}",
            origin=f"model {vouched[:16]}...",
            notes=("workers run only compiled models whose hash the client vouches for",),
            help=("send the model again: start the command anew",),
        )
    )
