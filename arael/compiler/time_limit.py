"""How long the C compiler may take."""

from __future__ import annotations

import math
import os

from arael.diagnostics.records import AraelError, Diagnostic

VARIABLE = "ARAEL_COMPILE_TIMEOUT"

DEFAULT = 600.0
"""Seconds. A SLAM model takes 2, the largest that arael accepts some minutes."""


def compile_limit() -> float:
    """Seconds that the C compiler may take for one model: ``ARAEL_COMPILE_TIMEOUT``, else 600.

    Raises
    ------
    AraelError
        E0809 if the variable holds no positive number.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return DEFAULT
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise AraelError(
            Diagnostic(
                "E0809",
                f"{text!r} is no number of seconds",
                origin=VARIABLE,
                help=(f"write a positive number, as in `export {VARIABLE}=1200`",),
            )
        )
    return seconds
