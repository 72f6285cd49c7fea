"""The Pygments lexer of `.arael` files."""

from __future__ import annotations

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups
from pygments.token import (
    Comment,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
)

from arael.highlighting import words
from arael.highlighting.words import any_of

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"


class AraelLexer(RegexLexer):  # type: ignore[misc]
    """Colours models of arael."""

    name = "arael"
    aliases: ClassVar[list[str]] = ["arael"]
    filenames: ClassVar[list[str]] = ["*.arael"]
    url = "https://github.com/arael/arael"

    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"\s+", Whitespace),
            (r"#[^\n]*", Comment.Single),
            (r'"(?:\\.|[^"\\\n])*"', String),
            (
                rf"({words.NUMBER})([ \t]+)({words.UNIT})",
                bygroups(Number, Whitespace, Number.Unit),
            ),
            (words.NUMBER, Number),
            (rf"(\.)({any_of(words.BUILTINS)})", bygroups(Operator, Name.Builtin)),
            (rf"(\.)({_NAME})", bygroups(Operator, Name.Attribute)),
            (
                rf"({any_of(words.TYPES)})((?:<[0-9, ]*>)?)([ \t]*)({words.UNIT})",
                bygroups(Keyword.Type, Punctuation, Whitespace, Number.Unit),
            ),
            (
                rf"({any_of(words.DECLARING)})(\s+)({_NAME})",
                bygroups(Keyword.Declaration, Whitespace, Name.Class),
            ),
            (
                rf"({any_of(words.NAMING)})([ \t]+)({_NAME})",
                bygroups(Keyword.Declaration, Whitespace, Name.Variable),
            ),
            (rf"({any_of(words.ENTITIES)})(?=\s*\.)", Name.Builtin.Pseudo),
            (rf"^({_NAME})(?=\s*:)", Name.Variable),
            (any_of(words.RESERVED), Keyword),
            (any_of(words.CONTEXTUAL) + words.NOT_A_NAME, Keyword),
            (any_of(words.BRANCHES), Keyword),
            (any_of(words.LOGIC), Operator.Word),
            (any_of(words.VALUES), Keyword.Constant),
            (any_of(words.ENTITIES), Name.Builtin.Pseudo),
            (any_of(words.TYPES) + r"(?!\s*\()", Keyword.Type),
            (any_of(words.BUILTINS) + r"(?=\s*\()", Name.Builtin),
            (any_of(words.PREDEFINED), Name.Constant),
            (rf"{_NAME}(?=\s*\()", Name.Function),
            (_NAME, Name),
            (r"==|!=|<=|>=|\.\.|\.\*|\./|[-+*/^<>=~?'|]", Operator),
            (r"[{}()\[\],:;.]", Punctuation),
        ]
    }
