"""JSON as text: places of errors, and duplicate keys."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import msgspec

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.io.report import Report
from arael.runtime.store.messages import shorten

# Errors in texts up to this size are shown with an excerpt; in larger ones by line and column.
WINDOW = 200_000
# Key paths are determined in texts up to this size.
SCANNED = 50_000_000
TOKEN = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[\]{},:]', re.DOTALL)
NOT_NUMBERS = re.compile(rb"-?(?:NaN|nan|Infinity|inf)")
ESCAPE = re.compile(rb"\\(?:u[0-9a-fA-F]{4}|[^u])", re.DOTALL)
STRING_OR_NUMBER = re.compile(rb'"(?:[^"\\]|\\.)*"|-?\d[\d.eE+-]*', re.DOTALL)


def syntax_error(content: bytes, name: str, failure: Exception) -> AraelError:
    """E0711 (or E0705 for NaN and infinities) with line and column."""
    if isinstance(failure, RecursionError):
        return AraelError(Diagnostic("E0711", "the JSON is nested too deeply", origin=name))
    if isinstance(failure, UnicodeDecodeError):
        return _not_text(content, name)
    text = str(failure)
    if "truncated" in text or "surrogate" in text:
        half = _half_pair(content)
        if half >= 0:
            return _not_character(content, name, half)
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
        help = "JSON has finite numbers only; omit the measurement"
        return AraelError(_diagnostic("E0705", message, content, name, special.start(), help))
    what = re.sub(r"^JSON is malformed: | \(byte \d+\)$", "", text)
    path = path_at(content, offset)
    inside = f" in `{path}`" if path else ""
    return AraelError(_diagnostic("E0711", f"not JSON: {what}{inside}", content, name, offset))


def _not_text(content: bytes, name: str) -> AraelError:
    """E0711 at the first byte that is not UTF-8."""
    try:
        content.decode()
    except UnicodeDecodeError as failure:
        path = path_at(content, failure.start)
        inside = f" in `{path}`" if path else ""
        message = f"not UTF-8 text: byte 0x{content[failure.start]:02x}{inside}"
        return AraelError(_diagnostic("E0711", message, content, name, failure.start))
    raise AssertionError("the decoder rejected valid UTF-8")


def _half_pair(content: bytes) -> int:
    """Offset of the first escape of an unpaired surrogate; -1 if there is none."""
    high = -1  # offset of the first half of a pair whose second half must follow
    for match in ESCAPE.finditer(content):
        if high >= 0 and match.start() != high + 6:
            return high
        unit = int(match[0][2:], 16) if match[0][1:2] == b"u" else 0
        low = 0xDC00 <= unit < 0xE000
        if low != (high >= 0):
            return match.start() if low else high
        high = match.start() if 0xD800 <= unit < 0xDC00 else -1
    return high


def _not_character(content: bytes, name: str, offset: int) -> AraelError:
    """E0711 for an unpaired surrogate."""
    escape = content[offset : offset + 6].decode()
    path = path_at(content, offset)
    message = f"`{escape}` is an unpaired surrogate, not a character"
    message = f"`{path}`: {message}" if path else message
    help = "write the character itself, or both halves of the pair"
    return AraelError(_diagnostic("E0711", message, content, name, offset, help))


def _out_of_range(content: bytes, name: str) -> AraelError:
    for match in STRING_OR_NUMBER.finditer(content):
        text = match[0][:400]  # a number with more digits is out of range in any case
        if not text.startswith(b'"') and (len(text) == 400 or _is_infinite(text)):
            path = path_at(content, match.start())
            message = f"{shorten(match[0].decode())} does not fit a number"
            if path:
                message = f"`{path}`: {message}"
            return AraelError(_diagnostic("E0706", message, content, name, match.start()))
    return AraelError(Diagnostic("E0706", "a number is out of range", origin=name))


def _is_infinite(number: bytes) -> bool:
    try:
        return math.isinf(float(number))
    except ValueError:
        return False


def _diagnostic(
    code: str, message: str, content: bytes, name: str, offset: int, help: str = ""
) -> Diagnostic:
    before = content[:offset]
    line = before.count(b"\n") + 1
    column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8", "replace")) + 1
    helps = (help,) if help else ()
    if len(content) <= WINDOW:
        text = content.decode("utf-8", "replace")
        start = min(len(before.decode("utf-8", "replace")), max(len(text) - 1, 0))
        return Diagnostic(code, message, Span(Source(name, text), start, start + 1), help=helps)
    return Diagnostic(code, message, origin=f"{name}:{line}:{column}", help=helps)


def path_at(content: bytes, offset: int) -> str:
    """Return the key path of the value at `offset`: ``poses[3].pos``; "" at the top."""
    if offset > SCANNED:
        return ""
    stack: list[Frame] = []
    for _ in _walk(content, offset, stack):
        pass
    return _path(stack)


@dataclass
class Frame:
    """An enclosing object or array: its key or index, and the keys so far."""

    at: str | int
    keys: set[bytes] = field(default_factory=set)


def _walk(content: bytes, end: int, stack: list[Frame]) -> Iterator[tuple[int, bytes]]:
    """Scan a JSON text up to `end`, updating `stack`; yields each key with its offset."""
    last, last_at = b"", 0
    for token in TOKEN.finditer(content, 0, end):
        text = token[0]
        if text in (b"{", b"["):
            stack.append(Frame("" if text == b"{" else 0))
        elif not stack:
            pass
        elif text in (b"}", b"]"):
            stack.pop()
        elif text == b":" and isinstance(stack[-1].at, str):
            last = _plain(last)
            stack[-1].at = shorten(last[1:-1].decode("utf-8", "replace"))
            yield last_at, last
        elif text == b",":
            top = stack[-1]
            top.at = top.at + 1 if isinstance(top.at, int) else ""
        last, last_at = text, token.start()


def _plain(key: bytes) -> bytes:
    """A key in quotes with its escapes resolved, so that equal keys compare equal."""
    if b"\\" not in key:
        return key
    try:
        return b'"' + msgspec.json.decode(key, type=str).encode() + b'"'
    except (msgspec.MsgspecError, UnicodeDecodeError):
        return key


def _path(stack: list[Frame]) -> str:
    parts = (f"[{f.at}]" if isinstance(f.at, int) else f".{f.at}" for f in stack if f.at != "")
    return "".join(parts).lstrip(".")


def refuse_duplicates(content: bytes, name: str, keys: int, report: Report) -> None:
    """Report duplicate keys of an object, of which the decoder kept only one.

    `keys` is the number of keys that were kept; every key is followed by a colon, so a text with as
    many colons has no duplicates.
    """
    if content.count(b":") == keys:
        return
    stack: list[Frame] = []
    for offset, key in _walk(content, len(content), stack):
        if key in stack[-1].keys:
            message = f"`{_path(stack)}` is given twice"
            report.take(_diagnostic("E0718", message, content, name, offset))
        stack[-1].keys.add(key)
