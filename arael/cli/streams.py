"""Standard streams that are closed, full, or in an encoding that lacks a character."""

from __future__ import annotations

import codecs
import contextlib
import errno
import io
import os
import sys

_UNWRITABLE = {
    getattr(errno, name)
    for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO", "EBADF", "EPIPE", "ENXIO")
    if hasattr(errno, name)
}


def prepare() -> None:
    r"""Make standard streams usable if they are closed or have a limited encoding.

    A closed stream is redirected to the null device, so that no file that is opened later gets its
    descriptor and receives the output. Characters that the encoding lacks (in the C locale, all but
    ASCII) are written as escapes, and so are undecodable bytes of file names (``\xff``).
    """
    codecs.register_error("arael.escape", _escape)
    with contextlib.suppress(OSError):
        while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(handle)
    if sys.stdin is None:
        sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = _Closed()
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="arael.escape")


class _Closed(io.StringIO):
    """A closed standard output: output is lost, which `lost` reports at the end."""

    def write(self, text: str) -> int:
        self.lost = True
        return len(text)

    lost = False


def output_was_lost() -> bool:
    """Whether something was printed on a closed standard output."""
    return isinstance(sys.stdout, _Closed) and sys.stdout.lost


def is_unwritable(error: BaseException) -> bool:
    """Whether an error says that a standard stream cannot be written, not a named file."""
    return isinstance(error, OSError) and error.filename is None and error.errno in _UNWRITABLE


def give_up(error: OSError) -> None:
    """Report that the output cannot be written, if possible; nothing is flushed afterwards."""
    _discard(sys.stdout)
    reason = (error.strerror or str(error)).lower()
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write(f"error: cannot write the output: {reason}\n")
        sys.stderr.flush()
        return
    _discard(sys.stderr)


def _discard(stream: object) -> None:
    """Point a stream to the null device, so that flushing it at exit cannot fail."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())  # type: ignore[attr-defined]
        os.close(null)


def _escape(error: UnicodeError) -> tuple[bytes, int]:
    assert isinstance(error, UnicodeEncodeError)
    found = b""
    for character in error.object[error.start : error.end]:
        code = ord(character)
        if 0xDC80 <= code <= 0xDCFF:  # an undecodable byte of a file name
            found += b"\\x%02x" % (code - 0xDC00)
        else:
            found += character.encode("ascii", "backslashreplace")
    return found, error.end
