"""Expressions from text, by the reader of formulas in models; units may follow literals."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from arael.diagnostics.records import AraelError, Diagnostic, Label, Source, Span
from arael.sketch.expressions.units import SPELLED, UNITS
from arael.syntax import tree
from arael.syntax.parser import parse_expression

MAX_LENGTH = 2000
"""Characters of an expression."""

_SHORT = 40
_LITERAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\Z", re.ASCII)
_WITH_UNIT = re.compile(
    r"(?<![\w.])((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)[ \t]*("
    + "|".join(sorted(SPELLED, key=len, reverse=True))
    + r")(?![\w.(])",
    re.ASCII,
)
_REWRITTEN = re.compile(_WITH_UNIT.pattern + r"|(?<![\w.)\]])\.(?=\d)", re.ASCII)


class Reference(NamedTuple):
    """A name that an expression reads, such as ``width`` or ``L0.p1.x``.

    Attributes
    ----------
    path : as it is written
    start, end : its place in the text of the expression
    """

    path: str
    start: int
    end: int


@dataclass(frozen=True, eq=False)
class Expression:
    """An expression that was read.

    Attributes
    ----------
    text : as it was written
    node : its tree; spans are places in `source`
    source : `text`
    references : names that it reads, in their order in the text
    """

    text: str
    node: tree.Expr
    source: Source
    references: tuple[Reference, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Paths of the references, each once."""
        return tuple(dict.fromkeys(one.path for one in self.references))


def literal(text: str) -> float | None:
    """The number that a text is, None if it is more than a number."""
    # Texts that are kept are short: those of files may be of any length.
    return _literal(text) if len(text) <= _SHORT else _literal.__wrapped__(text)


@lru_cache(maxsize=8192)
def _literal(text: str) -> float | None:
    return float(text) if _LITERAL.match(text) else None


@lru_cache(maxsize=8192)
def read(text: str) -> Expression:
    """Read an expression; nothing of it is ever run as code.

    Raises
    ------
    AraelError
        With the place in the text of what is wrong: the errors of formulas, and E1260 if it is too
        long.
    """
    source = Source("expression", text)
    if len(text) > MAX_LENGTH:
        raise AraelError(
            Diagnostic(
                "E1260",
                f"an expression of {len(text)} characters",
                Span(source, 0, MAX_LENGTH),
                f"at most {MAX_LENGTH} are read",
                help=("name parts of it by `param`",),
            )
        )
    written, origin = _with_brackets(text)
    read_from = Source("expression", written)
    try:
        node = parse_expression(read_from)
    except AraelError as error:
        raise moved(error, source, origin) from None
    node = _placed(node, source, origin) if written != text else _placed(node, source, None)
    return Expression(text, node, source, tuple(_references(node)))


def moved(error: AraelError, source: Source, origin: list[int] | int) -> AraelError:
    """The same error with places in another text.

    Parameters
    ----------
    origin : where each character comes from, or by how much all are shifted
    """

    def at(offset: int) -> int:
        if isinstance(origin, int):
            return min(offset + origin, len(source.text))
        return origin[min(offset, len(origin) - 1)]

    def span(old: Span) -> Span:
        return Span(source, at(old.start), at(old.end))

    def one(d: Diagnostic) -> Diagnostic:
        labels = tuple(Label(span(label.span), label.text) for label in d.labels)
        return replace(d, span=span(d.span) if d.span else None, labels=labels)

    return AraelError([one(d) for d in error.diagnostics])


def chain(node: tree.Binary) -> tuple[tree.Expr, list[tree.Binary]]:
    """``a + b - c`` as its first operand and the operations on it, first to last.

    Chains may be longer than Python's stack is deep; other nesting is bounded by the parser.
    """
    links: list[tree.Binary] = []
    inner: tree.Expr = node
    while isinstance(inner, tree.Binary):
        links.append(inner)
        inner = inner.left
    return inner, links[::-1]


def path_of(node: tree.Expr) -> str:
    """``L0.p1.x`` of a name or a chain of attributes, else empty."""
    parts: list[str] = []
    while isinstance(node, tree.Attribute):
        parts.append(node.name)
        node = node.obj
    if not isinstance(node, tree.Name):
        return ""
    return ".".join([node.id, *reversed(parts)])


