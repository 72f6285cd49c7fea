"""Undo and redo: transactions of changes, each with what was before and after."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from arael.sketch.document.document import Document
    from arael.sketch.document.records import Record


@dataclass(frozen=True, slots=True)
class RecordChange:
    """A record put in (`old` None), replaced, or taken out (`new` None).

    `order` are the table's keys while the record is in it, where its place is not the end: before
    a removal, so that undo puts it back in its place, or after it was put in.
    """

    table: str
    key: str
    old: Record | None
    new: Record | None
    order: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class ValuesChange:
    """Numbers of the document at some offsets."""

    offsets: NDArray[np.int64]
    old: NDArray[np.float64]
    new: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SizeChange:
    """Numbers in use."""

    old: int
    new: int


@dataclass(frozen=True, slots=True)
class SettingChange:
    """A counter of names (``counter:L``), or a setting such as the unit."""

    key: str
    old: Any
    new: Any


Change = RecordChange | ValuesChange | SizeChange | SettingChange


@dataclass(slots=True)
class Transaction:
    """What one command changed.

    Attributes
    ----------
    label : the command, for `history`
    changes : in the order they were made
    """

    label: str
    changes: list[Change] = field(default_factory=list)

    def merge_last(self, since: int) -> None:
        """Make one change of the last two, if both change the numbers at the same offsets.

        A drag of hundreds of frames would keep the numbers of each otherwise.

        Parameters
        ----------
        since : changes before this one stay as they are: a part that is taken back ends there
        """
        if len(self.changes) - since < 2:
            return
        first, last = self.changes[-2:]
        if (
            isinstance(first, ValuesChange)
            and isinstance(last, ValuesChange)
            and first.offsets.tobytes() == last.offsets.tobytes()
        ):
            self.changes[-2:] = [ValuesChange(first.offsets, first.old, last.new)]


class History:
    """Transactions that were made, and those that were undone."""

    def __init__(self) -> None:
        self.done: list[Transaction] = []
        self.undone: list[Transaction] = []

    def add(self, transaction: Transaction) -> None:
        """A new transaction; what was undone cannot be redone any more."""
        self.done.append(transaction)
        self.undone.clear()

    @property
    def labels(self) -> list[str]:
        """Labels of all transactions, those that can be redone after those done."""
        return [one.label for one in [*self.done, *reversed(self.undone)]]

    @property
    def position(self) -> int:
        """How many transactions are done."""
        return len(self.done)

    def undo(self, document: Document) -> Transaction | None:
        """Take the last transaction back; None if there is none."""
        if not self.done:
            return None
        transaction = self.done.pop()
        for change in reversed(transaction.changes):
            document.apply(change, backwards=True)
        self.undone.append(transaction)
        return transaction

    def redo(self, document: Document) -> Transaction | None:
        """Make the last transaction that was undone again; None if there is none."""
        if not self.undone:
            return None
        transaction = self.undone.pop()
        for change in transaction.changes:
            document.apply(change)
        self.done.append(transaction)
        return transaction
