"""What all builders share."""

from __future__ import annotations

from arael.diagnostics.records import Source
from arael.syntax.docs import DocComments
from arael.syntax.log import ErrorLog


class Builder:
    """Knows the text, its documentation comments, and where to report to."""

    def __init__(self, source: Source, docs: DocComments, log: ErrorLog) -> None:
        self._source = source
        self._docs = docs
        self._log = log
