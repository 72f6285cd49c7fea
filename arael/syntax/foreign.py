"""Characters that arael does not use, with the probable intention.

The lexer calls this module for everything that is not a token. If the meaning is clear (``&&``,
``**``, a mathematical minus sign) the arael token takes its place, so that the parser finds no
second error.
"""

from __future__ import annotations

import re
import unicodedata

from arael.syntax.log import ErrorLog
from arael.syntax.tokens import Token

# Spellings of other languages: the message, and the token used in its place (None: skip it).
_OPERATORS: dict[str, tuple[str, tuple[str, str] | None]] = {
    "&&": ("write `and`", ("AND", "and")),
    "||": ("write `or`", ("OR", "or")),
    "**": ("a power is written `^`", ("CARET", "^")),
    ".^": ("a power is written `^`", ("CARET", "^")),
    "->": ("arael has no arrows; a function is written `fn f(x) = ...`", None),
    "=>": ("arael has no arrows; a function is written `fn f(x) = ...`", None),
    ":=": ("write `=`", ("EQUAL", "=")),
    "~=": ("write `!=`", ("NE", "!=")),
    "<>": ("write `!=`", ("NE", "!=")),
    "+=": ("names cannot be reassigned: give the new value a name with `let`", None),
    "-=": ("names cannot be reassigned: give the new value a name with `let`", None),
    "*=": ("names cannot be reassigned: give the new value a name with `let`", None),
    "/=": ("names cannot be reassigned: give the new value a name with `let`", None),
    "//": ("a comment starts with `#`", None),
    "/*": ("a comment starts with `#`", None),
    "*/": ("a comment starts with `#`", None),
}
TWO_CHARACTERS = tuple(_OPERATORS)

_CHARACTERS: dict[str, tuple[str, tuple[str, str] | None]] = {
    "!": ("write `not`", ("NOT", "not")),
    "&": ("write `and`; arael has no references or bit operations", None),
    "@": ("matrices are multiplied with `*`", ("STAR", "*")),
    "%": (
        "the cross product is `cross(a, b)`; for a remainder write `x - floor(x / y) * y`",
        ("STAR", "*"),
    ),
    "$": ("omit it", None),
    "`": ("omit it", None),
    "\\": (
        "omit it: a statement continues after an operator or inside brackets",
        None,
    ),
    "\u2212": ("write `-`", ("MINUS", "-")),
    "\u2013": ("write `-`", ("MINUS", "-")),
    "\u2014": ("write `-`", ("MINUS", "-")),
    "\u00d7": ("write `*`", ("STAR", "*")),
    "\u00b7": ("write `*`", ("STAR", "*")),
    "\u22c5": ("write `*`", ("STAR", "*")),
    "\u2215": ("write `/`", ("SLASH", "/")),
    "\u00f7": ("write `/`", ("SLASH", "/")),
    "\u2264": ("write `<=`", ("LE", "<=")),
    "\u2265": ("write `>=`", ("GE", ">=")),
    "\u2260": ("write `!=`", ("NE", "!=")),
    "\u1d40": ("a transpose is written `'`", ("QUOTE", "'")),
    "\u22a4": ("a transpose is written `'`", ("QUOTE", "'")),
    "\u2032": ("write `'`", ("QUOTE", "'")),
    "\u2018": ("write `'`", ("QUOTE", "'")),
    "\u2019": ("write `'`", ("QUOTE", "'")),
    "\u201c": ('quote text with `"`', None),
    "\u201d": ('quote text with `"`', None),
    "\u00b2": ("write `^2`", None),
    "\u00b3": ("write `^3`", None),
    "\u221a": ("write `sqrt(...)`", None),
    "\u00b0": ("write `deg2rad(...)`, or the unit `deg`", None),
    "\u00b5": ("write `u` or a power of ten", None),
}


def read(text: str, at: int, tokens: list[Token], log: ErrorLog) -> int:
    """Report the characters at `at`, which are not a token; return where to continue."""
    pair = text[at : at + 2]
    if pair in _OPERATORS:
        return _operator(pair, text, at, tokens, log)
    char = text[at]
    if char == '"':
        return _unterminated(text, at, tokens, log)
    if char in " \ufeff\u200b\u200c\u200d" or unicodedata.category(char) in ("Zs", "Cf"):
        _invisible(char, at, log)
        return at + 1
    if char.isalpha():
        end = at + 1
        while end < len(text) and (text[end].isalnum() or text[end] == "_"):
            end += 1
        before = tokens[-1] if tokens and tokens[-1].type == "NAME" else None
        if before is not None and before.end == at:
            tokens.pop()
            at = before.start
        _foreign_letters(text, at, end, log)
        tokens.append(Token("NAME", "_", at, end))
        return end
    end = at + 1
    while end < len(text) and text[end] == char:
        end += 1
    help_, token = _CHARACTERS.get(char, ("", None))
    log.error(
        "E0110",
        f"stray character {_show(char)}",
        at,
        end,
        help_ or "not part of the language",
    )
    if token:
        tokens.append(Token(*token, at, end))
    return end


