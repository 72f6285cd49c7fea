"""The words of the language by group, for every tool that colours models."""

from __future__ import annotations

from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES, METHODS
from arael.check.losses import LOSSES
from arael.check.types import TYPE_NAMES
from arael.highlighting.keywords import KEYWORDS, NAMES

VALUES = ("true", "false")
ENTITIES = ("self", "parent", "root")
LOGIC = ("and", "or", "not")
BRANCHES = ("if", "then", "else")

DECLARING = ("struct", "component", "root")
"""Words before the name of a type."""

NAMING = ("constraint", "pass", "let", "const", "symbolic", "compute", "param", "skip", "fn")
"""Words before a name that they declare."""

RESERVED = tuple(
    sorted(set(KEYWORDS) - set(NAMES) - {*VALUES, *ENTITIES, *LOGIC, *BRANCHES} | {"root"})
)
"""Words that are keywords wherever they stand."""

CONTEXTUAL = tuple(sorted(NAMES))
"""Words that are keywords at their own place only."""

TYPES = tuple(sorted(TYPE_NAMES))
BUILTINS = tuple(sorted({*FUNCTIONS, *METHODS, *LOSSES, "normal", "sum"}))
PREDEFINED = (*CONSTANTS, *IDENTITIES)

NOT_A_NAME = r"(?!\s*[:=.,)\]+\-*/^'])"
"""What cannot follow a contextual keyword: there it is a name."""

NUMBER = r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
UNIT = r"\[[A-Za-z0-9_*/^() .-]*\]"


def any_of(words: tuple[str, ...]) -> str:
    """A pattern for one of `words` as a whole word."""
    return rf"\b(?:{'|'.join(sorted(words, key=len, reverse=True))})\b"
