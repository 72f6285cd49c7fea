"""Steps of undo, and parts of them, as contexts."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from arael.sketch.document.document import Document
    from arael.sketch.document.history import Transaction


class Transacting:
    """One step of undo; inside another one, a part of it. See `Document.transaction`.

    A class, since one made of a generator takes three times as long, and each edit has several.

    Parameters
    ----------
    document : whose changes it gathers
    label : the command, for the history
    """

    __slots__ = ("_document", "_label", "_made", "_since", "_whole")

    def __init__(self, document: Document, label: str) -> None:
        self._document, self._label = document, label

    def __enter__(self) -> Transaction:
        self._made, self._whole = self._document.begin(self._label)
        self._since = len(self._made.changes)
        return self._made

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        failed = kind is not None
        self._document.end(self._made, self._since, whole=self._whole, failed=failed)
