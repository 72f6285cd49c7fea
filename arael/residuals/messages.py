"""Error records of this package, and validation of names."""

from __future__ import annotations

from arael.check.builtins import FUNCTIONS, IDENTITIES
from arael.diagnostics.records import AraelError, Diagnostic
from arael.syntax import tables


def error(code: str, message: str, origin: str, help: str = "") -> AraelError:
    """A diagnostic about an argument from Python."""
    return AraelError(Diagnostic(code, message, origin=origin, help=(help,) if help else ()))


def label_problem(name: object) -> str:
    """Why `name` cannot be a label; "" if it can. Labels do not occur in formulas."""
    if not isinstance(name, str) or not name.isidentifier() or not name.isascii():
        return "a name is made of letters, digits and `_`"
    return "it has more than 100 characters" if len(name) > 100 else ""


def name_problem(name: object) -> str:
    """Why `name` is invalid in a formula; "" if it is valid."""
    problem = label_problem(name)
    if problem:
        return problem
    if name in tables.load().words or name in ("self", "parent", "root"):
        return "it is a word of the language"
    if name in FUNCTIONS or name in IDENTITIES:
        return "it is a function of the language"
    return ""
