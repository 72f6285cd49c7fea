"""Uses of a declaration, and its new name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from arael.check.builtins import BUILTIN_NAMES
from arael.check.types import TYPE_NAMES
from arael.diagnostics.records import Source, Span
from arael.highlighting.keywords import KEYWORDS
from arael.lsp.document import Document, analyse
from arael.lsp.names import Symbol
from arael.lsp.workspace import Workspace
from arael.syntax.limits import MAX_NAME


class Refused(Exception):
    """A new name that is not possible; the text says why."""


RENAMEABLE = {
    "struct", "component", "root", "param", "field", "formula", "constraint", "pass", "const",
    "function", "argument", "let", "element",
}  # fmt: skip


def uses(document: Document, symbol: Symbol, workspace: Workspace) -> list[Span]:
    """Every place where `symbol` is named, in this file and the others of its folder.

    The declaration is one of them.
    """
    found = list(_in(document, symbol))
    if symbol.kind not in ("argument", "let", "element"):
        for source in workspace.neighbours(Path(document.source.name)):
            found += _in(analyse(source, workspace), symbol)
    return found


def _in(document: Document, symbol: Symbol) -> Iterator[Span]:
    file, at = symbol.span.source.name, symbol.span.start
    real = Path(file).resolve()
    for i, token in enumerate(document.tokens):
        if token.text != symbol.name and not _names_entity(token.text, symbol):
            continue
        found = document.symbol_of(i)
        if found is None or found.span.start != at:
            continue
        if token.text in ("self", "parent", "root"):
            continue
        if found.span.source.name == file or Path(found.span.source.name).resolve() == real:
            yield Span(document.source, token.start, token.end)


def _names_entity(word: str, symbol: Symbol) -> bool:
    """Whether a constraint calls the row of a struct by this word: ``pose`` of ``Pose``."""
    return symbol.kind in ("struct", "root", "component") and word == symbol.name.lower()


def rename(
    document: Document, offset: int, new: str, workspace: Workspace
) -> dict[str, list[tuple[Span, str]]]:
    """The edits that give the declaration at `offset` the name `new`, by file.

    Raises
    ------
    Refused
        Where the new name is not possible, with the reason of the checker.
    """
    symbol = document.symbol_at(offset)
    if symbol is None or symbol.kind not in RENAMEABLE:
        raise Refused("this is not a name that the model declares")
    if document.errors:
        first = document.errors[0]
        raise Refused(f"the model has an error: {first.message}")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", new) or len(new) > MAX_NAME:
        raise Refused(f"`{new}` is not a name")
    if new in KEYWORDS or new in BUILTIN_NAMES or new in TYPE_NAMES:
        raise Refused(f"`{new}` belongs to the language")
    edits: dict[str, list[tuple[Span, str]]] = {}
    for span in uses(document, symbol, workspace):
        text = new if span.text == symbol.name else new.lower()
        edits.setdefault(span.source.name, []).append((span, text))
    _try(document, edits, workspace)
    return edits


def _try(
    document: Document, edits: dict[str, list[tuple[Span, str]]], workspace: Workspace
) -> None:
    """Check the files with the edits made; what each word means must not change.

    Raises
    ------
    Refused
        With the first error, or where a word would then mean another declaration.
    """
    changed = Workspace()
    changed.open = dict(workspace.open)
    sources = {}
    for name, own in edits.items():
        text = edited(own[0][0].source.text, own)
        changed.open[Path(name).resolve()] = text
        sources[name] = Source(name, text)
    for name, source in sources.items():
        after = analyse(source, changed)
        before = document
        if name != document.source.name:
            before = analyse(edits[name][0][0].source, workspace)
        if after.errors and not before.errors:
            raise Refused(after.errors[0].message)
        if _meanings(before) != _meanings(after):
            raise Refused("another declaration has this name")


def _meanings(document: Document) -> list[int | None]:
    """For each word the number of the word that declares it, -1 for one of another file."""
    at = {token.start: i for i, token in enumerate(document.tokens)}
    own = document.source.name
    found: list[int | None] = []
    for i, token in enumerate(document.tokens):
        symbol = document.symbol_of(i) if token.text.isidentifier() else None
        if symbol is None:
            found.append(None)
        else:
            found.append(at.get(symbol.span.start, -1) if symbol.span.source.name == own else -1)
    return found


def edited(text: str, edits: list[tuple[Span, str]]) -> str:
    """`text` with spans replaced."""
    for span, new in sorted(edits, key=lambda e: e[0].start, reverse=True):
        text = text[: span.start] + new + text[span.end :]
    return text
