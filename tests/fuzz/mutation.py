"""Mutators of texts and bytes; each depends on its `random.Random` and its arguments alone."""
# ruff: noqa: E501 - lists of odd texts

from __future__ import annotations

import io
import json
import random
import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from typing import Any

_TOKEN = re.compile(
    r"[A-Za-z_]\w*|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\s+|\.\.|==|!=|<=|>=|.", re.DOTALL
)

NUMBERS = [
    "0", "-0.0", "1", "-1", "2", "3", "0.5", "1e308", "1e-320", "1e999", "9" * 25, "64", "1000000000",
    "1_0", "0x1", "1e", ".5", "5.", "nan", "inf", "2147483648", "18446744073709551616",
]  # fmt: skip
"""Numbers at and beyond the ends of ranges, and what only resembles a number."""

CHARACTERS = [
    *"{}()[]<>|'\"#;:,.=+-*/^?!&@$\\~`%", "\n", "\r\n", "\r", "\t", "\0", "\x0c", "\x85", "\xa0",
    "é", "σ", "\u202e", "\u2028", "\ufeff", "\U0001f600", "\udcff", "\ud800",
]  # fmt: skip
"""Punctuation, control characters, and characters of one to four bytes; lone surrogates too."""

WRAPPED = [
    "sqrt({})", "log({})", "({})/0", "1/({})", "({})^-2", "({})^({})", "asin({})", "-{}", "{}'",
    "[{}, {}]", "exp(exp({}))", "abs({})", "atan2({}, {})", "({} - {})", "if {} > 0 then {} else 0",
    "floor({})", "sign({})", "norm([{}, {}])", "unit([{}, 0])", "{}[0]", "{}.x", "{}.value", "f({})",
    "hypot({}, {})", "clamp({}, 0, 1)", "max({}, {})", "cbrt({})", "not {}", "{} == {}",
]  # fmt: skip
"""Formulas around a piece of text: singular points, kinks, wrong shapes and types."""


def encoded(text: str) -> bytes:
    """UTF-8; lone surrogates become bytes that are no UTF-8."""
    return text.encode("utf-8", "surrogatepass")


def tokens(text: str) -> list[str]:
    """Words, numbers, runs of blanks and single characters, in order; joined, they are `text`."""
    return _TOKEN.findall(text)


def mutated_text(
    rng: random.Random, text: str, others: Sequence[str], most: int = 4, gentle: bool = False
) -> bytes:
    """A text with 1 to `most` changes of tokens, lines, characters and bytes.

    Parameters
    ----------
    rng : source of all choices
    text : what is changed
    others : texts that tokens and lines are taken from
    most : most changes
    gentle : change single tokens only, which a compiler accepts more often
    """
    kinds: list[Callable[[random.Random, str, Sequence[str]], str]] = [_token, _number, _wrap]
    if not gentle:
        kinds += [_token, _line, _character]
    for _ in range(rng.randint(1, most)):
        text = rng.choice(kinds)(rng, text, others)
    content = encoded(text)
    if not gentle and rng.random() < 0.15:
        content = mutated_bytes(rng, content, most=2)
    return content


def _token(rng: random.Random, text: str, others: Sequence[str]) -> str:
    found = tokens(text)
    if not found:
        return rng.choice(CHARACTERS)
    at = rng.randrange(len(found))
    source = tokens(rng.choice(others)) if rng.random() < 0.5 else found
    kind = rng.randrange(5)
    if kind == 0:
        del found[at]
    elif kind == 1:
        found[at:at] = [found[at]]
    elif kind == 2:
        other = rng.randrange(len(found))
        found[at], found[other] = found[other], found[at]
    elif kind == 3:
        words = [word for word in source if word[0].isalpha()] or ["x"]
        found[at] = rng.choice(words)
    else:
        start = rng.randrange(len(source) or 1)
        found[at:at] = source[start : start + rng.randint(1, 6)]
    return "".join(found)


def _number(rng: random.Random, text: str, others: Sequence[str]) -> str:
    found = tokens(text)
    numbers = [i for i, token in enumerate(found) if token[0].isdigit()]
    if not numbers:
        return text + rng.choice(NUMBERS)
    found[rng.choice(numbers)] = rng.choice(NUMBERS)
    return "".join(found)


