"""Sources of the page without comments and needless white space, semicolons, parentheses and zeros.

Declarations one after the other become one: ``const a=1,b=2``. Nothing is renamed and no line is
moved: what follows from line ends (automatic semicolons) stays, and the names of a stack trace are
those of the source.
"""

from __future__ import annotations

import re

_SPACE = r"(?P<space>(?:\s|//[^\n]*|/\*[\s\S]*?\*/)+)"
_STRING = r"""(?P<string>"(?:\\[\s\S]|[^"\\\n])*"|'(?:\\[\s\S]|[^'\\\n])*')"""
_SCRIPT = re.compile(rf"{_SPACE}|{_STRING}|(?P<word>[\w$#]+)|(?P<mark>[\s\S])")
_REGEX = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/\w*")
_SHARE = re.compile(r"0\.\d")
_TEXT = re.compile(r"(?:\\[\s\S]|\$(?!\{)|[^`\\$])*(?:`|\$\{)")
"""The rest of a template up to its end or the next expression in it."""
_STYLE = re.compile(rf"(?P<space>(?:\s|/\*[\s\S]*?\*/)+)|{_STRING}|(?P<mark>[\s\S])")

#: Words after which a slash begins a regular expression: no value ends with them.
_BEFORE_VALUE = frozenset(
    {"return", "typeof", "case", "in", "of", "delete", "void", "throw", "new", "else", "do"}
    | {"await", "yield", "instanceof"}
)
#: Words whose parentheses may be followed by nothing but a semicolon; ``for await (``.
_HEADS = frozenset({"if", "for", "while", "with", "await"})
_DECLARING = frozenset({"const", "let"})
#: Signs that would be other ones side by side.
_APART = frozenset({"++", "--", "//", "/*", "<!", "->"})


def compact_script(text: str) -> str:
    """A module of JavaScript, shorter and with the same meaning.

    A slash after ``)``, ``]`` or ``}`` is taken as a division.
    """
    pieces: list[str] = []
    gap = ""
    nesting: list[int] = []  # braces that are open in each expression of a template
    heads: list[bool] = []  # parentheses that are open: whether of a statement
    declarations = _Declarations()
    is_head = is_empty = False  # of the last parenthesis; whether a semicolon is a statement itself
    at, last, is_value = 0, "", False
    while at < len(text):
        found = _SCRIPT.match(text, at)
        assert found is not None
        piece, kind = found.group(), found.lastgroup
        if kind == "space":
            gap = "\n" if "\n" in piece else " "
            at = found.end()
            continue
        if piece == "0" and _SHARE.match(text, at):  # .5
            at += 1
            continue
        if piece == "/" and not is_value:
            regex = _REGEX.match(text, at)
            piece, kind = (regex.group(), "regex") if regex else (piece, kind)
        elif piece == "`" or (piece == "}" and nesting and nesting[-1] == 0):
            if piece == "}":
                nesting.pop()
            rest = _TEXT.match(text, at + 1)
            assert rest is not None, "a template without an end"
            piece, kind = piece + rest.group(), "template"
            if piece.endswith("${"):
                nesting.append(0)
        elif nesting and piece in "{}":
            nesting[-1] += 1 if piece == "{" else -1
        if declarations.go_on(piece, kind == "template"):
            pieces[-1] = last = ","
            gap, is_value, at = "", False, at + len(piece)
            continue
        if piece == "(":
            heads.append(last in _HEADS)
        elif piece == ")":
            is_head = bool(heads) and heads.pop()
        elif piece == ";":
            is_empty = (last == ")" and is_head) or last in ("else", "do")
        elif text.startswith("=>", at):
            _unwrap(pieces)
        if piece == "}" and last == ";" and not is_empty:
            pieces.pop()
        elif gap and pieces and (between := _between(gap, last, piece)):
            pieces.append(between)
        gap = ""
        pieces.append(piece)
        at += len(piece)
        last = piece
        is_value = (
            piece not in _BEFORE_VALUE
            if kind == "word"
            else kind in ("string", "regex")
            or (kind == "template" and piece.endswith("`"))
            or piece in (")", "]", "}")
        )
    return "".join(pieces) + "\n"


class _Declarations:
    """Where ``const`` or ``let`` follows a declaration of its own kind."""

    def __init__(self) -> None:
        # of each bracket that is open: the first token of its statement, empty before it
        self._firsts = [""]
        self._ended = ""

    def go_on(self, piece: str, is_text: bool) -> bool:
        """Whether the next token may be a comma in place of the semicolon before it.

        Parameters
        ----------
        is_text : whether it is a part of a template
        """
        firsts, ended = self._firsts, self._ended
        first = firsts[-1]
        firsts[-1], self._ended = first or piece, ""
        if piece in (")", "]", "}") or (is_text and piece[0] == "}"):
            firsts.pop()
            if piece == "}" and firsts[-1] not in _DECLARING:
                firsts[-1] = ""
        if piece in ("(", "[", "{") or (is_text and piece.endswith("${")):
            firsts.append("" if piece == "{" else piece)
        elif piece == ";" and first not in ("(", "["):
            firsts[-1], self._ended = "", first if first in _DECLARING else ""
        return piece == ended


def _unwrap(pieces: list[str]) -> None:
    """Take the parentheses of the one parameter of a function with an arrow away."""
    match pieces:
        case [*_, "(", name, ")"] if _is_word(name[-1]):
            del pieces[-1]
            if len(pieces) > 2 and _is_word(pieces[-3][-1]):  # async
                pieces[-2] = " "
            else:
                del pieces[-2]


def _between(gap: str, before: str, after: str) -> str:
    """White space that has to stay between two tokens."""
    a, b = before[-1], after[0]
    if gap == "\n":
        return "" if a in "{([,;" or b in "})]" else "\n"
    joins = (_is_word(a) and _is_word(b)) or a + b in _APART or (a.isdigit() and b == ".")
    regexes = before[0] == "/" and len(before) > 1 and _is_word(b)
    return " " if joins or regexes else ""


def _is_word(sign: str) -> bool:
    return sign.isalnum() or sign in "_$#\\"


def compact_style(text: str) -> str:
    """A style sheet, shorter and with the same meaning."""
    pieces: list[str] = []
    for found in _STYLE.finditer(text):
        piece = found.group()
        if found.lastgroup == "space":
            if pieces and pieces[-1] not in ("{", "}", ";", ",", ":"):
                pieces.append(" ")
            continue
        if piece in ("{", "}", ";") and pieces and pieces[-1] == " ":
            pieces.pop()
        if piece == "}" and pieces and pieces[-1] == ";":
            pieces.pop()
        pieces.append(piece)
    return "".join(pieces).strip() + "\n"
