"""Model files from disk."""

from __future__ import annotations

import codecs
import os
import stat
from pathlib import Path

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.diagnostics.suggest import closest
from arael.syntax.limits import MAX_BYTES


def read_source(path: str | os.PathLike[str]) -> Source:
    """Read the text of a model file without a byte order mark.

    Raises
    ------
    AraelError
        If there is no such file (with similar names in that folder), or if it cannot be read, is
        not text, is too large, or is empty.
    """
    name = os.fspath(path)
    return source_of(_read_bytes(name), name)


def source_of(data: bytes, name: str) -> Source:
    """Text of a model from its bytes; `name` is its name in messages.

    Raises
    ------
    AraelError
        E0103 if it is not text, with the place of the first byte that is not UTF-8; E0104 if it is
        too large; E0107 if it is empty.
    """
    if len(data) > MAX_BYTES:
        raise _error(
            "E0104",
            f"this file is larger than {MAX_BYTES >> 10} KiB",
            name,
            "a model contains no data; split a long model with `import`",
        )
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise _error("E0103", "this file is UTF-16, not UTF-8", name, "save it as UTF-8")
    zero = data.find(b"\0")
    if zero >= 0:
        raise _error(
            "E0103",
            f"this is not a text file: byte {zero} is zero",
            name,
            "a model is a text file that ends in .arael",
        )
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        source = Source(name, data.decode("utf-8", "replace"))
        at = len(data[: error.start].decode("utf-8"))
        byte = data[error.start]
        surrogate = byte == 0xED and data[error.start + 1 : error.start + 2] >= b"\xa0"
        raise AraelError(
            Diagnostic(
                "E0103",
                f"this file is not UTF-8: byte 0x{byte:02x} in line {source.position(at)[0]}",
                Span(source, at, at + 1),
                "an unpaired surrogate" if surrogate else "not a character in UTF-8",
                help=("save the file as UTF-8",),
            )
        ) from None
    source = Source(name, text)
    if not any(line.strip() and not line.lstrip().startswith("#") for line in text.splitlines()):
        raise AraelError(
            Diagnostic(
                "E0107",
                "there is no model in this file",
                Span(source, 0, 0) if text.strip() else None,
                "only comments" if text.strip() else "",
                origin=name,
                help=("a model has at least a root: `root Name { ... }`",),
            )
        )
    return source


def _read_bytes(name: str) -> bytes:
    try:
        mode = os.stat(name).st_mode
        if stat.S_ISDIR(mode):
            raise _error("E0102", "this is a folder, not a model file", name, _models_in(name))
        if not stat.S_ISREG(mode):
            raise _error("E0102", "this is not an ordinary file", name, "")
        with open(name, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise _error("E0101", "there is no such file", name, _similar(name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise _error("E0102", f"this file cannot be read: {reason.lower()}", name, "") from None
    return data


def _error(code: str, message: str, name: str, help_: str) -> AraelError:
    return AraelError(Diagnostic(code, message, origin=name, help=(help_,) if help_ else ()))


def _similar(name: str) -> str:
    path = Path(name)
    try:
        present = [entry.name for entry in os.scandir(path.parent)]
    except OSError:
        return f"there is no folder `{path.parent}` either" if path.parent != Path() else ""
    found = closest(path.name, sorted(present))
    found = found or [n for n in (path.name + ".arael",) if n in present]
    return f"did you mean `{path.parent / found[0]}`?" if found else ""


def _models_in(name: str) -> str:
    try:
        models = sorted(e.name for e in os.scandir(name) if e.name.endswith(".arael"))
    except OSError:
        return ""
    return f"did you mean `{Path(name) / models[0]}`?" if models else ""
