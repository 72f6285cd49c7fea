"""Base of all builders."""

from __future__ import annotations

from arael.diagnostics.records import Source
from arael.syntax.docs import DocComments
from arael.syntax.log import ErrorLog


class Builder:
    """Holds the text, its documentation comments, and the error log."""

    def __init__(self, source: Source, docs: DocComments, log: ErrorLog) -> None:
        self._source = source
        self._docs = docs
        self._log = log
