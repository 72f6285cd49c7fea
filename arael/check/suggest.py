"""The nearest name, for help lines."""

from __future__ import annotations

from collections.abc import Iterable

from arael.diagnostics.suggest import closest


def nearest(name: str, candidates: Iterable[str]) -> str:
    """The candidate closest to the misspelt `name`; "" if none is close."""
    near = closest(name, candidates)
    return near[0] if near else ""


def did_you_mean(name: str, candidates: Iterable[str]) -> list[str]:
    """A help line with the closest candidate; empty if none is close."""
    near = nearest(name, candidates)
    return [f"did you mean `{near}`?"] if near else []
