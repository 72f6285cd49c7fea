"""Text to tokens, by the terminals of the grammar."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from arael.diagnostics.records import Source
from arael.syntax import foreign, tables
from arael.syntax.limits import MAX_NAME, MAX_NESTING, MAX_NUMBER, MAX_TOKENS
from arael.syntax.log import ErrorLog
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS, Token
from arael.syntax.tree import Comment


@dataclass(slots=True)
class Lexed:
    """Tokens (the last one is the end of the text) and the comments between them."""

    tokens: list[Token]
    comments: list[Comment]


_NUMBER_LIKE = re.compile(r"[0-9](?:[eE][+-](?=[0-9])|[A-Za-z0-9_]|\.(?![.*/]))*")
_UNSAFE = re.compile("[\x00-\x08\x0b\x0e-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


@cache
def _scanner() -> re.Pattern[str]:
    t = tables.load()
    symbols = "|".join(re.escape(s) for s in sorted(t.symbols, key=len, reverse=True))
    parts = [f"(?P<{name}>{pattern})" for name, pattern in t.patterns.items()]
    return re.compile("|".join([*parts, f"(?P<SYMBOL>{symbols})"]))


def tokenise(source: Source, log: ErrorLog) -> Lexed:
    """Split `source` into tokens; invalid characters are reported to `log` and skipped.

    Runs of line ends become one token. Never raises for single bad characters; raises `AraelError`
    if a limit is exceeded.
    """
    grammar = tables.load()
    words, symbols, ignored = grammar.words, grammar.symbols, set(grammar.ignored)
    text = source.text
    match_at = _scanner().match
    suspicious = _UNSAFE.search(text) is not None
    tokens: list[Token] = []
    comments: list[Comment] = []
    depth = 0
    at, length = 0, len(text)
    while at < length:
        match = None if text.startswith(foreign.TWO_CHARACTERS, at) else match_at(text, at)
        if match is None:
            at = foreign.read(text, at, tokens, log)
            continue
        kind, word, end = match.lastgroup, match.group(), match.end()
        assert kind is not None
        if kind == "COMMENT":
            word = word.rstrip()
            comments.append(Comment(log.span(at, at + len(word)), word))
            if suspicious:
                _check_unsafe(text, at, end, log)
        elif kind == NEWLINE:
            if not tokens or tokens[-1].type != NEWLINE:
                tokens.append(Token(NEWLINE, "\n", at, end))
        elif kind == "NAME":
            if len(word) > MAX_NAME:
                log.error(
                    "E0106",
                    f"this name has {len(word)} characters",
                    at,
                    end,
                    f"at most {MAX_NAME} are allowed",
                )
                word = word[:MAX_NAME]
            tokens.append(Token(words.get(word, "NAME"), word, at, end))
        elif kind == "SYMBOL":
            kind = symbols[word]
            if kind == "DOT" and foreign.is_bare_fraction(text, at):
                end = foreign.bare_fraction(text, at, log)
                kind, word = "NUMBER", text[at:end]
            elif kind in OPENERS:
                depth += 1
                if depth > MAX_NESTING:
                    log.error(
                        "E0105",
                        f"brackets are nested more than {MAX_NESTING} deep",
                        at,
                        end,
                        "one bracket too many",
                        help="name inner parts with `let`",
                    )
                    log.stop()
            elif kind in CLOSERS:
                depth = max(0, depth - 1)
            tokens.append(Token(kind, word, at, end))
        elif kind == "NUMBER":
            like = _NUMBER_LIKE.match(text, at)
            if like and like.end() > end:
                end = like.end()
                foreign.malformed_number(text, at, end, log)
                word = "1"
            elif len(word) > MAX_NUMBER:
                log.error(
                    "E0106",
                    f"this number has {len(word)} characters",
                    at,
                    end,
                    f"at most {MAX_NUMBER} are allowed",
                )
                word = "1"
            elif float(word) == float("inf"):
                log.error(
                    "E0111",
                    f"`{word}` is too large for a number",
                    at,
                    end,
                    help="the largest number is about 1.8e308",
                )
            tokens.append(Token(kind, word, at, end))
        elif kind not in ignored:
            if suspicious:
                _check_unsafe(text, at, end, log)
            tokens.append(Token(kind, word, at, end))
        at = end
        if len(tokens) > MAX_TOKENS:
            log.error(
                "E0106",
                f"the file has more than {MAX_TOKENS} tokens",
                at - 1,
                at,
                "the limit is reached here",
                help="split the model into files",
            )
            log.stop()
    tokens.append(Token(tables.END, "", length, length))
    return Lexed(tokens, comments)


def _check_unsafe(text: str, start: int, end: int, log: ErrorLog) -> None:
    found = _UNSAFE.search(text, start, end)
    if found:
        log.error(
            "E0113",
            f"control character U+{ord(found.group()):04X}",
            found.start(),
            found.end(),
            "is invisible, and can make text look different from its content",
            help="delete it",
        )