def _wrap(rng: random.Random, text: str, others: Sequence[str]) -> str:
    found = tokens(text)
    words = [i for i, token in enumerate(found) if token[0].isalnum()]
    if not words:
        return text
    at = rng.choice(words)
    found[at] = rng.choice(WRAPPED).replace("{}", found[at])
    return "".join(found)


def _line(rng: random.Random, text: str, others: Sequence[str]) -> str:
    lines = text.splitlines(keepends=True) or [""]
    at = rng.randrange(len(lines))
    kind = rng.randrange(4)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines[at:at] = [lines[at]] * rng.choice([1, 1, 2, 30])
    elif kind == 2:
        lines.insert(rng.randrange(len(lines)), lines.pop(at))
    else:
        lines.insert(at, rng.choice((rng.choice(others) or " ").splitlines() or [""]) + "\n")
    return "".join(lines)


def _character(rng: random.Random, text: str, others: Sequence[str]) -> str:
    at = rng.randint(0, len(text))
    kind = rng.randrange(3)
    if kind == 0:
        return text[:at] + text[at + rng.randint(1, 8) :]
    piece = rng.choice(CHARACTERS)
    if kind == 1:
        piece *= rng.choice([1, 1, 1, 3, 200])
    return text[:at] + piece + text[at + rng.randint(0, 2) :]


def mutated_bytes(rng: random.Random, content: bytes, most: int = 3) -> bytes:
    """Bytes with 1 to `most` changes: bits flipped, runs removed, doubled, overwritten; cut off."""
    changed = bytearray(content)
    for _ in range(rng.randint(1, most)):
        at = rng.randrange(len(changed) or 1)
        kind = rng.randrange(7)
        if not changed:
            changed[:] = rng.randbytes(3)
        elif kind == 0:
            changed[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del changed[at : at + rng.choice([1, 1, 2, 8, 64])]
        elif kind == 2:
            changed[at:at] = changed[at : at + rng.choice([1, 4, 16, 64])]
        elif kind == 3:
            changed[at : at + rng.choice([1, 2, 4, 8])] = rng.choice(
                [b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"\x00\xca\x9a\x3b", b"\x80"]
            )
        elif kind == 4:
            changed[at:at] = rng.randbytes(rng.randint(1, 4))
        elif kind == 5:
            del changed[at:]
        else:
            changed[at : at + 1] = rng.choice(
                [
                    b"1e400",
                    b"nan",
                    b"-",
                    b'"',
                    b"{",
                    b"[",
                    b"\n",
                    b"_",
                    b",",
                    b"9" * 22,
                    b"\xef\xbb\xbf",
                ]
            )
    return bytes(changed)


ODD_VALUES: list[Any] = [
    None, True, False, 0, -1, 1, 2**31, 2**63, -(2**70), 1e308, -0.0, 0.5, float("nan"), float("inf"),
    "", "x", "1", "\ud800", [], {}, [[]], [[1, 2], [3]], [None], {"value": 1}, {"value": [], "fixed": 3},
    {"fixed": True}, [1, 2, 3], [0, 0, 0, 0], "a" * 5000,
]  # fmt: skip
"""JSON values of every type, empty, ragged and out of range."""


def mutated_json(rng: random.Random, value: Any, most: int = 3) -> bytes:
    """A JSON text with values replaced, removed, doubled or moved; keys renamed or repeated."""
    root = [json.loads(json.dumps(value))]
    for _ in range(rng.randint(1, most)):
        holders = _holders(root)
        holder = rng.choice(holders)
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        if not keys:
            continue
        key = rng.choice(keys)
        kind = rng.randrange(5)
        if kind == 0 and holder is not root:
            del holder[key]
        elif kind == 1 and isinstance(holder, list):
            holder[key:key] = [holder[key]] * rng.choice([1, 2, 50])
        elif kind == 2 and isinstance(holder, dict):
            holder[rng.choice([key + " ", key.upper(), "", key[:-1], "é", "value"])] = holder.pop(
                key
            )
        elif kind == 3:
            other = rng.choice(holders)
            holder[key] = json.loads(json.dumps(other[0] if other is root else other))
        else:
            holder[key] = rng.choice(ODD_VALUES)
    text = json.dumps(root[0], ensure_ascii=rng.random() < 0.5)
    if rng.random() < 0.2:  # a key twice, spelled in two ways
        text = re.sub(
            r'"([a-z])(\w*)":', lambda m: f'{m[0]} 1, "\\u{ord(m[1]):04x}{m[2]}":', text, count=1
        )
    content = encoded(text)
    return mutated_bytes(rng, content, 1) if rng.random() < 0.3 else content


def _holders(value: Any) -> list[Any]:
    """Objects and arrays, outer before inner; texts of the corpus may be nested very deeply."""
    found, left = [], [value]
    while left:
        one = left.pop()
        if isinstance(one, (dict, list)):
            found.append(one)
            left += reversed(list(one.values()) if isinstance(one, dict) else one)
    return found


def mutated_archive(rng: random.Random, content: bytes) -> bytes:
    """An NPZ file with members changed, renamed, repeated or removed, or with changed bytes."""
    if rng.random() < 0.35:
        return mutated_bytes(rng, content)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    for _ in range(rng.randint(1, 2)):
        at = rng.randrange(len(members))
        name, data = members[at]
        kind = rng.randrange(6)
        if kind == 0 and len(members) > 1:
            del members[at]
        elif kind == 1:
            members.append((name, data if rng.random() < 0.5 else mutated_bytes(rng, data)))
        elif kind == 2:
            members[at] = (
                rng.choice(["", "x.npy", "../x.npy", name[:-4], "é.npy", name * 2]),
                data,
            )
        elif kind == 3:
            members[at] = (name, members[rng.randrange(len(members))][1])
        elif kind == 4:
            members[at] = (name, mutated_bytes(rng, data))
        else:
            members[at] = (name, _other_header(rng, data))
    memory = io.BytesIO()
    warnings.filterwarnings("ignore", "Duplicate name", UserWarning)
    with zipfile.ZipFile(
        memory, "w", rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
    ) as archive:
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name or "x"), data)
    return memory.getvalue()


