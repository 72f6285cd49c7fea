"""Where each word of a text is: in which struct, body or function, from its tokens alone.

Nothing here needs a text that can be parsed: the tokens before the word suffice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS, Token

Where = Literal["file", "members", "type", "clauses", "body", "solve", "pass", "update", "formula"]


@dataclass(frozen=True)
class Local:
    """A name of a body: a `let`, the element of a `fit` or of a sum, an argument.

    `chain` is the path that a `let` or an element stands for, empty where it is a value; `value`
    the tokens of its formula.
    """

    kind: Literal["let", "element", "argument"]
    token: Token
    chain: tuple[str, ...] = ()
    value: tuple[int, int] = (0, 0)  # offsets of the formula


@dataclass(frozen=True)
class Scope:
    """The surroundings of a token.

    Attributes
    ----------
    struct : name of the struct that it is in, "" outside of structs
    member : name of the constraint, or of the function outside of structs
    names : names of the body declared before it
    """

    where: Where = "file"
    struct: str = ""
    member: str = ""
    names: tuple[Local, ...] = ()


@dataclass
class _Frame:
    """An open brace."""

    where: Where
    struct: str = ""
    member: str = ""
    names: tuple[Local, ...] = ()


_BLOCKS: dict[str, Where] = {"SOLVE": "solve", "PASS": "pass", "UPDATE": "update"}
_OPEN_ENDS = frozenset(("EQUAL", "COMMA", "PLUS", "MINUS", "STAR", "SLASH", "CARET"))
_HEADER_PARTS = frozenset(("LBRACE", "WHEN", "LOSS", "INTO", "DERIVS"))


def is_word(token: Token) -> bool:
    """Whether a token is a name or a word that may be one."""
    return token.text.isidentifier()


def scopes_of(tokens: Sequence[Token]) -> list[Scope]:
    """The scope of each token, in one pass."""
    outline = _Outline(tokens)
    return [outline.step(i) for i in range(len(tokens))]


class _Outline:
    """The pass over the tokens: the open braces, and the statement that is being read."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens = tokens
        self.frames = [_Frame("file")]
        self._begin(0)

    def _begin(self, start: int) -> None:
        self.start = start
        self.brackets = 0
        self.colon = self.equal = False
        self.own: tuple[Local, ...] = ()  # names that the statement declares for itself
        self.let: tuple[Local, ...] = ()  # name that it declares for the statements after it

    def step(self, i: int) -> Scope:
        """The scope of token `i`; then go on to the next."""
        token, frame = self.tokens[i], self.frames[-1]
        self._declare(i)
        here = self._scope(frame)
        if i and self.tokens[i - 1].type == "LET" and is_word(token):
            self.let = self._let(i)
            here = replace(here, names=(*here.names, *self.let))
        kind = token.type
        if kind == "LBRACE":
            self.frames.append(self._opened(frame))
            self._begin(i + 1)
        elif kind == "RBRACE":
            if len(self.frames) > 1:
                self.frames.pop()
            self._begin(i + 1)
        elif kind in ("LPAR", "LSQB"):
            self.brackets += 1
        elif kind in ("RPAR", "RSQB"):
            self.brackets = max(0, self.brackets - 1)
        elif kind in (NEWLINE, "SEMICOLON") and self.brackets == 0 and self._ends(i):
            if frame.where == "body":
                frame.names = (*frame.names, *self.let)
            self._begin(i + 1)
        self.colon |= kind == "COLON" and self.brackets == 0
        self.equal |= kind == "EQUAL"
        return here

    @property
    def head(self) -> str:
        """Type of the first token of the statement."""
        return self.tokens[self.start].type if self.start < len(self.tokens) else ""

    def _ends(self, i: int) -> bool:
        """Whether the line end at `i` ends a statement; a header may have several lines."""
        before = self.tokens[i - 1].type if i else ""
        after = self.tokens[i + 1].type if i + 1 < len(self.tokens) else ""
        return before not in _OPEN_ENDS and after not in _HEADER_PARTS

    def _declare(self, i: int) -> None:
        """Note the names that the statement declares at token `i`."""
        tokens, token = self.tokens, self.tokens[i]
        before = tokens[i - 1] if i > self.start else None
        if not is_word(token) or before is None:
            return
        file = len(self.frames) == 1
        if file and self.head in ("FN", "EXTERN") and self.brackets and not self.equal:
            self.own = (*self.own, Local("argument", token))
        elif self.head == "FIT" and before.text == "as":
            self.own = (*self.own, Local("element", token, self._chain(self.start + 1)))
        elif before.type == "LPAR" and i > 1 and tokens[i - 2].text == "sum":
            names = [i]
            if i + 2 < len(tokens) and tokens[i + 1].type == "COMMA":
                names.append(i + 2)
            after = names[-1] + 1
            if after < len(tokens) and tokens[after].type == "IN":
                for at in names:
                    chain = self._chain(after + 1) if at == names[-1] else ()
                    self.own = (*self.own, Local("element", tokens[at], chain))

    def _chain(self, at: int) -> tuple[str, ...]:
        """The path ``a.b.c`` that begins at token `at`."""
        names: list[str] = []
        while at < len(self.tokens) and is_word(self.tokens[at]):
            names.append(self.tokens[at].text)
            if at + 1 >= len(self.tokens) or self.tokens[at + 1].type != "DOT":
                break
            at += 2
        return tuple(names)

    def _name(self) -> str:
        """The name after the head of the statement."""
        at = self.start + 1 + (self.head == "EXTERN")
        known = at < len(self.tokens) and is_word(self.tokens[at])
        return self.tokens[at].text if known else ""

    def _scope(self, frame: _Frame) -> Scope:
        head, names = self.head, (*frame.names, *self.own)
        if frame.where == "file":
            if head in ("FN", "EXTERN"):
                return Scope("formula", "", self._name(), names)
            return Scope("formula" if head == "CONST" else "file")
        if frame.where != "members":
            return Scope(frame.where, frame.struct, frame.member, names)
        if head in ("CONSTRAINT", "REQUIRE", "FIT", "PRIOR"):
            member = self._name() if head in ("CONSTRAINT", "REQUIRE") else ""
            return Scope("clauses", frame.struct, member, names)
        if head in ("SYMBOLIC", "COMPUTE") or self.equal:
            return Scope("formula", frame.struct)
        return Scope("type" if self.colon else "members", frame.struct)

    def _opened(self, frame: _Frame) -> _Frame:
        """The frame that a brace opens in the statement that is being read."""
        head, names = self.head, (*frame.names, *self.own)
        if head in ("STRUCT", "ROOT", "COMPONENT"):
            return _Frame("members", self._name())
        if head in ("CONSTRAINT", "REQUIRE", "FIT"):
            return _Frame("body", frame.struct, self._name() * (head != "FIT"), names)
        if head in _BLOCKS:
            return _Frame(_BLOCKS[head], frame.struct, self._name(), names)
        return _Frame("body", frame.struct, frame.member, names)  # within a formula, as of a sum

    def _let(self, i: int) -> tuple[Local, ...]:
        """The name at token `i` of ``let name = value``."""
        first, depth = i + 2, 0
        for at in range(first, len(self.tokens)):
            kind = self.tokens[at].type
            depth += (kind in OPENERS) - (kind in CLOSERS)
            ends = kind in (NEWLINE, "SEMICOLON") and depth == 0 and self._ends(at)
            if ends or depth < 0 or at == len(self.tokens) - 1:
                value = self.tokens[first:at]
                break
        else:
            value = self.tokens[:0]
        if not value:
            return (Local("let", self.tokens[i]),)
        path = all(t.type == "DOT" or is_word(t) for t in value)
        chain = self._chain(first) if path else ()
        return (Local("let", self.tokens[i], chain, (value[0].start, value[-1].end)),)
