"""Files as bytes: reading with a size limit, atomic writing."""

from __future__ import annotations

import codecs
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
from arael.runtime.store.messages import describe, error

# Default limit for the size of one file, after decompression.
DEFAULT_LIMIT = 2 * 1024**3
CHUNK = 1024**2

StrPath = str | os.PathLike[str]

UTF8_MARK = codecs.BOM_UTF8
WIDE_MARKS = {codecs.BOM_UTF16_LE: "UTF-16", codecs.BOM_UTF16_BE: "UTF-16"}


def shown(path: StrPath) -> str:
    r"""The name of a file for messages; bytes that are invalid in UTF-8 as ``\xff``."""
    name = os.fsdecode(path)
    try:
        return name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    except UnicodeEncodeError:
        return name.encode("utf-8", "backslashreplace").decode()


def check_name(path: object) -> str:
    """Return the name of a file as text; E0712 for an invalid one."""
    if not isinstance(path, str | bytes | os.PathLike):
        raise error("E0712", f"expected the name of a file, found {describe(path)}", "path")
    name = os.fsdecode(path)
    try:
        good = b"\0" not in os.fsencode(name)
    except UnicodeEncodeError:
        good = False
    if not good:
        raise error("E0712", "the system has no file of this name", shown(name))
    return name


def without_mark(content: bytes, name: str) -> bytes:
    """Return text without the byte-order mark of UTF-8; E0711 for UTF-16."""
    if content[:2] in WIDE_MARKS:
        raise error(
            "E0711",
            f"the text is {WIDE_MARKS[content[:2]]}, not UTF-8",
            name,
            help="save the file as UTF-8",
        )
    return content.removeprefix(UTF8_MARK)


def read_bytes(path: StrPath, limit: int = DEFAULT_LIMIT) -> bytes:
    """Content of a file, decompressed if gzipped.

    Raises
    ------
    AraelError
        E0712 missing, a directory, unreadable, empty or invalid gzip; E0714 over the limit.
    """
    name = shown(path)
    check_readable(path)
    try:
        with open(path, "rb") as file:
            content = _read_up_to(file, limit + 1)
    except OSError as failure:
        raise unreadable(name, failure) from None
    if not content:
        raise error("E0712", "the file is empty", name)
    if len(content) > limit:
        raise too_large(name, limit)
    if content[:2] == b"\x1f\x8b":
        return _gunzip(content, name, limit)
    return content


def _read_up_to(file: BinaryIO, most: int) -> bytes:
    """Up to `most` bytes of a file; memory is allocated for the content, not for `most`."""
    size = os.fstat(file.fileno()).st_size  # 0 for a pipe
    parts = [file.read(min(size + 1, most))]
    left = most - len(parts[0])
    while parts[-1] and left:
        parts.append(file.read(min(CHUNK, left)))
        left -= len(parts[-1])
    return b"".join(part for part in parts if part)


def check_readable(path: StrPath) -> None:
    """Raise E0712 for a missing file or a directory."""
    name = shown(path)
    if os.path.isdir(path):
        raise error("E0712", "expected a file, found a directory", name)
    if not os.path.exists(path):
        raise error("E0712", "no such file", name)


def unreadable(name: str, failure: OSError) -> AraelError:
    """E0712 with the reason given by the system."""
    reason = failure.strerror or str(failure)
    return error("E0712", f"cannot read the file: {reason.lower()}", name)


def too_large(name: str, limit: int) -> AraelError:
    """E0714."""
    return error(
        "E0714",
        f"the content is larger than {limit} bytes",
        name,
        help="raise `limit` if the file is valid",
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
    """Gzip with reproducible output."""
    return gzip.compress(content, 6, mtime=0)


def why_read_only(path: StrPath) -> str:
    """Why a file must not be written or replaced; empty if it may be.

    A rename needs only a folder that is writable, and the administrator may write everything: so
    the permissions of the file itself are looked at, and whether some user has them.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not _has_write_permission(target):
        return "the file is read-only"
    if target.parent.is_dir() and not _has_write_permission(target.parent):
        return "the folder is read-only"
    return ""


def _has_write_permission(path: Path) -> bool:
    return bool(path.stat().st_mode & 0o222) and os.access(path, os.W_OK)


def write_whole(path: StrPath, write: Callable[[BinaryIO], object]) -> None:
    """Write a file atomically: the old file stays until the new content is safely on disk.

    Raises
    ------
    AraelError
        E0715 on a system error (no space, no permission, no such folder), and for a file that is
        read-only, though it could be replaced.
    """
    name = shown(path)
    target = Path(os.path.realpath(path))
    temporary = None
    try:
        if target.exists() and not target.is_file():
            if target.is_dir():
                raise IsADirectoryError(errno.EISDIR, "is a directory")
            with open(target, "wb") as special:  # a pipe or a device cannot be replaced
                write(special)
            return
        reason = why_read_only(target)
        if reason:
            raise PermissionError(errno.EACCES, reason)
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
        kept = "; the old file is unchanged" if target.is_file() else ""
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
    """Make the rename durable, if the system supports it."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
