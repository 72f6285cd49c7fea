"""The nearest name, for the help lines of this room."""

from __future__ import annotations

from collections.abc import Iterable

from arael.diagnostics.suggest import closest


def nearest(name: str, candidates: Iterable[str]) -> str:
    """The candidate that `name` most likely misspells; "" if none is near."""
    found = closest(name, candidates)
    return found[0] if found else ""


def did_you_mean(name: str, candidates: Iterable[str]) -> list[str]:
    """A help line with the nearest candidate; empty if none is near."""
    near = nearest(name, candidates)
    return [f"did you mean `{near}`?"] if near else []
