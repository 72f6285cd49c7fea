"""Variants without a solution, each with the rows that contradict each other."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.constrained.formulas import FORMULAS, Formulas

_CONFLICTS: dict[str, tuple[tuple[str, ...], frozenset[str]]] = {
    "hs6": (("x2 == x1^2 + 1",), frozenset({"row1", "row2"})),
    "hs14": (("x1 - 2 * x2 >= 0",), frozenset({"row1", "row3"})),
    "hs18": (("x1 + x2 <= 3",), frozenset({"row1", "row3"})),
    "hs22": (("x1 + x2 >= 3",), frozenset({"row1", "row3"})),
    "hs28": (("x1 + 2 * x2 + 3 * x3 >= 2",), frozenset({"row1", "row2"})),
    "hs42": (("x1 == 3",), frozenset({"row1", "row3"})),
    "hs48": (
        ("x1 + x2 >= 8", "x3 + x4 + x5 >= 0"),
        frozenset({"row1", "row3", "row4"}),
    ),
    "hs52": (("x2 == 1", "x1 == 1"), frozenset({"row1", "row4", "row5"})),
    "hs60": (("x1 * (1 + x2^2) + x3^4 <= 1",), frozenset({"row1", "row2"})),
    "hs65": (("x1 + x2 + x3 >= 13",), frozenset({"row1", "row6"})),
}


def variants() -> list[tuple[Formulas, frozenset[str]]]:
    """The problems, and names of the rows of the only minimal conflict of each."""
    known = {one.name: one for one in FORMULAS}
    return [
        (replace(known[name], rows=(*known[name].rows, *more)), conflict)
        for name, (more, conflict) in _CONFLICTS.items()
    ]
