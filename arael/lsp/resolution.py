"""Which declaration a word of a text means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from arael.diagnostics.records import Source, Span
from arael.lsp.names import Names, StructNames, Symbol
from arael.lsp.outline import Local, Scope, is_word
from arael.syntax.tokens import Token

_MAX_LETS = 20  # `let` of a `let` of a `let`


@dataclass(frozen=True)
class Chain:
    """The path ``a.b.c`` up to a word, with the place of the first part among the tokens.

    `open` : it begins with a value, as ``f(x).norm``: its parts are no declarations.
    """

    parts: tuple[str, ...]
    first: int
    open: bool = False


def chain_at(tokens: Sequence[Token], i: int) -> Chain:
    """The path that ends with token `i`; indices ``a[0].b`` are passed over."""
    parts = [tokens[i].text]
    at = i
    while at >= 2 and tokens[at - 1].type == "DOT":
        before = at - 2
        if tokens[before].type == "RSQB":
            before = _opening(tokens, before) - 1
        if before < 0 or not is_word(tokens[before]):
            return Chain(tuple(parts), at, open=True)
        parts.insert(0, tokens[before].text)
        at = before
    return Chain(tuple(parts), at)


def _opening(tokens: Sequence[Token], at: int) -> int:
    depth = 0
    while at >= 0:
        depth += {"RSQB": 1, "LSQB": -1}.get(tokens[at].type, 0)
        if depth == 0:
            return at
        at -= 1
    return -1


class Resolver:
    """Finds declarations by the language's rules, in the names of a model."""

    def __init__(self, names: Names, source: Source) -> None:
        self.names = names
        self.source = source

    def resolve(self, chain: Chain, scope: Scope) -> Symbol | None:
        """The declaration of the last part of `chain`; None for parts of values and built-ins."""
        found = None if chain.open else self._path(chain.parts, scope, _MAX_LETS)
        if found is not None and found.name in ("self", "parent", "root"):
            return None
        return found

    def struct_of(self, chain: Sequence[str], scope: Scope) -> StructNames | None:
        """The struct that the path `chain` leads to."""
        found = self._path(tuple(chain), scope, _MAX_LETS)
        return self.names.structs.get(found.struct) if found is not None else None

    def visible(self, scope: Scope) -> Iterator[Symbol]:
        """What a bare name may mean in `scope`."""
        for local in reversed(scope.names):
            yield self._local(local, scope, _MAX_LETS)
        own = self.names.structs.get(scope.struct)
        if own is not None:
            yield from own.members.values()
        yield from self.names.consts.values()
        yield from self.names.functions.values()

    def _path(self, parts: tuple[str, ...], scope: Scope, lets: int) -> Symbol | None:
        here = self._first(parts[0], scope, lets)
        for part in parts[1:]:
            if here is None:
                return None
            here = self._part(here, part)
        return here

    def _first(self, name: str, scope: Scope, lets: int) -> Symbol | None:
        for local in reversed(scope.names):
            if local.token.text == name:
                return self._local(local, scope, lets)
        names = self.names
        own, root = names.structs.get(scope.struct), names.root
        if scope.where == "pass":
            own = root
        if own is not None:
            if name in own.members:
                return own.members[name]
            if name in ("self", own.symbol.name.lower()):
                return self._entity(own, name)
            if name == "parent":
                return self._owner(own, "")
        if root is not None and name in ("root", root.symbol.name.lower()):
            return self._entity(root, name)
        for table in (names.consts, names.functions):
            if name in table:
                return table[name]
        struct = names.structs.get(name)
        return struct.symbol if struct is not None else None

    def _part(self, here: Symbol, part: str) -> Symbol | None:
        struct = self.names.structs.get(here.struct)
        if struct is None:
            return None
        if part == "parent":
            return self._owner(struct, "")
        return struct.members.get(part)

    def _owner(self, struct: StructNames, part: str) -> Symbol | None:
        owners = self.names.owners(struct.symbol.name)
        return self._entity(owners[0], "parent") if owners else None

    def _entity(self, struct: StructNames, name: str) -> Symbol:
        symbol = struct.symbol
        return Symbol(
            symbol.kind, name, symbol.span, "", symbol.text, symbol.doc, struct=symbol.name
        )

    def _local(self, local: Local, scope: Scope, lets: int) -> Symbol:
        span = Span(self.source, local.token.start, local.token.end)
        name, struct = local.token.text, ""
        if local.chain and lets:
            outer = Scope(
                scope.where,
                scope.struct,
                scope.member,
                scope.names[: scope.names.index(local)] if local in scope.names else (),
            )
            target = self._path(local.chain, outer, lets - 1)
            struct = target.struct if target is not None else ""
        value = Span(self.source, *local.value) if local.value[1] else None
        text = f"let {name} = {' '.join(value.text.split())}" if value else name
        if local.kind == "element":
            text = f"{name}: element of {'.'.join(local.chain)}" if local.chain else name
        elif local.kind == "argument":
            text = f"argument of {scope.member}"
        return Symbol(local.kind, name, span, "", text, struct=struct, value=value)