def _other_header(rng: random.Random, data: bytes) -> bytes:
    """An array whose header declares another type, order or shape, of the same length."""
    end = data.find(b"\n") if data.startswith(b"\x93NUMPY") else -1
    if end < 10:
        return data
    shape = rng.choice(["()", "(0,)", "(1000000000,)", "(-1,)", "(2, 500000000)", "(3, 3)", "(2,)"])
    kind = rng.choice(
        ["<f8", ">f8", "<f4", "|O", "<i8", "|b1", "<U4", "<c16", "|V8", "<M8[s]", "x"]
    )
    head = f"{{'descr': '{kind}', 'fortran_order': {rng.random() < 0.3}, 'shape': {shape}, }}"
    return data[:10] + head.encode().ljust(end - 10) + data[end:]


def mutated_columns(rng: random.Random, content: bytes) -> bytes:
    """A file of lines and columns (CSV, g2o, BAL) with cells, columns and lines changed."""
    lines = content.decode().splitlines(keepends=True)
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(lines) or 1)
        if not lines:
            lines = ["\n"]
        elif rng.random() < 0.3:
            lines = _line(rng, "".join(lines), ["", "# x\n", "\ufeff\n"]).splitlines(keepends=True)
        else:
            cells = re.split(r"([ ,\n])", lines[at])
            cell = rng.randrange(len(cells))
            kind = rng.randrange(4)
            if kind == 0:
                del cells[cell]
            elif kind == 1:
                cells[cell:cell] = cells[cell : cell + 2]
            elif kind == 2:
                cells[cell] = rng.choice([*NUMBERS, *CHARACTERS])
            else:
                cells[cell] = rng.choice(cells)
            lines[at] = "".join(cells)
    changed = encoded("".join(lines))
    return mutated_bytes(rng, changed, 2) if rng.random() < 0.3 else changed
