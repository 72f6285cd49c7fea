"""Messages of files that cannot be read or written."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic

MAX_BYTES = 256 * 1024 * 1024
"""Larger files are refused before they are read."""

MAX_ENTITIES = 200_000
"""Curves that one file may bring, blocks exploded."""

MAX_DEPTH = 64
"""How deeply blocks or elements may be nested."""


def unreadable(kind: str, reason: str, origin: str) -> AraelError:
    """E1302: the content is not what the suffix says, or is damaged."""
    return AraelError(
        Diagnostic(
            "E1302",
            f"cannot be read as {kind}: {reason}",
            origin=origin,
            help=("open it in the program that wrote it, and save it again",),
        )
    )


def over_limit(what: str, most: int, origin: str) -> AraelError:
    """E1303: more than a file may hold."""
    return AraelError(
        Diagnostic(
            "E1303",
            f"{what}; at most {most:,} are read",
            origin=origin,
            help=("remove what does not belong to the sketch, or split the file",),
        )
    )


def not_installed(purpose: str, library: str, extra: str) -> AraelError:
    """E1305: an optional library is missing."""
    return AraelError(
        Diagnostic(
            "E1305",
            f"{purpose} needs {library}, which is not installed",
            help=(f'pip install "arael[{extra}]"',),
        )
    )
