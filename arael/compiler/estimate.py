"""How long kernels will take to compile: by the length of their functions, scaled to this machine.

The constants are those of one machine (2 cores of an AMD EPYC, GCC 12). What compilations here have
taken, as the cache records it, scales them.
"""

from __future__ import annotations

import re
import statistics
from collections.abc import Iterable

from arael.compiler.cache.kernels import recent

# Seconds for a module, for each line of code, and for each pair of lines in one function: the C
# compiler's time grows faster than the length of a function.
_MODULE = 0.6
_LINE = 0.8e-3
_PAIR = 1.3e-6

# Compilations of this machine that are looked at.
_RECENT = 5

_FUNCTION = re.compile(r"^cdef [^\n]*:\n((?: .*\n|\n)+)", re.MULTILINE)
_CODE = re.compile(r"^ +[^# \n]", re.MULTILINE)


def expected_seconds(source: str) -> float:
    """Seconds that the Cython source of kernels will take from here to a module."""
    return predicted(source) * _machine(_finished())


def predicted(source: str) -> float:
    """Seconds on the machine of the constants."""
    lengths = [len(_CODE.findall(body)) for body in _FUNCTION.findall(source)]
    return _MODULE + _LINE * sum(lengths) + _PAIR * sum(n * n for n in lengths)


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
                yield path.read_text(encoding="utf-8"), taken["cython"] + taken["compile"]


def _machine(finished: Iterable[tuple[str, float]]) -> float:
    """How much slower this machine is than that of the constants: 1 if nothing is known."""
    ratios = [taken / predicted(source) for source, taken in finished]
    return statistics.median(ratios) if ratios else 1.0
