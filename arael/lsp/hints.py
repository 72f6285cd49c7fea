"""Types and units that are shown within the text, behind the names that are declared without."""

from __future__ import annotations

from dataclasses import dataclass

from arael.diagnostics.records import Span
from arael.lsp.document import Document


@dataclass(frozen=True)
class Hint:
    """A text to show at `offset`."""

    offset: int
    text: str


def hints(document: Document, start: int, end: int) -> list[Hint]:
    """Type and unit of each `let` and formula that is declared between two offsets."""
    found = []
    for i, token in enumerate(document.tokens):
        if not start <= token.start < end or i == 0:
            continue
        if document.tokens[i - 1].type not in ("LET", "CONST", "SYMBOLIC", "COMPUTE"):
            continue
        symbol = document.symbol_of(i)
        if symbol is None or symbol.value is None:
            continue
        type_ = document.type_at(Span(document.source, symbol.value.start, symbol.value.end))
        if type_:
            found.append(Hint(token.end, f": {type_}"))
    return found
