"""Interpretation of the formula of a fit: columns and parameters."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from arael import sym
from arael.diagnostics.records import AraelError
from arael.diagnostics.suggest import closest
from arael.fitting.messages import mistake
from arael.sym.values import Value, entries

_EQUALS = re.compile(r"(?<![=<>!])=(?!=)")
_COMPUTED = re.compile(r"[-+*/^()]")
_COMMENT = re.compile(r"#[^\n]*")
_RESERVED = ("self", "parent", "root")
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\s*\()")
_MODULE = re.compile(r"\b(np|numpy|math|scipy|sp|sympy|torch|jnp)\.(\w+)")


@dataclass(frozen=True)
class Formula:
    """A formula and its names.

    Attributes
    ----------
    residual : the formula to minimise
    text : the formula of the predicted column, without what is on the left of ``=``
    predicts : name of the predicted column; None if the formula is the residual itself
    columns : names of the columns that it reads
    parameters : names of the parameters
    """

    residual: str
    text: str
    predicts: str | None
    columns: tuple[str, ...]
    parameters: tuple[str, ...]


def read_formula(text: str, target: str | None, titles: Mapping[str, str], data: str) -> Formula:
    """Read ``FORMULA``, ``NAME = FORMULA``, or a residual: ``0 = FORMULA``, ``FORMULA = FORMULA``.

    Parameters
    ----------
    text : the formula
    target : the column that the formula predicts, if it is given apart from the formula
    titles : titles of the table's columns by their names in formulas
    data : the table's name, for messages

    Raises
    ------
    AraelError
        With every mistake in the formula at its place in it; E0870: a parameter that cancels out,
        a Python expression, no parameters; E0871: a missing column.
    """
    text = _COMMENT.sub("", text)
    if module := _MODULE.search(text):
        name = _known_function(module[2])
        raise mistake(
            "E0870",
            f"write '{name}' for '{module[0]}': formulas are in arael's language, not in Python",
            "formula",
        )
    left, formula = _sides(text)
    if left is not None and target is not None and _column(target, titles) != _column(left, titles):
        raise mistake(
            "E0870",
            f"'{left}' is on the left of FORMULA, and '{target}' is given with --y",
            "formula",
            "give one of the two",
        )
    if left is not None and _column(left, titles) not in titles and _COMPUTED.search(left):
        sym.parse(left), sym.parse(formula)  # each side names its mistakes by their place in it
        left, formula = "0", f"{left} - ({formula.strip()})"

    parsed = sym.parse(formula)
    names = list(sym.free_vars(parsed))
    own = left is None and target is None and "y" in titles and "y" in names
    if own or (left == "0" and target is None):
        measured, residual = None, formula
    else:
        measured = measured_column(left or target or "y", titles, data)
        residual = f"({formula}) - {measured}"
        if measured in names:
            raise mistake(
                "E0870",
                f"'{measured}' is the column that the formula predicts, and also occurs in it",
                "formula",
                f'write a residual as "0 = {formula.strip()}"',
            )
    parameters = [name for name in names if name not in titles]
    _refuse_names(parameters)
    if not parameters and not _NAME.findall(formula):
        raise mistake("E0870", "the formula has no parameter: there is nothing to fit", "formula")
    _refuse_what_cancels(formula, parsed, parameters, titles)
    if not parameters:
        raise mistake(
            "E0870",
            f"every name in it is a column ({', '.join(titles)}): there is nothing to fit",
            "formula",
        )
    used = [*names, measured] if measured else names
    read = [name for name in dict.fromkeys(used) if name in titles]
    return Formula(residual, formula.strip(), measured, tuple(read), tuple(parameters))


def _sides(text: str) -> tuple[str | None, str]:
    """What is on the left of the first ``=`` outside brackets, None without one, and the rest."""
    for equals in _EQUALS.finditer(text):
        left = text[: equals.start()]
        if all(left.count(a) == left.count(b) for a, b in ("()", "[]")):
            return left.strip(), text[equals.end() :]
    return None, text


def measured_column(wanted: str, titles: Mapping[str, str], data: str) -> str:
    """The name of an existing column given by its name or its title; E0871 if there is none."""
    name = _column(wanted, titles)
    if name in titles:
        return name
    near = closest(wanted, titles)
    advice = f"did you mean '{near[0]}'? " if near else ""
    if wanted == "y" and not near:
        advice = "name what FORMULA predicts, NAME = FORMULA or --y NAME, or write 0 = FORMULA; "
    raise mistake(
        "E0871", f"{data} has no column '{wanted}'; {advice}it has {', '.join(titles)}", data
    )


def _column(wanted: str, titles: Mapping[str, str]) -> str:
    """The name of a column given by its name or by its title in the file."""
    return next((name for name, title in titles.items() if title == wanted), wanted)


def _known_function(name: str) -> str:
    """The arael name of a function of NumPy or `math`."""
    return {
        "arctan2": "atan2",
        "arctan": "atan",
        "arcsin": "asin",
        "arccos": "acos",
        "power": "pow",
        "maximum": "max",
        "minimum": "min",
        "deg2rad": "deg2rad",
        "fabs": "abs",
        "absolute": "abs",
    }.get(name, name)


def _refuse_names(parameters: list[str]) -> None:
    """Reject dotted names and words of the language, which no parameter can be called."""
    for name in parameters:
        first, dot, _ = name.partition(".")
        if dot or first in _RESERVED:
            raise mistake(
                "E0870",
                f"'{name}' is neither a column nor a name for a parameter"
                + (
                    ": a dot reads a part of something" if dot else ": it is a word of the language"
                ),
                "formula",
                f"write a plain name, such as '{name.replace('.', '_') if dot else name + '_'}'",
            )


def _refuse_what_cancels(
    formula: str, parsed: Value, parameters: list[str], titles: Mapping[str, str]
) -> None:
    """Reject parameters without influence on the formula: ``0 * c``, ``c - c``, ``sign(c)``."""
    written = dict.fromkeys(_NAME.findall(formula))
    gone = [name for name in written if name not in titles and _is_symbol(name)]
    gone = [name for name in gone if name not in parameters or _is_flat(parsed, name)]
    if gone:
        which = ", ".join(f"'{name}'" for name in gone)
        raise mistake(
            "E0870",
            f"the formula does not depend on {which}: its derivative is zero everywhere, so the "
            "points do not determine it",
            "formula",
            "remove it",
        )


def _is_symbol(name: str) -> bool:
    """Whether a name is neither a constant nor a word of the language."""
    try:
        return name in sym.free_vars(sym.parse(name))
    except AraelError:
        return False


def _is_flat(parsed: Value, name: str) -> bool:
    return not any(entries(sym.diff(parsed, name)))
