"""Files that a model imports: in which folders they may be, and how many there may be.

A model may be untrusted, and errors in a file are shown with its text. So imports can only read
models in the folder of the model or below it, and those of the library that comes with arael.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path, PurePosixPath

from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.syntax.files import read_source
from arael.syntax.parser import parse
from arael.syntax.tree import File, Import

LIBRARY = Path(__file__).parents[1] / "library"
"""Files that any model may import by name, unless there is one of that name beside it."""

MAX_FILES = 64
"""Files of one model."""

MAX_CHARACTERS = 4 << 20
"""Characters of all files of one model together."""


class Imports:
    """Reads the files that a model imports, each once; `read` gives the text of a file.

    Attributes
    ----------
    texts : text of each file by its path
    read : each name under which a file was imported, and its text as it was read
    """

    def __init__(self, read: Callable[[Path], Source] = read_source) -> None:
        self._read = read
        self.texts: dict[Path, str] = {}
        self.read: dict[str, Source] = {}
        self._files: dict[Path, File] = {}
        self._folder: Path | None = None

    def __call__(self, item: Import) -> File:
        """Give the file that an import names.

        Raises
        ------
        AraelError
            E0220 for a path that leads out of the folder of the model, which is the file with the
            first import, E0221 where the model has too many files; and what is wrong with the file.
        """
        if self._folder is None:
            self._folder = Path(item.span.source.name).parent
        path, real = _within(item, self._folder)
        file = self._files.get(real)
        if file is not None:
            self.read.setdefault(str(path), file.source)
            return file
        if len(self._files) >= MAX_FILES:
            raise _too_large(item, f"more than {MAX_FILES} files")
        try:
            source = self._read(path)
        except AraelError as error:
            at = f"imported by {item.span}"
            raise AraelError(replace(d, notes=(*d.notes, at)) for d in error.diagnostics) from None
        self.texts[real] = source.text
        self.read[str(path)] = source
        if sum(map(len, self.texts.values())) > MAX_CHARACTERS:
            raise _too_large(item, f"more than {MAX_CHARACTERS >> 20} MiB of text")
        self._files[real] = parse(source)
        return self._files[real]


def _within(item: Import, folder: Path) -> tuple[Path, Path]:
    """The path that an import means, as written and resolved, if it may be read."""
    written = item.path.value
    beside = Path(item.span.source.name).parent
    name = PurePosixPath(written)
    if name.is_absolute() or re.search(r"[\\:\0]", written) or written.startswith("~"):
        raise _outside(item, "an import is relative to the file that it stands in, with `/`")
    if name.suffix != ".arael":
        raise _outside(item, "an import names a model: a file that ends in `.arael`")
    path = beside / name
    if len(name.parts) == 1 and not path.exists() and (LIBRARY / name).is_file():
        return LIBRARY / name, (LIBRARY / name).resolve()
    try:
        real = path.resolve()
        inside = real.is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # RuntimeError: a circle of links, before Python 3.13
        raise _outside(item, "this is a link that leads to itself") from None
    if not inside:
        lexical = Path(os.path.abspath(path))
        leaves = not lexical.is_relative_to(os.path.abspath(folder))
        raise _outside(
            item,
            "`..` leaves the folder of the model" if leaves else "this is a link to somewhere else",
        )
    return path, real


def _outside(item: Import, why: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0220",
            f"cannot import {item.path.value!r}: only files in the folder of the model or below it",
            item.path.span,
            why,
            help=("move or copy the file beside the model, and import it by its name",),
        )
    )


def _too_large(item: Import, what: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0221",
            "the model has too many files or too much text",
            item.path.span,
            what,
            help=("a model holds no data; join small files, drop imports that are not used",),
        )
    )
