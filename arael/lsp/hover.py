"""What is shown of the word under the pointer."""

from __future__ import annotations

from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES
from arael.check.losses import LOSSES
from arael.diagnostics.records import Span
from arael.highlighting.keywords import KEYWORDS
from arael.lsp.document import Document
from arael.lsp.names import Symbol
from arael.operations import OPERATIONS

_VALUES = {"pi": "3.14159...", "e": "2.71828...", "epsilon": "2.220446049250313e-16"}


def hover(document: Document, offset: int, counted: dict[str, str]) -> tuple[str, Span] | None:
    """Markdown about the word at `offset`, and its place; None where there is nothing to say.

    Parameters
    ----------
    counted : operations of constraints by label (``Pose.gps``), as far as counted
    """
    i = document.token_at(offset)
    if i is None:
        return None
    token = document.tokens[i]
    span = Span(document.source, token.start, token.end)
    symbol = document.symbol_of(i)
    if symbol is not None:
        return _of_symbol(document, symbol, span, counted), span
    before = document.tokens[i - 1].type if i else ""
    if before == "DOT":
        text = _of_part(document, i)
    else:
        text = builtin(token.text) or _keyword(token.type, token.text)
    return (text, span) if text else None


def _of_symbol(document: Document, symbol: Symbol, span: Span, counted: dict[str, str]) -> str:
    lines = [f"```arael\n{symbol.text}\n```"]
    if symbol.owner and symbol.kind not in ("constraint", "fit", "prior"):
        lines.append(f"of `{symbol.owner}`")
    type_ = _type(document, symbol, span)
    if type_:
        lines.append(f"type `{type_}`")
    count = counted.get(f"{symbol.owner}.{symbol.name}")
    if symbol.kind in ("constraint", "fit", "prior") and count:
        lines.append(count)
    if symbol.doc:
        lines.append(symbol.doc)
    return "\n\n".join(lines)


def _type(document: Document, symbol: Symbol, span: Span) -> str:
    """Type of the value at `span`, or of the formula that `symbol` is declared with."""
    for place in (span, _path(document, span), symbol.value):
        if place is not None and place.source.name == document.source.name:
            found = document.type_at(place)
            if found:
                return found
    return ""


def _path(document: Document, span: Span) -> Span | None:
    """The expression ``a.b.c`` that ends with the word at `span`."""
    ends = [start for start, end in document.types if end == span.end and start < span.start]
    return Span(span.source, max(ends), span.end) if ends else None


def _of_part(document: Document, i: int) -> str:
    """A part of a value: ``pos.x``, or a method."""
    token = document.tokens[i]
    place = _path(document, Span(document.source, token.start, token.end))
    type_ = document.type_at(place) if place is not None else ""
    name = builtin(token.text) if token.text in FUNCTIONS else ""
    if type_ and not name:
        return f"```arael\n{place.text if place else token.text}\n```\n\ntype `{type_}`"
    return name


def builtin(name: str) -> str:
    """Markdown about a function, constant or loss of the language; "" for other names."""
    if name in _VALUES and name in CONSTANTS:
        return f"```arael\n{name} = {_VALUES[name]}\n```"
    if name in IDENTITIES:
        return f"```arael\n{name}: {IDENTITIES[name]}\n```"
    if name in FUNCTIONS:
        lines = [f"```arael\n{name}(...)\n```", f"takes {FUNCTIONS[name].takes}"]
        record = OPERATIONS.get(name)
        if record is not None:
            if record.value:
                lines.append(record.value)
            if record.derivative:
                lines.append(f"derivative: {record.derivative}")
            if record.domain is not None:
                lines.append(f"finite for {record.domain.text}")
        return "\n\n".join(lines)
    if name in LOSSES:
        return f"```arael\nloss {name}(scale)\n```\n\na robust loss of all residuals together"
    return ""


def _keyword(kind: str, text: str) -> str:
    known = kind != "NAME" and text in KEYWORDS
    return f"```arael\n{KEYWORDS[text]}\n```" if known else ""
