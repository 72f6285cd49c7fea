"""One text: its findings, its tokens with their scopes, and the declarations of its model."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from arael.check.binding import Entity, OptionalValue, describe
from arael.check.check import check
from arael.check.typed import Typed
from arael.check.units import Unit
from arael.compiler.imports import Imports
from arael.diagnostics.records import AraelError, Diagnostic, Findings, Source, Span
from arael.lsp.names import Names, Symbol, names_of
from arael.lsp.outline import Scope, is_word, scopes_of
from arael.lsp.resolution import Resolver, chain_at
from arael.lsp.workspace import Workspace
from arael.syntax import tree
from arael.syntax.lexer import tokenise
from arael.syntax.log import ErrorLog
from arael.syntax.parser import parse
from arael.syntax.tokens import Token


@dataclass(frozen=True)
class Document:
    """What is known of a text.

    Attributes
    ----------
    tokens, scopes : its words, and where each is
    findings : errors and warnings, of its imports too
    names : declarations; those of the last complete text while there is a syntax error
    complete : whether the text has no syntax error
    types : type and unit of the expressions that were checked, by place
    """

    source: Source
    tokens: tuple[Token, ...]
    scopes: tuple[Scope, ...]
    findings: tuple[Diagnostic, ...]
    names: Names
    complete: bool
    types: dict[tuple[int, int], tuple[str, ...]] = field(default_factory=dict)

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """Findings that stop a compilation."""
        return tuple(d for d in self.findings if d.severity == "error")

    @cached_property
    def resolver(self) -> Resolver:
        """Finds the declarations of its words."""
        return Resolver(self.names, self.source)

    def token_at(self, offset: int) -> int | None:
        """Number of the word at `offset`, or that ends there."""
        i = self.before(offset)
        for at in (i, i - 1):
            if 0 <= at < len(self.tokens):
                token = self.tokens[at]
                if token.start <= offset <= token.end and is_word(token):
                    return at
        return None

    def before(self, offset: int) -> int:
        """Number of the last token that starts at `offset` or before it; -1 if there is none."""
        return bisect_right(self._starts, offset) - 1

    def symbol_at(self, offset: int) -> Symbol | None:
        """The declaration of the word at `offset`."""
        i = self.token_at(offset)
        return None if i is None else self.symbol_of(i)

    def symbol_of(self, i: int) -> Symbol | None:
        """The declaration of token `i`; a declared name means itself."""
        token = self.tokens[i]
        declared = self._declared.get((token.start, token.end))
        if declared is not None:
            return declared
        return self.resolver.resolve(chain_at(self.tokens, i), self.scopes[i])

    def type_at(self, span: Span) -> str:
        """Type and unit of the expression at `span`, as far as known."""
        return " | ".join(self.types.get((span.start, span.end), ()))

    @cached_property
    def _starts(self) -> list[int]:
        return [token.start for token in self.tokens]

    @cached_property
    def _declared(self) -> dict[tuple[int, int], Symbol]:
        if not self.complete:
            return {}
        return {
            (s.span.start, s.span.end): s
            for s in self.names.symbols()
            if s.span.source.name == self.source.name and s.kind not in ("fit", "prior")
        }


def analyse(source: Source, workspace: Workspace, before: Document | None = None) -> Document:
    """Read and check a text; `before` is the document of the text before the last change."""
    log = ErrorLog(source)
    try:
        tokens = tuple(tokenise(source, log).tokens)
    except AraelError:
        tokens = ()
    scopes = tuple(scopes_of(tokens))
    try:
        file = parse(source)
    except AraelError as error:
        names = before.names if before is not None else Names()
        return Document(source, tokens, scopes, error.diagnostics, names, False)
    types: dict[tuple[int, int], tuple[str, ...]] = {}

    def observe(node: tree.Expr, found: Any, unit: Any) -> None:
        text = _described(found, unit)
        if node.span.source.name == source.name and text:
            key = (node.span.start, node.span.end)
            known = types.get(key, ())
            if text not in known and len(known) < 3:
                types[key] = (*known, text)

    imports = Imports(workspace.read)
    read: dict[str, tree.File] = {}

    def load(item: tree.Import) -> tree.File:
        loaded = imports(item)
        read[loaded.source.name] = loaded
        return loaded

    findings = Findings()
    found: tuple[Diagnostic, ...]
    try:
        check(file, load=load, findings=findings, observe=observe)
        found = tuple(findings)
    except AraelError as error:
        found = error.diagnostics
    if not any(isinstance(item, tree.Struct) and item.kind == "root" for item in file.items):
        found = tuple(d for d in found if d.code != "E0211")  # a file that others import
    names = names_of((file, *read.values()))
    return Document(source, tokens, scopes, found, names, True, types)


def _described(found: Any, unit: Any) -> str:
    if isinstance(found, Typed):
        text = str(found.type)
        units = dict.fromkeys(unit if isinstance(unit, tuple) else (unit,))
        named = [str(u) for u in units if isinstance(u, Unit) and not u.is_one]
        return f"{text} [{', '.join(named)}]" if len(named) == len(units) else text
    if isinstance(found, OptionalValue):
        return found.field.text
    if isinstance(found, Entity):
        return describe(found)
    return ""
