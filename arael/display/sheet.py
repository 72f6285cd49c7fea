"""A table with title and notes, independent of where it is shown."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Group


@dataclass(frozen=True)
class Sheet:
    """A titled table with notes below it.

    Attributes
    ----------
    title : a line of text
    head : names of the columns; columns of numbers are aligned right
    rows : cells as text
    notes : lines below the table
    """

    title: str
    head: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = field(default=())

    def html(self) -> str:
        """HTML without scripts or style sheets; all text is escaped."""
        parts = [f"<div><b>{escape(self.title)}</b>"]
        if self.rows:
            sides = [f' style="text-align:{side}"' for side in self._sides()]

            def cells(tag: str, row: Sequence[str]) -> str:
                pairs = zip(row, sides, strict=True)
                return "".join(f"<{tag}{side}>{escape(text)}</{tag}>" for text, side in pairs)

            head = cells("th", self.head)
            body = "".join(f"<tr>{cells('td', row)}</tr>" for row in self.rows)
            parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")
        parts += [f"<div>{escape(note)}</div>" for note in self.notes]
        return "".join(parts) + "</div>"

    def rich(self) -> Group:
        """A renderable for `rich.print`."""
        # imported here: start-up time
        from rich.box import SIMPLE_HEAD
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        parts: list[Text | Table] = [Text(self.title, style="bold")]
        if self.rows:
            table = Table(box=SIMPLE_HEAD, pad_edge=False)
            for name, side in zip(self.head, self._sides(), strict=True):
                table.add_column(Text(name), justify=side)
            for row in self.rows:
                table.add_row(*map(Text, row))
            parts.append(table)
        return Group(*parts, *(Text(note, style="dim") for note in self.notes))

    def _sides(self) -> list[Literal["left", "right"]]:
        """Alignment of each column."""
        columns = zip(*self.rows, strict=True)
        return ["right" if all(map(_is_number, cells)) else "left" for cells in columns]


def _is_number(cell: str) -> bool:
    """Whether a cell has a number, is empty, or stands for rows that are left out."""
    return re.match(r"[+-]?(\d|\.\d|inf|nan)", cell) is not None or cell in ("", "...")