def _with_brackets(text: str) -> tuple[str, list[int]]:
    """``12 mm`` as ``12[mm]``, ``.5`` as ``0.5``; and where each character comes from."""
    pieces: list[str] = []
    origin: list[int] = []
    at = 0

    def keep(upto: int) -> None:
        nonlocal at
        pieces.append(text[at:upto])
        origin.extend(range(at, upto))
        at = upto

    for found in _REWRITTEN.finditer(text):
        if found[1] is None:
            keep(found.start())
            pieces.append("0")
            origin.append(found.start())
            continue
        keep(found.start())
        if text[at] == ".":
            pieces.append("0")
            origin.append(at)
        keep(found.end(1))
        unit = f"[{SPELLED[found[2]]}]"
        pieces.append(unit)
        origin.extend([found.start(2)] * (len(unit) - 1) + [max(found.end(2) - 1, 0)])
        at = found.end()
    keep(len(text))
    origin.append(len(text))
    return "".join(pieces), origin


def _placed(node: tree.Expr, source: Source, origin: list[int] | None) -> tree.Expr:
    """The tree with places in `source`; anything that no expression of a sketch has is refused."""

    def span(old: Span) -> Span:
        if origin is None:
            return Span(source, old.start, old.end)
        return Span(source, origin[old.start], origin[old.end - 1] + 1)

    def place(node: tree.Expr) -> tree.Expr:
        here = span(node.span)
        if isinstance(node, tree.Number):
            if node.unit is not None and node.unit.text not in UNITS:
                raise _refused(here, f"unknown unit `{node.unit.text[:20]}`", "E1261", _UNIT_HELP)
            return replace(node, span=here)
        if isinstance(node, tree.Name):
            return replace(node, span=here)
        if isinstance(node, tree.Attribute):
            obj = place(node.obj)
            return replace(node, obj=obj, span=here, name_span=span(node.name_span))
        if isinstance(node, tree.Unary) and node.op != "not":
            return replace(node, operand=place(node.operand), span=here)
        if isinstance(node, tree.Binary):
            first, links = chain(node)
            placed = place(first)
            for link in links:
                if link.op not in _OPERATORS:
                    raise _refused(span(link.span), _WHAT, "E1254", _WHAT_HELP)
                right = place(link.right)
                placed = replace(link, left=placed, right=right, span=span(link.span))
            return placed
        if isinstance(node, tree.Conditional):
            parts = (place(node.cond), place(node.then), place(node.otherwise))
            return replace(node, cond=parts[0], then=parts[1], otherwise=parts[2], span=here)
        if isinstance(node, tree.Call) and isinstance(node.func, tree.Name):
            func = replace(node.func, span=span(node.func.span))
            return replace(node, func=func, args=tuple(map(place, node.args)), span=here)
        raise _refused(here, _WHAT, "E1254", _WHAT_HELP)

    return place(node)


_OPERATORS = {"+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!="}
_UNIT_HELP = "units are mm, cm, m, um, in, ft, deg, rad"
_WHAT = "not part of an expression of a sketch"
_WHAT_HELP = "it has numbers, names, + - * / ^, functions and `if a > b then x else y`"


def _refused(span: Span, message: str, code: str, help_: str) -> AraelError:
    return AraelError(Diagnostic(code, message, span, help=(help_,)))


def _references(node: tree.Expr) -> list[Reference]:
    """Names in a tree, in their order."""
    found: list[Reference] = []
    stack: list[tree.Expr] = [node]
    while stack:
        one = stack.pop()
        path = path_of(one)
        if path:
            found.append(Reference(path, one.span.start, one.span.end))
        elif isinstance(one, tree.Attribute):
            stack.append(one.obj)
        elif isinstance(one, tree.Unary):
            stack.append(one.operand)
        elif isinstance(one, tree.Binary):
            stack += [one.right, one.left]
        elif isinstance(one, tree.Conditional):
            stack += [one.otherwise, one.then, one.cond]
        elif isinstance(one, tree.Call):
            stack += reversed(one.args)
    return found
