"""The 2D sketch editor: geometry tied by constraints and dimensions.

`Sketch` is its face for Python; `arael sketch` that of the command line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from arael.sketch.sketch import Sketch

__all__ = ["Sketch"]


def __getattr__(name: str) -> Any:
    if name != "Sketch":
        raise AttributeError(f"module 'arael.sketch' has no attribute {name!r}")
    # imported here: start-up time
    from arael.sketch.sketch import Sketch

    return Sketch
