"""The file of a served sketch: its lock, its journal, when it is written."""

from __future__ import annotations

import time
from pathlib import Path

from filelock import FileLock, Timeout

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import why_read_only, write_whole
from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, load, to_json
from arael.sketch.server.differences import Difference
from arael.sketch.server.journal import Journal, fingerprint, replay

QUIET, MOST = 2.0, 20.0
"""Seconds after the last change, and after the first, until the file is written."""


class Keeper:
    """Keeps a sketch in a file so that no change that was acknowledged is lost.

    Parameters
    ----------
    path : of the file, ``.json``; it need not be there

    Attributes
    ----------
    document : as it was read, changes of the journal included
    recovered : how many changes of the journal
    read_only : why the file cannot be written, empty if it can: changes are not kept then
    due : when the file is to be written, by `time.monotonic`

    Raises
    ------
    AraelError
        E1210, E1211: it is no sketch; E1408: a journal that does not belong to it; E1410: another
        server has it; E0715: it cannot be written
    OSError
        If it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.read_only = why_read_only(path)
        self._lock: FileLock | None = None
        if self.read_only:  # no lock or journal beside it
            self._read()
            return
        self._lock = FileLock(str(path.with_name(f".{path.name}.lock")))
        try:
            self._lock.acquire(timeout=0)
        except Timeout:
            raise AraelError(
                Diagnostic(
                    "E1410",
                    "another server edits this file",
                    origin=str(path),
                    help=(
                        "open its address in another window, connect agents to it, or end it first",
                    ),
                )
            ) from None
        try:
            self._read()
        except BaseException:
            self._lock.release()
            raise

    def _read(self) -> None:
        path = self.path
        there = path.exists()
        self.document = load(path) if there else Document()
        base = fingerprint(path.read_bytes()) if there else ""
        self._journal = Journal(path.with_name(f"{path.name}.journal"), base)
        self._stamp = self._stamped()
        self._first = self._last = 0.0
        self.recovered = 0
        if self._journal.path.exists():
            self.recovered = replay(self._journal.path, base, self.document)
            from_json(to_json(self.document), str(self._journal.path))  # as strict as a file
            if self.recovered and not self.read_only:
                self._write(self.document)
            if not self.read_only:
                self._journal.path.unlink(missing_ok=True)

    # --- changes ------------------------------------------------------------------------------

    def note(self, title: str, change: Difference) -> str:
        """Put a change on disk; what went wrong, empty if nothing did."""
        if self.read_only:
            return ""
        self._last = time.monotonic()
        self._first = self._first or self._last
        try:
            self._journal.note(title, change)
        except OSError as error:
            self._first = self._last - MOST  # the file is written as soon as possible instead
            reason = (error.strerror or str(error)).lower()
            return f"the change is not on disk: {self._journal.path.name}: {reason}"
        return ""

    @property
    def is_due(self) -> bool:
        """Whether there is something to write."""
        return self._first > 0.0

    @property
    def due(self) -> float:
        """When the file is to be written."""
        return min(self._last + QUIET, self._first + MOST)

    def save(self, document: Document) -> str:
        """Write the file; what went wrong, empty if nothing did."""
        self._first = 0.0
        if self.read_only:
            return f"not saved: {self.read_only}; `save other.json` keeps this sketch"
        if self._stamped() != self._stamp:
            return (
                f"not saved: {self.path.name} was changed by another program; "
                "`save other.json` keeps this sketch"
            )
        try:
            self._write(document)
        except (AraelError, OSError) as error:
            self._first = self._last = time.monotonic()  # once more, later
            if isinstance(error, AraelError):
                return f"not saved: {error.diagnostics[0].message}"
            return f"not saved: {(error.strerror or str(error)).lower()}"
        return ""

    def _write(self, document: Document) -> None:
        data = to_json(document)
        base = fingerprint(data)
        if base != self._journal.base or not self.path.exists():
            self._journal.note_save(base)
            write_whole(self.path, lambda file: file.write(data))
        self._journal.clear(base)
        self._stamp = self._stamped()

    def _stamped(self) -> tuple[int, int]:
        """What changes when another program writes the file."""
        try:
            found = self.path.stat()
        except OSError:
            return 0, 0
        return found.st_mtime_ns, found.st_size

    def close(self, document: Document) -> str:
        """Write what is not written yet, and free the file."""
        problem = self.save(document) if self.is_due else ""
        self._journal.close()
        if self._lock is not None:
            self._lock.release()
        return problem
