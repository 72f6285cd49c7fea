"""What nothing asks to turn keeps its direction.

Steps of least change of the coordinates turn a figure that is held at one point: a rectangle
becomes longer with less change where it turns. A figure that is free to turn as a whole is turned
back, so that its lines have the directions that they had, as nearly as it can be.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from arael.sketch.layout.layout import Layout
    from arael.sketch.layout.part import Part

Array = NDArray[np.float64]

#: A turn is free if it changes no residual by more than this share of the way that points go.
_FREE = 1e-9
#: Turns (radians) that are rounding.
_NONE = 1e-9


def turned_back(of: Layout | Part, ends: NDArray[np.int64], before: Array, x: Array) -> Array:
    """Solved unknowns with every figure turned back that can turn, (n,).

    Parameters
    ----------
    of : whose unknowns they are
    ends : (k, 4) where in `x` lines begin and end
    before, x : where the solve began, and ended
    """
    label = of.components()[of.rows.m :]
    used = np.zeros(of.rows.n, dtype=bool)
    used[of.rows.indices] = True
    fixed = of.held()
    ends = ends[(used | fixed)[ends].all(axis=1)]
    moved = (x != before)[ends].any(axis=1)
    own = np.where(used[ends[moved, 0]], ends[moved, 0], ends[moved, 2])
    found = x
    for figure in np.unique(label[own[used[own]]]).tolist():
        inside = (label == figure) & used
        turned = _turned(of, before, found, ends[inside[ends].any(axis=1)], inside)
        found = found if turned is None else turned
    return found


def _turned(
    of: Layout | Part,
    before: Array,
    x: Array,
    lines: NDArray[np.int64],
    inside: NDArray[np.bool_],
) -> Array | None:
    """The unknowns with one figure turned back; None where it cannot turn, or need not."""
    old, new = _edges(before, lines), _edges(x, lines)
    angle = float(np.angle((new.conj() * old).sum()))
    return None if abs(angle) < _NONE else _turn(of, x, lines, inside, angle)


def turned_along(layout: Layout, line: int, angle: float) -> Array | None:
    """All unknowns with the figure of a line turned as a whole; None where it is not free to.

    Parameters
    ----------
    line : offset of its first number in the document
    angle : radians
    """
    x = layout.gather().copy()
    used = np.zeros(layout.rows.n, dtype=bool)
    used[layout.rows.indices] = True
    own = next((at for at in layout.roots(line + np.arange(4)).tolist() if used[at]), None)
    if own is None:
        return None
    label = layout.components()[layout.rows.m :]
    inside = (label == label[own]) & used
    ends = layout.line_ends()
    return _turn(layout, x, ends[inside[ends].any(axis=1)], inside, angle)


def _turn(
    of: Layout | Part, x: Array, lines: NDArray[np.int64], inside: NDArray[np.bool_], angle: float
) -> Array | None:
    """The unknowns with one figure turned by an angle; None where it is not free to turn."""
    axes = of.axes()
    if (axes[inside] == 0).any():  # contacts and parameters of its own
        return None
    xs = np.flatnonzero(inside & (axes == 1))
    held = lines[~inside[lines[:, [0, 2]]].all(axis=1)]
    if len(held):
        at = held[0, 0] if not inside[held[0, 0]] else held[0, 2]
        pivot = complex(x[at], x[at + 1])
    else:
        pivot = complex(x[xs].mean(), x[xs + 1].mean())
    arms = x[xs] + 1j * x[xs + 1] - pivot
    way = np.zeros(len(x))
    way[xs], way[xs + 1] = -arms.imag, arms.real
    way[np.flatnonzero(inside & (axes == 4))] = 1.0
    _, entries = of.rows.jacobian(x)
    row_of = np.repeat(np.arange(of.rows.m), np.diff(of.rows.indptr))
    change = np.bincount(row_of, entries * way[of.rows.indices], minlength=of.rows.m)
    if np.abs(change).max(initial=0.0) > _FREE * np.abs(way).max():
        return None
    found = x.copy()
    places = pivot + arms * np.exp(1j * angle)
    found[xs], found[xs + 1] = places.real, places.imag
    found[np.flatnonzero(inside & (axes == 4))] += angle
    return found


def _edges(x: Array, lines: NDArray[np.int64]) -> NDArray[np.complex128]:
    a, b, c, d = x[lines].T
    found: NDArray[np.complex128] = (c - a) + 1j * (d - b)
    return found
