"""What cannot hold together: smallest sets, each member proven by leaving it out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.layout.layout import Layout
from arael.sketch.solve.solver import Solver

#: Constraints without equations: they make two points one, or a number constant.
_JOINTS = ("coincident", "concentric", "lock", "fix")
#: Of these the ends of what cannot move are made, and they are few: they are looked at first.
_HOLDS = ("lock", "fix")
#: For the search among joints; what is not found until then is not named.
_SECONDS = 2.0


def conflict(layout: Layout, solver: Solver, cause: str = "") -> tuple[str, ...]:
    """A smallest set of constraints and dimensions that cannot hold together.

    Each member is proven by leaving it out: the others can be solved then. Empty if all can be
    solved together after all.

    Parameters
    ----------
    cause : a member for sure, if it is one: what was changed last
    """
    if layout.impossible:
        name = cause if cause in layout.impossible else next(iter(layout.impossible))
        return _with_joints(layout, solver, (*layout.rivals(name), name))
    names = _connected(layout, cause)
    if not names or solver.feasible(names):
        return ()
    # What pulls against each other where the residuals are least is a good first guess.
    guess = list(solver.open_candidates(cause))
    if guess and not solver.feasible(guess):
        names = guess
    return _with_joints(layout, solver, smallest(names, cause, solver.feasible))


def _with_joints(layout: Layout, solver: Solver, found: tuple[str, ...]) -> tuple[str, ...]:
    """With the joints that are to blame where a single constraint cannot hold."""
    if len(found) > 1:
        return found
    return (*joints(layout, found, lambda: solver.feasible(found)), *found)


def smallest(
    names: Sequence[str],
    cause: str,
    feasible: Callable[[Sequence[str]], bool],
    until: float = math.inf,
) -> tuple[str, ...]:
    """Of names that cannot hold together as few as still cannot; all if they can.

    Halves are left out, then single ones, from the oldest on, so that what was changed last stays.
    After the time `until`, as few as were found.
    """
    if feasible(list(names)):
        return tuple(names)
    order = [name for name in names if name != cause]
    kept = [*order, cause] if cause else order
    size = max(1, len(order) // 2)
    while True:
        for first in range(0, len(order), size):
            if time.monotonic() > until:
                return tuple(kept)
            block = set(order[first : first + size])
            rest = [name for name in kept if name not in block]
            if len(rest) < len(kept) and rest and not feasible(rest):
                kept = rest
        order = [name for name in order if name in kept]
        if size == 1:
            return tuple(kept)
        size = max(1, size // 2)


def _connected(layout: Layout, cause: str) -> list[str]:
    """Constraints and dimensions in the connected part of `cause`; all without one."""
    document = layout.document
    known = cause in document.constraints or cause in document.dimensions
    found = layout.connected(cause) if known else ()
    return list(found) or [*document.constraints, *document.dimensions]


def joints(layout: Layout, names: Sequence[str], good: Callable[[], bool]) -> tuple[str, ...]:
    """As few coincidences, locks and the like as are to blame; empty if others are.

    They are no equations: points that coincide are one, and a locked point is constant. So each is
    tried by laying the sketch out without it, which is for where no equation is to blame.

    Parameters
    ----------
    names : constraints and dimensions; joints that hang together with them are tried
    good : whether all is well with the sketch as it is laid out in a trial
    """
    document = layout.document
    tried = [name for name in _joints_around(document, names) if name not in names]
    until = time.monotonic() + _SECONDS

    def holds(kept: Sequence[str]) -> bool:
        try:
            with document.transaction("without some joints"):
                for name in tried:
                    if name not in kept:
                        record = replace(document.constraints[name], active=False)
                        document.put("constraints", record)
                layout.refresh()
                raise _TriedError(good())
        except _TriedError as found:
            return found.good

    if not tried or not holds(()):
        return ()
    # Locks alone are to blame most of the time, also where a large drawing hangs together.
    held = [name for name in tried if document.constraints[name].kind in _HOLDS]
    if held and not holds(held):
        tried = held
    found = smallest(tried, "", holds, until)
    return found if time.monotonic() <= until else ()


def _joints_around(document: Document, names: Sequence[str]) -> list[str]:
    """Joints that hang together with constraints and dimensions, in the order of the document."""
    near: set[str] = set()
    for name in names:
        record = document.constraints.get(name) or document.dimensions.get(name)
        near |= _entities(record.args if record is not None else ())
    joints = {
        one.name: _entities(one.args)
        for one in document.constraints.values()
        if one.kind in _JOINTS and one.active
    }
    found: set[str] = set()
    while more := {
        name for name, of in joints.items() if name not in found and not near.isdisjoint(of)
    }:
        found |= more
        near = near.union(*(joints[name] for name in more))
    return [name for name in joints if name in found]


def _entities(args: Sequence[str]) -> set[str]:
    return {parts.name for arg in args if (parts := split_handle(arg)) is not None}


class _TriedError(Exception):
    """Ends a trial, so that the document is as it was."""

    def __init__(self, good: bool) -> None:
        super().__init__()
        self.good = good
