"""Numbers in replies."""

from __future__ import annotations

from collections.abc import Iterable


def shown(number: float) -> str:
    """A number with six significant digits: ``12``, ``0.333333``, ``1.5e-07``."""
    text = f"{number:.6g}"
    return "0" if text == "-0" else text


def place(x: float, y: float) -> str:
    """Coordinates: ``(5, 3)``."""
    return f"({shown(x)}, {shown(y)})"


def exact(number: float) -> str:
    """A number such that it is read back as the same: ``0.1``, ``-3``."""
    number = float(number)
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def listed(items: Iterable[str], most: int = 6) -> str:
    """``a, b, c and 4 more``."""
    names = list(items)
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[:most])} and {len(names) - most} more"
