"""JSON as text: where it stops being JSON, and keys given twice."""

from __future__ import annotations

import json
import re
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.io.report import Report
from arael.runtime.store.messages import shorten

# Texts up to here are shown with a window; larger ones are only named by line and column.
WINDOW = 200_000
TOKEN = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[\]{},:]', re.DOTALL)
NOT_NUMBERS = re.compile(rb"-?(?:NaN|nan|Infinity|inf)")
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?[eE]\+?\d{3,}")


def syntax_error(content: bytes, name: str, failure: Exception) -> AraelError:
    """E0711 (or E0705 for NaN and infinities) with line and column."""
    if isinstance(failure, RecursionError):
        return AraelError(Diagnostic("E0711", "the JSON is nested too deeply", origin=name))
    text = str(failure)
    found = re.search(r"byte (\d+)", text)
    if "out of range" in text:
        return _out_of_range(content, name)
    if "truncated" in text or not found:
        end = len(content.rstrip())
        message = "the JSON ends in the middle"
        path = path_at(content, end)
        if path:
            message += f" of `{path}`"
        return AraelError(_diagnostic("E0711", message, content, name, end))
    offset = int(found[1])
    sign = offset > 0 and content[offset - 1 : offset] == b"-"
    special = NOT_NUMBERS.match(content, offset - sign)
    if special:
        path = path_at(content, special.start())
        message = f"`{path}` is {special[0].decode()}" if path else f"{special[0].decode()}"
        help = "JSON has finite numbers only; leave the measurement out"
        return AraelError(_diagnostic("E0705", message, content, name, special.start(), help))
    what = re.sub(r"^JSON is malformed: | \(byte \d+\)$", "", text)
    path = path_at(content, offset)
    inside = f" in `{path}`" if path else ""
    return AraelError(_diagnostic("E0711", f"not JSON: {what}{inside}", content, name, offset))


def _out_of_range(content: bytes, name: str) -> AraelError:
    for match in NUMBER.finditer(content):
        if abs(float(match[0])) == float("inf"):
            path = path_at(content, match.start())
            message = f"{shorten(match[0].decode())} does not fit a number"
            if path:
                message = f"`{path}`: {message}"
            return AraelError(_diagnostic("E0706", message, content, name, match.start()))
    return AraelError(Diagnostic("E0706", "a number is out of range", origin=name))


def _diagnostic(
    code: str, message: str, content: bytes, name: str, offset: int, help: str = ""
) -> Diagnostic:
    before = content[:offset]
    line = before.count(b"\n") + 1
    column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8", "replace")) + 1
    helps = (help,) if help else ()
    if len(content) <= WINDOW:
        try:
            text = content.decode()
        except UnicodeDecodeError:
            return Diagnostic(code, message, origin=f"{name}:{line}:{column}", help=helps)
        start = min(len(before.decode("utf-8", "replace")), max(len(text) - 1, 0))
        return Diagnostic(code, message, Span(Source(name, text), start, start + 1), help=helps)
    return Diagnostic(code, message, origin=f"{name}:{line}:{column}", help=helps)


def path_at(content: bytes, offset: int) -> str:
    """Key path of the value around `offset`: ``poses[3].pos``; "" at the top or in a huge text."""
    if offset > 50_000_000:
        return ""
    stack: list[Any] = []
    last = b""
    for token in TOKEN.finditer(content, 0, offset):
        text = token[0]
        if text == b"{":
            stack.append("")
        elif text == b"[":
            stack.append(0)
        elif not stack:
            pass
        elif text in (b"}", b"]"):
            stack.pop()
        elif text == b":" and isinstance(stack[-1], str):
            stack[-1] = shorten(last[1:-1].decode("utf-8", "replace"))
        elif text == b",":
            stack[-1] = stack[-1] + 1 if isinstance(stack[-1], int) else ""
        last = text
    parts = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in stack if p != "")
    return parts.lstrip(".")


def refuse_duplicates(content: bytes, keys: int, report: Report) -> None:
    """Report keys that an object holds twice, of which the decoder kept only one.

    `keys` is the number of keys that were kept; as every key is followed by a colon, a text with as
    many colons has no other.
    """
    if content.count(b":") == keys:
        return
    colons = sum(token[0] == b":" for token in TOKEN.finditer(content))
    if colons == keys:
        return
    twice: list[str] = []

    def note(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            names = [name for name, _ in pairs]
            twice.extend(sorted({n for n in names if names.count(n) > 1}))
        return found

    json.loads(content, object_pairs_hook=note)
    for name in twice[:5]:
        report.add("E0718", f"the key `{shorten(name)}` is given twice in one object", "")
