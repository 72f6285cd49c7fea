"""Estimated compile time of kernels, by the length of their source, scaled to this machine.

The constants are those of one machine (2 cores of an AMD EPYC, GCC 12). They are scaled by the
times of earlier compilations on this machine, which the cache records.
"""

from __future__ import annotations

import re
import statistics
from collections.abc import Iterable

from arael.compiler.cache.kernels import recent

# Seconds for a module and for each line of code, Cython and the C compiler together. No function is
# so long that its length counts more than once (`arael.compiler.parts`). Fitted to four standard
# models and four large constraints, which take 0.4 to 1.4 of it.
_MODULE = 0.55
_LINE = 1.0e-3

# Compilations of this machine that are looked at.
_RECENT = 5

_CODE = re.compile(r"^ +[^# \n]", re.MULTILINE)


def expected_seconds(source: str) -> float:
    """Seconds that the Cython source of kernels will take from here to a module."""
    return predicted(source) * _machine(_finished())


def predicted(source: str) -> float:
    """Seconds on the machine of the constants."""
    return _MODULE + _LINE * len(_CODE.findall(source))


def shown(seconds: float) -> str:
    """An estimate as it is shown: ``2 s``, ``15 s``, ``3 min``."""
    if seconds >= 90:
        return f"{round(seconds / 60)} min"
    step = 5 if seconds > 12 else 1
    return f"{max(step, step * round(seconds / step))} s"


def _finished() -> Iterable[tuple[str, float]]:
    """Source and seconds of the latest compilations here."""
    for entry in recent(_RECENT):
        taken = entry.manifest.seconds
        for path in entry.folder.glob("*.pyx"):
            if {"cython", "compile"} <= set(taken):
                # Not verified: an entry may be damaged.
                text = path.read_text(encoding="utf-8", errors="replace")
                yield text, taken["cython"] + taken["compile"]


def _machine(finished: Iterable[tuple[str, float]]) -> float:
    """How much slower this machine is than that of the constants: 1 if nothing is known."""
    ratios = [taken / predicted(source) for source, taken in finished]
    return statistics.median(ratios) if ratios else 1.0
