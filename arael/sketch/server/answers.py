"""Replies to pages: what a command said, or why it was refused."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from arael.diagnostics.records import AraelError
from arael.sketch.commands.replies import Reply
from arael.sketch.document.document import Document

_NAME = re.compile(r"\b([A-Za-z]+\d+[A-Z]?)\b")


def answer(replies: Iterable[Reply]) -> dict[str, Any]:
    """Of commands that ran."""
    ran = list(replies)
    found: dict[str, Any] = {
        "ok": True,
        "text": "\n".join(one.text for one in ran if one.text),
        "names": [name for one in ran for name in one.names],
        "created": [],
        "notes": [],
    }
    data = [dict(one.data) for one in ran if one.data]
    if data:
        found["data"] = data[-1]
    return found


def refusal(error: AraelError, document: Document) -> dict[str, Any]:
    """Of a command that was refused; `names`: records that the message mentions."""
    first = error.diagnostics[0]
    span = first.span
    texts = [first.message, *first.notes]
    return {
        "ok": False,
        "text": first.message,
        "names": [],
        "created": [],
        "notes": [],
        "error": {
            "code": first.code,
            "message": first.message,
            "label": first.label,
            "notes": list(first.notes),
            "hint": first.help[0] if first.help else "",
            "help": list(first.help),
            "from": span.start if span else None,
            "to": span.end if span else None,
            "names": mentioned(texts, document),
        },
    }


def mentioned(texts: Sequence[str], document: Document) -> list[str]:
    """Names of records in texts, each once."""
    found: dict[str, None] = {}
    for text in texts:
        for name in _NAME.findall(text):
            if document.find(name) is not None:
                found[name] = None
    return list(found)
