"""A table with title and notes, independent of where it is shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Group


@dataclass(frozen=True)
class Sheet:
    """A titled table with notes below it.

    Attributes
    ----------
    title : a line of text
    head : names of the columns; the columns after the first are aligned right
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
            head = "".join(
                f"<th{_align(k)}>{escape(name)}</th>" for k, name in enumerate(self.head)
            )
            body = "".join(
                "<tr>"
                + "".join(f"<td{_align(k)}>{escape(cell)}</td>" for k, cell in enumerate(row))
                + "</tr>"
                for row in self.rows
            )
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
            for k, name in enumerate(self.head):
                table.add_column(Text(name), justify="right" if k else "left")
            for row in self.rows:
                table.add_row(*map(Text, row))
            parts.append(table)
        return Group(*parts, *(Text(note, style="dim") for note in self.notes))


def _align(column: int) -> str:
    return ' style="text-align:right"' if column else ' style="text-align:left"'
