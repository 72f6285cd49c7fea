"""Addresses of servers by file, so that pages and agents find a server again that was restarted."""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import socket
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import platformdirs

from arael.diagnostics.records import AraelError, Diagnostic

HOST = "127.0.0.1"


def _token() -> str:
    return secrets.token_urlsafe(24)


@dataclass(frozen=True)
class Address:
    """Where a server listens, and what it asks for.

    Attributes
    ----------
    port : 0 for any
    token : of pages
    agent_token : of agents, which cannot connect as a page with it
    """

    port: int = 0
    token: str = field(default_factory=_token)
    agent_token: str = field(default_factory=_token)

    @property
    def page(self) -> str:
        """Of the page."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    @property
    def agents(self) -> str:
        """Of agents."""
        return f"http://{HOST}:{self.port}/mcp?token={self.agent_token}"


def listening(port: int) -> socket.socket:
    """A socket that listens on this machine only.

    Raises
    ------
    AraelError
        E1413: the port is taken, or may not be used
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
        listener.listen(64)
    except (OSError, OverflowError) as error:
        listener.close()
        reason = (getattr(error, "strerror", "") or str(error)).lower()
        raise AraelError(
            Diagnostic(
                "E1413",
                f"port {port} cannot be used: {reason}",
                help=("leave `--port` out for a free one",),
            )
        ) from None
    return listener


def listening_for(file: Path, port: int = 0) -> tuple[socket.socket, Address]:
    """A socket for the server of a file, with the address that it had last if it is free.

    Parameters
    ----------
    port : that is asked for, 0 for none
    """
    known = _known(file)
    listener = None
    if known.port and not port:
        with contextlib.suppress(AraelError):
            listener = listening(known.port)
    listener = listener or listening(port)
    found = Address(listener.getsockname()[1], known.token, known.agent_token)
    _keep(file, found)
    return listener, found


def _place(file: Path) -> Path:
    folder = os.environ.get("ARAEL_STATE_DIR") or platformdirs.user_state_path("arael")
    name = hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:32]
    return Path(folder) / "sketch_servers" / f"{name}.json"


def _known(file: Path) -> Address:
    """The last address of a file's server; a new one if there is none, or it cannot be read."""
    place = _place(file)
    try:
        if place.stat().st_mode & 0o077 and os.name == "posix":  # others may have read it
            return Address()
        found = msgspec.json.decode(place.read_bytes(), type=Address)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return Address()
    if not 0 < found.port < 65536 or min(len(found.token), len(found.agent_token)) < 16:
        return Address()
    return found


def _keep(file: Path, address: Address) -> None:
    """Remember an address, readable by this account only; without a place for it, do not."""
    place = _place(file)
    with contextlib.suppress(OSError):
        place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        place.unlink(missing_ok=True)
        handle = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "wb") as opened:
            opened.write(msgspec.json.encode(address))