def _show(char: str) -> str:
    if char.isprintable():
        return f"`{char}`"
    return f"U+{ord(char):04X}"


def _operator(pair: str, text: str, at: int, tokens: list[Token], log: ErrorLog) -> int:
    help_, token = _OPERATORS[pair]
    if pair not in ("//", "/*") or not log.said(f"arael does not use `{pair}`"):
        log.error("E0110", f"arael does not use `{pair}`", at, at + 2, help_)
    if token:
        tokens.append(Token(*token, at, at + 2))
    if pair == "//":
        end = text.find("\n", at)
        return len(text) if end < 0 else end
    if pair == "/*":
        end = text.find("*/", at)
        return len(text) if end < 0 else end + 2
    return at + 2


def _unterminated(text: str, at: int, tokens: list[Token], log: ErrorLog) -> int:
    end = text.find("\n", at)
    end = len(text) if end < 0 else end
    log.error(
        "E0112",
        'this text has no closing `"`',
        at,
        at + 1,
        "opened here",
        help='close it on the same line; write `\\"` for a quote inside',
    )
    tokens.append(Token("STRING", '""', at, end))
    return end


def _invisible(char: str, at: int, log: ErrorLog) -> None:
    name = unicodedata.name(char, f"U+{ord(char):04X}").lower()
    log.error(
        "E0110",
        f"stray character U+{ord(char):04X} ({name})",
        at,
        at + 1,
        "looks like a blank, or is invisible",
        help="type an ordinary blank",
    )


def _foreign_letters(text: str, start: int, end: int, log: ErrorLog) -> None:
    word = text[start:end][:60]
    spelled = "".join(c if c.isascii() else _spell(c) for c in word)
    help_ = f"write `{spelled}`" if spelled.isidentifier() else ""
    log.error(
        "E0110",
        f"`{word}` has letters other than a-z",
        start,
        end,
        "names take a-z, A-Z, 0-9 and _",
        help=help_ or (),
    )


def _spell(char: str) -> str:
    name = unicodedata.name(char, "")
    if name.startswith("GREEK ") and " LETTER " in name:
        letter = name.split(" LETTER ")[1].split()[0].lower()
        letter = "lambda_" if letter == "lamda" else letter
        return letter.capitalize() if "CAPITAL" in name else letter
    plain = unicodedata.normalize("NFKD", char.casefold() if char == "\u00df" else char)
    return "".join(c for c in plain if c.isascii()) or "_"


def is_bare_fraction(text: str, at: int) -> bool:
    """Return whether the dot at `at` begins a number such as ``.5``."""
    if not text[at + 1 : at + 2].isdigit() or not text[at + 1].isascii():
        return False
    before = text[at - 1] if at else " "
    return not (before.isalnum() or before in "_)]'.")


def bare_fraction(text: str, at: int, log: ErrorLog) -> int:
    """Report a number without digits before its point; return its end."""
    end = at + 1
    while end < len(text) and text[end] in "0123456789":
        end += 1
    shown = text[at:end][:40]
    log.error(
        "E0111",
        f"`{shown}` is not a number in arael",
        at,
        end,
        "digits are missing before the point",
        help=f"write `0{shown}`",
    )
    return end


_DIGITS = r"([0-9]+(?:\.[0-9]+)?)"
# Patterns of malformed numbers, and the help: {1} and {2} are groups, {plain} is without `_`.
_NUMBERS = (
    (r"([0-9]+)\.", "write `{1}.0` or `{1}`"),
    (
        r"([0-9.]+)(?:f|f32|f64|d|u\d+|i\d+|_f32|_f64)",
        "numbers take no suffix: write `{1}`",
    ),
    (r"0[xX][0-9a-fA-F]{1,15}", "write `{decimal}`"),
    (r"0[xX]\w{0,15}", "write decimal numbers"),
    (_DIGITS + r"_\w*", "write `{plain}`"),
    (_DIGITS + r"[eE]", "an exponent needs digits, as in `{1}e3`"),
    (
        _DIGITS + r"([A-Za-z]\w*)",
        "write `{1} * {2}` for a product; a name starts with a letter",
    ),
)


def malformed_number(text: str, start: int, end: int, log: ErrorLog) -> None:
    """Report a token that begins like a number but is not one."""
    word = text[start:end]
    help_ = ""
    for pattern, advice in _NUMBERS:
        found = re.fullmatch(pattern, word)
        if found:
            decimal = int(word, 16) if "{decimal}" in advice else 0
            plain = word.replace("_", "")
            help_ = advice.format(word, *found.groups(), plain=plain, decimal=decimal)
            break
    log.error(
        "E0111",
        f"`{word[:40]}` is not a number",
        start,
        end,
        "digits, a point between digits, an exponent as in 1e-3",
        help=help_ or (),
    )
