"""Figures of problems and solutions, drawn with matplotlib; maps in the viewer Rerun."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    if name in ("rerun", "rerun_solve"):
        # imported here: start-up time
        from arael.plot import viewer

        return getattr(viewer, name)
    raise AttributeError(f"module 'arael.plot' has no attribute {name!r}")
