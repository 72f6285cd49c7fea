"""The journal beside a file: every change since it was saved, each on disk before it is answered.

Lines of JSON. The first names the file's content by its hash, each other one is a change by names:
records, numbers of entities, settings. To make them again needs no solver and gives every bit.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint, Dimension, Entity, Group, Parameter
from arael.sketch.server.differences import Difference, make
from arael.sketch.server.records import plain

FORMAT = "arael-sketch-journal"
VERSION = 1

_TYPES: dict[str, Any] = {
    "entities": Entity,
    "constraints": Constraint,
    "dimensions": Dimension,
    "parameters": Parameter,
    "groups": Group,
}


def fingerprint(data: bytes) -> str:
    """Of the content of a file."""
    return hashlib.sha256(data).hexdigest()


class Journal:
    """Appends changes to a file, which begins with the first of them.

    Parameters
    ----------
    path : of the journal
    base : fingerprint of the sketch's file, empty if there is none
    """

    def __init__(self, path: Path, base: str) -> None:
        self.path = path
        self.base = base
        self._file: IO[bytes] | None = None
        self._size = 0
        self._is_broken = False

    def note(self, title: str, change: Difference) -> None:
        """Append a change; it is on disk when this returns.

        Raises
        ------
        OSError
            If it cannot be written. Then nothing is appended any more until the file is saved:
            later changes could not be made again without this one.
        """
        self._append(
            {
                "title": title,
                "settings": change.settings,
                "removed": change.removed,
                "put": {
                    table: [plain(one) for one in found] for table, found in change.put.items()
                },
                "order": change.order,
                "numbers": change.numbers,
            }
        )

    def note_save(self, base: str) -> None:
        """Append that the file is about to have another content."""
        if self._file is not None and not self._is_broken:
            self._append({"saved": base})

    def _append(self, entry: dict[str, Any]) -> None:
        if self._is_broken:
            raise OSError(errno.EIO, "an earlier change could not be written")
        try:
            if self._file is None:
                self._begin()
            self._write(entry)
        except OSError:
            self._is_broken = True
            if self._file is not None:
                with contextlib.suppress(OSError):  # what came half is ignored when it is read
                    self._file.truncate(self._size)
            raise

    def _begin(self) -> None:
        self._file = open(self.path, "wb", buffering=0)  # noqa: SIM115 - stays open
        self._write({"format": FORMAT, "version": VERSION, "base": self.base})
        _sync(self.path.parent)

    def _write(self, entry: dict[str, Any]) -> None:
        assert self._file is not None
        line = memoryview(msgspec.json.encode(entry) + b"\n")
        size = self._size + len(line)
        while line:
            line = line[self._file.write(line) :]
        os.fsync(self._file.fileno())
        self._size = size

    def clear(self, base: str) -> None:
        """Remove it: the file, whose content is now `base`, holds everything."""
        self.close()
        self.path.unlink(missing_ok=True)
        self.base = base

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
        self._size = 0
        self._is_broken = False


def replay(path: Path, base: str, document: Document) -> int:
    """Make the changes of a journal again, each as one step of undo.

    Parameters
    ----------
    base : fingerprint of the file from which `document` was read
    document : has no watchers yet; it is changed

    Returns
    -------
    How many changes were made.

    Raises
    ------
    AraelError
        E1408: the journal is of another file, or damaged elsewhere than at its end
    """
    parts = path.read_bytes().split(b"\n")
    complete = parts[:-1]  # a last line without its end was never acknowledged
    if not complete:
        return 0
    entries = [_decoded(path, number, line) for number, line in enumerate(complete, 1)]
    head, changes = entries[0], entries[1:]
    if head.get("format") != FORMAT or head.get("version") != VERSION:
        raise _unfit(path, "it is not a journal that this version of arael reads")
    saved = [k for k, one in enumerate(changes) if one.get("saved") == base]
    if saved:
        changes = changes[saved[-1] + 1 :]
    elif head.get("base") != base:
        raise _unfit(path, "the file is not the one that it goes on from: another program wrote it")
    changes = [one for one in changes if "saved" not in one]
    for number, one in enumerate(changes, 1):
        try:
            title = str(one["title"])
            make(document, _difference(one), title)
        except (KeyError, ValueError, TypeError, msgspec.MsgspecError, IndexError) as error:
            raise _unfit(path, f"change {number} cannot be made: {error}") from None
    return len(changes)


def _decoded(path: Path, number: int, line: bytes) -> dict[str, Any]:
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        raise _unfit(path, f"line {number} is damaged") from None


def _difference(entry: dict[str, Any]) -> Difference:
    put = {
        table: [_record(table, one) for one in records] for table, records in entry["put"].items()
    }
    numbers = {name: list(map(float, values)) for name, values in entry["numbers"].items()}
    return Difference(
        put,
        entry["removed"],
        entry["order"],
        numbers,
        np.zeros(0, dtype=np.int64),
        entry["settings"],
    )


def _record(table: str, plain_record: dict[str, Any]) -> Any:
    if table == "groups":
        options = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in plain_record["options"].items()
        }
        texts = {key: tuple(plain_record[key]) for key in ("sources", "results", "owned")}
        return Group(plain_record["name"], plain_record["kind"], **texts, options=options)
    return msgspec.convert(plain_record, _TYPES[table])


def _unfit(path: Path, reason: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1408",
            f"changes that were not saved cannot be taken up: {reason}",
            origin=str(path),
            help=(f"move `{path.name}` away to open the file without them",),
        )
    )


def _sync(folder: Path) -> None:
    """A new name in a folder onto the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError:  # not every file system has it
        pass
    finally:
        os.close(handle)
