"""Values with their standard deviations, as text: the digits of a value follow its uncertainty."""

from __future__ import annotations

import math

_SIGNIFICANT = 2
"""Significant digits of a standard deviation, and of a value that is far below it."""
_MOST = 15
"""Most significant digits: what every double keeps as text (`sys.float_info.dig`)."""
_PLAIN = range(-6, 5)
"""Powers of ten of the last digit of standard deviations that are written without an exponent."""
_LEAST = -5
"""Power of ten of the first digit of the smallest value that is written without an exponent."""


def measured(value: float | None, sigma: float | None, digits: int = 6) -> tuple[str, str]:
    """Text of a value and of its standard deviation.

    A value ends with the second significant digit of its standard deviation (JCGM 100:2008, "Guide
    to the expression of uncertainty in measurement", 7.2.6), but has at most fifteen digits, and
    two where it is far below its standard deviation.

    Parameters
    ----------
    value, sigma : None where there is none, of which the text is ""
    digits : significant digits of a value whose standard deviation is missing, zero or not finite
    """
    number = "" if value is None else rounded(value, sigma, digits)
    place = _place(sigma)
    if sigma is None or place is None:
        return number, "" if sigma is None else f"{sigma:g}"
    if place not in _PLAIN or ("e" in number and abs(value or 0.0) > sigma):
        return number, f"{sigma:.{_SIGNIFICANT - 1}e}"
    return number, _fixed(sigma, place)


def rounded(value: float, sigma: float | None, digits: int = 6) -> str:
    """Text of a value alone, as `measured` rounds it; also of the ends of its interval."""
    place = _place(sigma)
    if place is None or not math.isfinite(value):
        return f"{value:.{digits}g}"
    if not value:
        return _fixed(0.0, place if place in _PLAIN else 0)
    first = _exponent(value)
    count = min(first - place + 1, _MOST) if first >= place else _SIGNIFICANT
    last = first - count + 1
    if first < _LEAST or last >= _PLAIN.stop:
        return f"{value:.{count - 1}e}"
    return _fixed(value, last)


def _place(sigma: float | None) -> int | None:
    """Power of ten of the last significant digit of a standard deviation; None without one."""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0:
        return None
    return _exponent(float(f"{sigma:.{_SIGNIFICANT - 1}e}")) - _SIGNIFICANT + 1


def _exponent(value: float) -> int:
    """Power of ten of the first digit."""
    return int(f"{value:e}".partition("e")[2])


def _fixed(value: float, place: int) -> str:
    """Text without an exponent, rounded to a power of ten."""
    return f"{round(value, -place):.{max(-place, 0)}f}"
