"""Bytes in and out: bounded reading, writing whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import gzip
import os
import stat
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from arael.diagnostics.records import AraelError
from arael.runtime.store.messages import error

# The most that is read from one file, after decompression, unless the caller says otherwise.
DEFAULT_LIMIT = 2 * 1024**3

_CHUNK = 1 << 20

StrPath = str | os.PathLike[str]


def read_bytes(path: StrPath, limit: int = DEFAULT_LIMIT) -> bytes:
    """Content of a file, decompressed if gzipped.

    Raises
    ------
    AraelError
        E0712 missing, a directory, unreadable, empty or not gzip after all; E0714 over the limit.
    """
    name = os.fspath(path)
    check_readable(path)
    try:
        with open(path, "rb") as file:
            content = _read_at_most(file, limit + 1)
    except OSError as failure:
        raise unreadable(name, failure) from None
    if not content:
        raise error("E0712", "the file is empty", name)
    if len(content) > limit:
        raise too_large(name, limit)
    if content[:2] == b"\x1f\x8b":
        return _gunzip(content, name, limit)
    return content


def _read_at_most(file: BinaryIO, count: int) -> bytes:
    """Read up to `count` bytes; ``file.read(count)`` would ask for that much memory first."""
    size = os.fstat(file.fileno()).st_size
    parts = [file.read(min(size + 1, count))]
    left = count - len(parts[0])
    while left > 0 and parts[-1]:  # what has no size, as a pipe, or grew meanwhile
        parts.append(file.read(min(left, _CHUNK)))
        left -= len(parts[-1])
    return b"".join(parts)


def check_readable(path: StrPath) -> None:
    """Raise E0712 for what is not there or is a directory."""
    name = os.fspath(path)
    if os.path.isdir(path):
        raise error("E0712", "expected a file, found a directory", name)
    if not os.path.exists(path):
        raise error("E0712", "no such file", name)


def unreadable(name: str, failure: OSError) -> AraelError:
    """E0712 from what the system says."""
    reason = failure.strerror or str(failure)
    return error("E0712", f"cannot read the file: {reason.lower()}", name)


def too_large(name: str, limit: int) -> AraelError:
    """E0714."""
    return error(
        "E0714",
        f"the content is larger than {limit} bytes",
        name,
        help="raise `limit` if it is meant",
    )


def _gunzip(content: bytes, name: str, limit: int) -> bytes:
    parts: list[bytes] = []
    left = limit + 1
    try:
        while content:
            stream = zlib.decompressobj(wbits=31)
            part = stream.decompress(content, left)
            left -= len(part)
            parts.append(part)
            if left <= 0:
                raise too_large(name, limit)
            if not stream.eof:
                raise error("E0712", "the gzipped content is truncated", name)
            content = stream.unused_data.lstrip(b"\0")
    except zlib.error:
        raise error("E0712", "the gzipped content is damaged", name) from None
    return b"".join(parts)


def compress(content: bytes) -> bytes:
    """Gzip, the same bytes for the same content at any time."""
    return gzip.compress(content, 6, mtime=0)


def write_whole(path: StrPath, write: Callable[[BinaryIO], object]) -> None:
    """Write a file whole or not at all: what was there stays until all is safely on the disk.

    Raises
    ------
    AraelError
        E0715 where the system refuses (no space, no permission, no such folder).
    """
    name = os.fspath(path)
    target = Path(os.path.realpath(path))
    temporary = None
    try:
        if target.exists() and not target.is_file():
            if target.is_dir():
                raise IsADirectoryError(errno.EISDIR, "is a directory")
            with open(target, "wb") as special:  # a pipe or a device cannot be replaced
                write(special)
            return
        mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else _default_mode()
        handle, temporary = tempfile.mkstemp(
            prefix=f".{target.name[:100]}.", suffix=".tmp", dir=target.parent
        )
        with os.fdopen(handle, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, mode)
        os.replace(temporary, target)
        temporary = None
        _sync_folder(target.parent)
    except OSError as failure:
        reason = (failure.strerror or str(failure)).lower()
        kept = "; the old file is as it was" if target.is_file() else ""
        raise error("E0715", f"cannot write the file: {reason}{kept}", name) from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)


def _default_mode() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _sync_folder(folder: Path) -> None:
    """Make the rename itself durable, where the system can."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
