"""Reading and writing by the suffix of a file's name."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal, cast

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.io.files import read_bytes, write_whole
from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, to_json
from arael.sketch.drawing import Theme
from arael.sketch.exchange.imported import Imported
from arael.sketch.exchange.problems import MAX_BYTES
from arael.sketch.exchange.sheet import Sheet, to_sheet

StrPath = str | os.PathLike[str]

WRITERS = (".dxf", ".svg", ".pdf", ".png", ".step", ".stp", ".json")
PICTURES = (".pdf", ".png")
READERS = (".dxf", ".svg", ".json")


def write(
    document: Document,
    path: StrPath,
    *,
    theme: Theme = "light",
    sheet: Sheet | None = None,
    title: str = "",
    date: str = "",
) -> None:
    """Write a sketch, whole or not at all, in the format of the suffix.

    ``.dxf`` keeps everything: it is read back as the same sketch. ``.svg`` is the geometry to scale
    in millimetres, ``.pdf`` the drawing with dimensions, at full size or on a sheet, ``.png`` a
    picture of it,
    ``.step`` faces of closed chains and wires of others, ``.json`` the document.

    Parameters
    ----------
    document
        The sketch.
    path
        Name of the file; an existing one is replaced.
    theme
        ``light`` or ``dark``, of PDF and PNG.
    sheet
        ``A4`` to ``A1``, of PDF and PNG: at a scale of ISO 5455, with a frame and a title block.
    title, date
        In the title block; by default the file's name without suffix, and no date.

    Raises
    ------
    AraelError
        E1301: another suffix; E1305: an optional library is missing; E1307: nothing to write.
    OSError
        If the file cannot be written.
    """
    suffix = _suffix(path, WRITERS, "written")
    if suffix in PICTURES:
        kind = cast("Literal['png', 'pdf']", suffix[1:])
        name = title or Path(path).stem
        data = to_sheet(document, kind, theme, sheet=sheet, title=name, date=date)
    else:
        data = _content(document, suffix)
    write_whole(path, lambda file: file.write(data))


def _content(document: Document, suffix: str) -> bytes:
    if suffix == ".json":
        return to_json(document)
    if suffix == ".svg":
        # imported here: start-up time
        from arael.sketch.exchange.svg.writer import to_svg

        return to_svg(document).encode("utf-8")
    if suffix == ".dxf":
        # imported here: start-up time
        from arael.sketch.exchange.dxf.writer import to_dxf

        return to_dxf(document)
    # imported here: start-up time
    from arael.sketch.exchange.step import to_step

    return to_step(document)


def read(path: StrPath, *, tolerance: float | None = None) -> Document | Imported:
    """Read a file: a sketch of ours as it was written, anything else as geometry.

    Parameters
    ----------
    path
        A ``.dxf``, ``.svg`` or ``.json`` file.
    tolerance
        Distance within which constraints are recognised; by default 1e-5 of the drawing.

    Returns
    -------
    Document or Imported
        A `Document` of JSON, and of DXF that was written by `write` and not changed since;
        otherwise geometry with suggested constraints.

    Raises
    ------
    AraelError
        E1301: another suffix; E1302: damaged, or not of this format; E1303: too large, too deeply
        nested; E1210, E1211 of JSON; E0711 and others if the file cannot be read.
    """
    suffix = _suffix(path, READERS, "read")
    data = read_bytes(path, MAX_BYTES)
    origin = str(Path(path))
    if suffix == ".json":
        return from_json(data, origin)
    if suffix == ".svg":
        # imported here: start-up time
        from arael.sketch.exchange.svg.reader import from_svg

        return from_svg(data, origin, tolerance)
    # imported here: start-up time
    from arael.sketch.exchange.dxf.reader import from_dxf

    return from_dxf(data, origin, tolerance)


def _suffix(path: StrPath, known: tuple[str, ...], done: str) -> str:
    suffix = Path(path).suffix.lower()
    if suffix in known:
        return suffix
    near = closest(suffix, known)
    hint = f"did you mean `{near[0]}`?" if near and suffix else f"use {', '.join(known)}"
    raise AraelError(
        Diagnostic(
            "E1301",
            f"`{suffix or Path(path).name}` is not a format that is {done}",
            origin=str(Path(path)),
            help=(hint,),
        )
    )
