"""Sources of the page without comments and needless white space, signs and zeros.

``true``, ``false`` and ``undefined`` become ``!0``, ``!1`` and ``void 0``. Declarations one after
the other become one: ``const a=1,b=2``. Nothing is renamed, so that the names of a stack trace are
those of the source. Line ends from which something may follow (automatic semicolons) stay: all but
those beside brackets and signs between two values, and after commas, semicolons and blocks.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

_SPACE = r"(?P<space>(?:\s|//[^\n]*|/\*[\s\S]*?\*/)+)"
_STRING = r"""(?P<string>"(?:\\[\s\S]|[^"\\\n])*"|'(?:\\[\s\S]|[^'\\\n])*')"""
_SCRIPT = re.compile(rf"{_SPACE}|{_STRING}|(?P<word>[\w$#]+)|(?P<mark>[\s\S])")
_REGEX = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/\w*")
_SHARE = re.compile(r"0\.\d")
_TEXT = re.compile(r"(?:\\[\s\S]|\$(?!\{)|[^`\\$])*(?:`|\$\{)")
"""The rest of a template up to its end or the next expression in it."""
_STYLE = re.compile(rf"(?P<space>(?:\s|/\*[\s\S]*?\*/)+)|{_STRING}|(?P<mark>[\s\S])")

_NAME = re.compile(r"\s*(?:[.(\[`]|\*\*)")
"""After a word that is a name, or whose value is asked for something."""
_KEY = re.compile(r"\s*[:}]")
"""After a name in an object: a value follows, or it stands for itself."""
_SHORTER = {"true": "!0", "false": "!1", "undefined": "void 0"}

#: Words after which a slash begins a regular expression: no value ends with them.
_BEFORE_VALUE = frozenset(
    {"return", "typeof", "case", "in", "of", "delete", "void", "throw", "new", "else", "do"}
    | {"await", "yield", "instanceof"}
)
#: Words whose parentheses may be followed by nothing but a semicolon; ``for await (``.
_HEADS = frozenset({"if", "for", "while", "with", "await"})
_DECLARING = frozenset({"const", "let"})
#: Words with which a statement begins whose parentheses are followed by a block; before a block.
_OPENING, _BARE = (
    frozenset({"function", "switch", "catch"}),
    frozenset({"else", "do", "try", "finally"}),
)
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
    declarations, blocks = _Declarations(), _Blocks()
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
        if piece in _SHORTER and last != "." and not _NAME.match(text, found.end()):
            is_key = last in ("{", ",") and _KEY.match(text, found.end())
            shorter = piece if is_key else _SHORTER[piece]
            at += len(piece) - len(shorter)
            piece = shorter
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
        if blocks.go_on(piece, last, is_head, kind == "template"):
            gap = ""
        ends = piece in (")", "]", "}")
        if (piece == "}" and last == ";" and not is_empty) or (ends and _is_spare_comma(pieces)):
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


class _Blocks:
    """Where a block has ended: of a statement, a function that is declared, a class, a method."""

    def __init__(self) -> None:
        # of each bracket that is open: whether it is a class (1), another block (0), or neither;
        # and the signs and words of its statement so far
        self._kinds = [-1]
        self._statements: list[list[str]] = [[]]
        self._ended = False

    def go_on(self, piece: str, last: str, is_head: bool, is_text: bool) -> bool:
        """Whether the token before this one, `last`, ended a block; parameters as above."""
        ended, self._ended = self._ended, False
        kinds, statements = self._kinds, self._statements
        if piece in (")", "]", "}") or (is_text and piece[0] == "}"):
            statements.pop()
            if kinds.pop() >= 0:
                self._ended = True
                statements[-1].clear()
                return ended
        statement = statements[-1]
        if piece == ";":
            statement.clear()
            return ended
        if piece in ("(", "[", "{") or (is_text and piece.endswith("${")):
            kind = _kind_of_block(statement, last, is_head, kinds[-1] == 1) if piece == "{" else -1
            kinds.append(kind)
            statements.append([])
        statement.append(piece)
        return ended


def _kind_of_block(statement: Sequence[str], last: str, is_head: bool, in_class: bool) -> int:
    """What a brace opens: 1 a class, 0 another block, -1 neither or that is not certain."""
    words = [one for one in statement if one not in ("export", "default", "async")]
    if not words:
        return -1
    if words[0] == "class":
        return 1
    opens = is_head or words[0] in _OPENING or (in_class and "=" not in words)
    return 0 if (last == ")" and opens) or last in _BARE else -1


def _is_spare_comma(pieces: Sequence[str]) -> bool:
    """Whether the last token is a comma behind the last of several, not that of a hole."""
    return pieces[-1:] == [","] and pieces[-2] not in ("[", ",")


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
    if gap == "\n" and a not in "{([,;&|=<>?:%^~!" and b not in "})].?:&|=%^":
        return "\n"
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
