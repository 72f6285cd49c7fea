"""Which of the instruction sets that models are shipped for this processor runs."""

from __future__ import annotations

import contextlib
import os
import platform
from functools import lru_cache

# x86-64 levels, best first, with the flags by which Linux names what each adds.
LEVELS = {
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"},
}


@lru_cache(maxsize=1)
def flags() -> frozenset[str]:
    """Feature flags of the processor as Linux lists them; empty elsewhere."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith(("flags", "Features")):
                return frozenset(line.partition(":")[2].split())
    return frozenset()


def shipped_targets() -> list[str]:
    """Targets of models that are compiled for other machines of this platform."""
    if platform.system() == "Linux" and platform.machine() == "x86_64":
        return list(LEVELS)
    return ["baseline"]


def is_portable() -> bool:
    """Whether arael is built for other machines, too: `ARAEL_PORTABLE` is 1, as for wheels."""
    return os.environ.get("ARAEL_PORTABLE", "0") not in ("", "0")


def built_targets() -> list[str]:
    """Targets of a build of arael: the best one that runs here; all if the build is portable."""
    return shipped_targets() if is_portable() else usable_targets()[:1]


def usable_targets() -> list[str]:
    """Shipped targets that run here, best first."""
    if platform.system() == "Linux" and platform.machine() == "x86_64":
        lacking_v3 = LEVELS["x86-64-v3"] - flags()
        if lacking_v3:
            return []
        return [t for t, needed in LEVELS.items() if needed <= flags()]
    return ["baseline"]
