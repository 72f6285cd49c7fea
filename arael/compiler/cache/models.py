"""Layout of a model and key of its kernels, by the key of the model's text.

An entry contains no path. Places are stored as file number, line and column; the files' names are
inserted when the entry is used, so that messages name the user's file.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import msgspec

from arael.compiler.cache.keys import FORMAT, digest
from arael.compiler.cache.trust import directory, is_trusted, prepare, replace, unwritable
from arael.compiler.cache.warnings import StoredWarning, rendered
from arael.diagnostics.records import AraelError, Source
from arael.runtime.layout import Layout
from arael.runtime.relocation import attached
from arael.syntax.files import read_source

# Models of a process whose layouts are kept; an entry has some tens of kilobytes.
_RECENT = 16


class Known(msgspec.Struct, frozen=True):
    """What is stored of a model's text.

    Attributes
    ----------
    code : digest of the generated code (`keys.code_digest`); "" where none was generated
    imports : SHA-256 of the text of each imported file, by its name relative to the model's folder
    warnings : as they are to be repeated
    layout : without places of this machine, see `arael.runtime.relocation`
    """

    format: int
    code: str
    imports: dict[str, str]
    warnings: tuple[StoredWarning, ...]
    layout: Layout


@dataclass(frozen=True)
class Found:
    """A model that was found: its layout with the places of the file at hand."""

    layout: Layout
    code: str


def encode(record: Known) -> bytes:
    """An entry as a file: the SHA-256 of the JSON that follows it."""
    body = msgspec.json.encode(record)
    return digest(body).encode() + b"\n" + body


def decode(data: bytes) -> Known:
    """Read what `encode` wrote.

    Raises
    ------
    ValueError
        It is damaged, or of another version.
    """
    written, _, body = data.partition(b"\n")
    if written != digest(body).encode():
        raise ValueError("damaged")
    record = msgspec.json.decode(body, type=Known)
    if record.format != FORMAT:
        raise ValueError("another version")
    return record


def find(key: str, source: Source) -> Found | None:
    """Find the text of `source`, if its entry is trusted, unchanged and up to date."""
    path = directory() / "arael-models" / f"{key}.json"
    if not is_trusted(path):
        return None
    record = read(path, source)
    if record is not None:
        with contextlib.suppress(OSError):
            os.utime(path)  # used: see `upkeep.trim`
    return record


def read(path: Path, source: Source) -> Found | None:
    """Read the entry at `path` for the model in `source`; None if it does not hold (any more)."""
    try:
        data = path.read_bytes()
        record = _decoded(data)
    except (OSError, ValueError):
        return None
    sources = _imported(record, source)
    if sources is None:
        return None
    names = [s.name for s in sources]
    warnings = rendered(record.warnings, sources)
    return Found(_attached(data, tuple(names), warnings), record.code)


@lru_cache(maxsize=_RECENT)
def _decoded(data: bytes) -> Known:
    return decode(data)


@lru_cache(maxsize=_RECENT)
def _attached(data: bytes, names: tuple[str, ...], warnings: tuple[str, ...]) -> Layout:
    """The layout of an entry with the places of files at hand.

    One object for a model that is loaded again, so that what follows from a layout is computed
    once.
    """
    return attached(_decoded(data).layout, list(names), warnings)


def _imported(record: Known, source: Source) -> list[Source] | None:
    """The model's file and those it imports; None if one of them has changed."""
    sources = [source]
    if record.imports:
        folder = Path(source.name).parent
        for name, expected in record.imports.items():
            try:
                imported = read_source(folder / name)
            except AraelError:
                return None
            if digest(imported.text.encode()) != expected:
                return None
            sources.append(imported)
    return sources


def relative_names(sources: Sequence[Source]) -> list[str]:
    """Names of files relative to the folder of the first: the model's own file is ""."""
    folder = os.path.dirname(sources[0].name)
    others = (os.path.relpath(s.name, folder or ".") for s in sources[1:])
    return ["", *(name.replace(os.sep, "/") for name in others)]


def store(key: str, record: Known) -> None:
    """Keep an entry.

    Raises
    ------
    AraelError
        E0804 the cache cannot be written, E0805 others could write it.
    """
    folder = prepare("arael-models")
    try:
        replace(folder / f"{key}.json", encode(record))
    except OSError as error:
        raise unwritable(error) from error
