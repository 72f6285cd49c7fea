"""Drawings for the shop as PDF and PNG: what is to be made, without the marks of the editor.

Sizes, margins and scales of a sheet are those of ISO 5457 and ISO 5455; the title block follows
ISO 7200 in its width.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, get_args

from arael.sketch.document.document import Document
from arael.sketch.drawing import Theme, View, bounds_of_document, layout, to_image
from arael.sketch.drawing.primitives import Item, Layout, Path, Text, polyline
from arael.sketch.drawing.texts import number_text
from arael.sketch.exchange.units import MILLIMETRES

Sheet = Literal["A4", "A3", "A2", "A1"]
SHEETS: tuple[str, ...] = get_args(Sheet)
_SIZES = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "A2": (594.0, 420.0), "A1": (841.0, 594.0)}
"""Long and short side, millimetres."""

_LARGEST = 4000.0
_PER_MM = 96.0 / 25.4
_MARGIN = 70.0
_LEFT, _EDGE = 20.0, 10.0
"""Millimetres between the edges of a sheet and its frame: at the left, where it is filed; else."""
_ROOM = 19.0
"""Millimetres around the geometry for its dimensions."""
_BLOCK = (180.0, 18.0)
"""Width and height of the title block."""


def to_sheet(
    document: Document,
    kind: Literal["png", "pdf"],
    theme: Theme = "light",
    *,
    sheet: Sheet | None = None,
    title: str = "",
    date: str = "",
) -> bytes:
    """A drawing with dimensions: no badges, points or poles, and no marks of expressions.

    Parameters
    ----------
    sheet
        Size of the paper. The drawing is then at the largest scale of ISO 5455 that fits, on the
        sheet upright or across, with a frame and a title block. Without it a PDF is at full size
        as long as it is between 5 cm and 1 m; otherwise, and as a PNG, it is scaled to fit.
    title, date
        What the title block says beside unit and scale.
    """
    if sheet is not None:
        return to_image(on_sheet(document, sheet, title, date), kind, theme)
    box = bounds_of_document(document)
    if kind == "pdf" and box is not None:
        scale = _PER_MM * MILLIMETRES[document.unit]
        width = scale * (box.x_max - box.x_min) + 2 * _MARGIN
        height = scale * (box.y_max - box.y_min) + 2 * _MARGIN
        if 200.0 <= max(width, height) <= _LARGEST:
            x, y = _MARGIN - scale * box.x_min, height - _MARGIN + scale * box.y_min
            return to_image(_drawn(document, View(scale, x, y, width, height)), kind, theme)
    return to_image(_drawn(document, None), kind, theme)


def _drawn(document: Document, view: View | None, scale_bar: bool = True) -> Layout:
    return layout(
        document, view=view, width=1000, height=700, glyphs=False, points=False, formulas=False,
        scale_bar=scale_bar,
    )  # fmt: skip


def on_sheet(document: Document, sheet: Sheet, title: str = "", date: str = "") -> Layout:
    """The drawing in the middle of what frame and title block leave; parameters as `to_sheet`."""
    box = bounds_of_document(document)
    long, short = _SIZES[sheet]
    unit = MILLIMETRES[document.unit]
    wide = unit * (box.x_max - box.x_min) if box else 0.0
    high = unit * (box.y_max - box.y_min) if box else 0.0
    choices = [(_scale_of(wide, high, w, h), w, h) for w, h in ((long, short), (short, long))]
    ratio, width, height = max(choices, key=lambda choice: choice[0])  # across, if both are equal
    scale = _PER_MM * unit * ratio
    # The middle of what is left for the drawing, millimetres from the upper left corner.
    x = 0.5 * (_LEFT + width - _EDGE)
    y = 0.5 * (_EDGE + height - _EDGE - _BLOCK[1])
    across, up = (
        (0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max)) if box else (0.0, 0.0)
    )
    view = View(
        scale, _PER_MM * x - scale * across, _PER_MM * y + scale * up,
        _PER_MM * width, _PER_MM * height,
    )  # fmt: skip
    drawing = _drawn(document, view, scale_bar=False)
    fields = (
        ("Title", title, 80.0),
        ("Unit", document.unit, 20.0),
        ("Scale", scale_text(ratio), 40.0),
        ("Date", date, 40.0),
    )
    items = (*drawing.items, *_frame(width, height, fields))
    return Layout(drawing.width, drawing.height, items, drawing.title)


def _scale_of(wide: float, high: float, width: float, height: float) -> float:
    """The largest scale of ISO 5455 at which a drawing fits a sheet of a width and height."""
    across = width - _LEFT - _EDGE - 2 * _ROOM
    up = height - 2 * _EDGE - _BLOCK[1] - 2 * _ROOM
    most = min(across / wide if wide > 0 else 1e9, up / high if high > 0 else 1e9)
    if most > 1e8:  # nothing that has a size
        return 1.0
    ratios = (part * 10.0**power for power in range(9, -13, -1) for part in (5, 2, 1))
    return next((ratio for ratio in ratios if ratio <= most * (1 + 1e-9)), 1e-12)


def scale_text(ratio: float) -> str:
    """``2:1``, ``1:50``."""
    if ratio >= 1:
        return f"{number_text(ratio)}:1"
    return f"1:{number_text(1 / ratio)}"


def _frame(
    width: float, height: float, fields: tuple[tuple[str, str, float], ...]
) -> Iterator[Item]:
    """Frame of the sheet, and the title block in its lower right corner."""

    def box(x1: float, y1: float, x2: float, y2: float, line: float) -> Path:
        a, b, c, d = (_PER_MM * v for v in (x1, y1, x2, y2))
        return Path("defined", polyline((a, b), (c, b), (c, d), (a, d), close=True), line)

    right, low = width - _EDGE, height - _EDGE
    yield box(_LEFT, _EDGE, right, low, 2.6)
    x, top = right - _BLOCK[0], low - _BLOCK[1]
    for label, value, wide in fields:
        yield box(x, top, x + wide, low, 1.3)
        yield Text("note", _PER_MM * (x + 1.5), _PER_MM * (top + 3.5), label, 9.0, 0.0, "start")
        size = min(16.0, 1.7 * _PER_MM * (wide - 3) / max(len(value), 1))
        if value:
            at = _PER_MM * (x + 1.5), _PER_MM * (top + 11.5)
            yield Text("defined", *at, value, size, 0.0, "start")
        x += wide
