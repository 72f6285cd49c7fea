"""Texts of dimensions."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount, Dimension

PREFIXES: Mapping[str, str] = MappingProxyType(
    {"radius": "R", "radius_b": "R", "diameter": "⌀", "arc_length": "◠ ", "total_length": "Σ ",
     "area": "A ", "hdistance": "", "vdistance": ""}
)  # fmt: skip

_LITERAL = re.compile(
    r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*(um|mm|cm|m|in|ft|deg|rad|°)?", re.IGNORECASE
)
"""A number with an optional unit; anything else is an expression."""


def number_text(number: float) -> str:
    """Up to six digits, without trailing zeros; a true minus sign."""
    text = f"{number:.6g}"
    return "0" if float(text) == 0.0 else text.replace("-", "−")


def dimension_text(
    dimension: Dimension, unit: str, measured: float | None = None, formulas: bool = True
) -> str:
    """What a drawing shows: value or range, ``⌀`` and ``°``; derived ones in parentheses.

    Parameters
    ----------
    measured : value to show for a derived dimension
    formulas : whether ``ƒ`` marks a value that follows an expression, as in the editor
    """
    quantity = DIMENSIONS[dimension.kind].quantity
    suffix = {"angle": "°", "area": f" {unit}²"}.get(quantity, "")

    def shown(amount: Amount) -> str:
        return f"{number_text(amount.number)}{suffix}"

    if dimension.value is not None:
        number = dimension.value.number
        if dimension.derived and measured is not None:
            number = measured
        body = f"{number_text(number)}{suffix}"
        if formulas and not (dimension.derived or _LITERAL.fullmatch(dimension.value.text.strip())):
            body = f"ƒ {body}"
    elif dimension.low is not None and dimension.high is not None:
        body = f"{shown(dimension.low)} … {shown(dimension.high)}"
    elif dimension.low is not None:
        body = f"≥ {shown(dimension.low)}"
    else:
        assert dimension.high is not None
        body = f"≤ {shown(dimension.high)}"
    prefix = PREFIXES.get(dimension.kind, "")
    if body[0] in "ƒ≥≤":  # apart from the sign before it: ``⌀ ƒ 5``
        prefix = f"{prefix.strip()} " if prefix else ""
    text = f"{prefix}{body}"
    if dimension.broken:
        text = f"{text} ⚠"
    return f"({text})" if dimension.derived else text
