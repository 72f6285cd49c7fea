"""Texts of dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount, Dimension

PREFIXES: Mapping[str, str] = MappingProxyType(
    {"radius": "R", "radius_b": "R", "diameter": "⌀", "arc_length": "◠ ", "total_length": "Σ ",
     "area": "A ", "hdistance": "", "vdistance": ""}
)  # fmt: skip


def number_text(number: float) -> str:
    """Up to six digits, without trailing zeros; a true minus sign."""
    text = f"{number:.6g}"
    return "0" if float(text) == 0.0 else text.replace("-", "−")


def dimension_text(dimension: Dimension, unit: str, measured: float | None = None) -> str:
    """What a drawing shows: value or range, ``⌀`` and ``°``; derived ones in parentheses.

    Parameters
    ----------
    measured : value to show for a derived dimension
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
        if not dimension.derived and not _is_literal(dimension.value.text):
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


def _is_literal(text: str) -> bool:
    """Whether an expression is a number with an optional unit."""
    first = text.strip().split(" ")[0].rstrip("°") if text.strip() else "0"
    try:
        float(first.rstrip("mcinder") or "x")
    except ValueError:
        return False
    return True
