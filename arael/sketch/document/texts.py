"""Which texts a sketch may hold."""

from __future__ import annotations

import unicodedata

MAX_TEXT = 200
"""Characters of one text."""

# Control and format characters, surrogates, separators of lines and paragraphs.
_REFUSED = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def normalized(text: str) -> str:
    """A text with composed characters (Unicode NFC): an `a` with two dots above is `ä`."""
    return unicodedata.normalize("NFC", text)


def problem_of(text: str) -> str:
    """Why something is no text of a sketch, empty if it is one.

    A text is one line of at most `MAX_TEXT` characters that are not all blank. Format characters
    are left out because they change the order or are not seen.
    """
    if len(text) > MAX_TEXT:
        return f"a text has at most {MAX_TEXT} characters, found {len(text):,}"
    for one in text:
        if one in "\n\r\x0b\x0c\x85\u2028\u2029":
            return "a text is one line"
        if unicodedata.category(one) in _REFUSED:
            return f"U+{ord(one):04X} is a control character: it is not drawn"
    return "" if text.strip() else "a text has at least one character that is not blank"
