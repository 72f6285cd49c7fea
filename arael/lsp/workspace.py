"""The texts of the files of a model: of open files what the editor holds, of others the disk's."""

from __future__ import annotations

from pathlib import Path

from arael.diagnostics.records import AraelError, Source
from arael.syntax.files import read_source

MAX_NEIGHBOURS = 500
"""Files of a folder that are searched for uses of what a file declares."""


class Workspace:
    """Open texts by path, before the files on the disk."""

    def __init__(self) -> None:
        self.open: dict[Path, str] = {}

    def read(self, path: Path) -> Source:
        """The text of a file.

        Raises
        ------
        AraelError
            As `read_source`, for a file that is not open.
        """
        text = self.open.get(path.resolve())
        return read_source(path) if text is None else Source(str(path), text)

    def neighbours(self, path: Path) -> list[Source]:
        """The other models in the folder of `path` and below it, and the open ones."""
        own = path.resolve()
        folder = own.parent
        try:
            found = sorted(folder.rglob("*.arael"))[:MAX_NEIGHBOURS]
        except OSError:
            found = []
        paths = {p.resolve() for p in found} | set(self.open)
        sources = []
        for one in sorted(paths - {own}):
            try:
                sources.append(self.read(one))
            except AraelError:
                continue
        return sources
