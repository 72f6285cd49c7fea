"""The TextMate grammar, for VS Code and the editors that read its grammars."""

from __future__ import annotations

import json
from typing import Any

from arael.highlighting import words
from arael.highlighting.words import any_of

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"


def _captures(*names: str) -> dict[str, dict[str, str]]:
    return {str(n): {"name": f"{name}.arael"} for n, name in enumerate(names, 1) if name}


def _match(pattern: str, name: str = "", *captures: str) -> dict[str, Any]:
    found: dict[str, Any] = {"match": pattern}
    if name:
        found["name"] = f"{name}.arael"
    if captures:
        found["captures"] = _captures(*captures)
    return found


def grammar() -> str:
    """The grammar as JSON."""
    patterns = [
        _match("#.*$", "comment.line.number-sign"),
        {
            "name": "string.quoted.double.arael",
            "begin": '"',
            "end": '"|$',
            "patterns": [_match(r"\\.", "constant.character.escape")],
        },
        _match(
            rf"\b({words.NUMBER})\s+({words.UNIT})",
            "",
            "constant.numeric",
            "constant.other.unit",
        ),
        _match(rf"\b{words.NUMBER}", "constant.numeric"),
        _match(rf"(\.)({any_of(words.BUILTINS)})", "", "", "support.function"),
        _match(rf"(\.)({_NAME})", "", "", "variable.other.member"),
        _match(
            rf"({any_of(words.TYPES)})(<[0-9, ]*>)?\s*({words.UNIT})",
            "",
            "support.type",
            "",
            "constant.other.unit",
        ),
        _match(rf"({any_of(words.DECLARING)})\s+({_NAME})", "", "storage.type", "entity.name.type"),
        _match(rf"\b(fn)\s+({_NAME})", "", "storage.type", "entity.name.function"),
        _match(
            rf"({any_of(words.NAMING)})\s+({_NAME})",
            "",
            "storage.type",
            "variable.other.declaration",
        ),
        _match(rf"({any_of(words.ENTITIES)})(?=\s*\.)", "variable.language"),
        _match(rf"^\s*({_NAME})(?=\s*:)", "", "variable.other.declaration"),
        _match(any_of(words.RESERVED), "keyword.other"),
        _match(any_of(words.CONTEXTUAL) + words.NOT_A_NAME, "keyword.other"),
        _match(any_of(words.BRANCHES), "keyword.control"),
        _match(any_of(words.LOGIC), "keyword.operator.logical"),
        _match(any_of(words.VALUES), "constant.language"),
        _match(any_of(words.ENTITIES), "variable.language"),
        _match(any_of(words.TYPES) + r"(?!\s*\()", "support.type"),
        _match(any_of(words.BUILTINS) + r"(?=\s*\()", "support.function"),
        _match(any_of(words.PREDEFINED), "support.constant"),
        _match(rf"{_NAME}(?=\s*\()", "entity.name.function"),
        _match(r"==|!=|<=|>=|\.\.|\.\*|\./|[-+*/^<>=~?'|]", "keyword.operator"),
    ]
    whole = {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "arael",
        "scopeName": "source.arael",
        "fileTypes": ["arael"],
        "patterns": patterns,
    }
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"
