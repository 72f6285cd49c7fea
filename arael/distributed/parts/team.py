"""The parts as the loop sees them: sums over parts, and steps of the whole."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.distributed.parts import requests
from arael.distributed.parts.boundary import Boundary, BoundarySystem, scalars_of
from arael.distributed.parts.components import Joined, joined_components
from arael.distributed.parts.executors import Call, Executor, lost_too_often
from arael.distributed.parts.requests import BoundaryStep, Damped, PartRecipe, Point, Right
from arael.distributed.parts.shares import Share

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


_SMALL = 4_000_000
"""Bytes of the parts' S up to which the boundary is solved in the calling process."""

_REPEATS = 20
"""Times that the boundary is asked again, since a part's answer did not reach it."""


@dataclass
class Traffic:
    """Bytes of arrays: sent to the parts, back, and from the parts to the boundary."""

    out: int = 0
    back: int = 0
    reduced: int = 0
    rounds: int = 0


@dataclass(frozen=True)
class Places:
    """Where the scalars of a part are in the whole system.

    Attributes
    ----------
    interior, boundary : scalars of the whole system
    of_interior, of_boundary : the same scalars in the part
    on_boundary : the boundary's scalars among those of all boundaries
    every : (local,) scalar of the whole system for each of the part
    """

    interior: Ints
    boundary: Ints
    of_interior: Ints
    of_boundary: Ints
    on_boundary: Ints
    every: Ints


class Team:
    """What the remote evaluation and solver of `arael.runtime.levenberg` ask of a problem in parts.

    Parameters
    ----------
    executor : where requests are answered
    recipes : of the parts
    sizes : (blocks,) scalars of each block of the whole system
    widths : per entity, its stored scalars
    """

    def __init__(
        self, executor: Executor, recipes: Sequence[PartRecipe], sizes: Ints, widths: Sequence[int]
    ) -> None:
        self.traffic = Traffic()
        self._executor = executor
        self._run = recipes[0].run if recipes else ""
        self._shares = [recipe.share for recipe in recipes]
        self._widths = list(widths)
        self._size, self._sizes = int(sizes.sum()), sizes
        self.boundary, self.scalars = boundary_of(self._shares, sizes)
        self._places = [places_of(s, sizes, self.boundary, k) for k, s in enumerate(self._shares)]
        self._recipes = list(recipes)
        self._number = 0
        self._last: tuple[list[Floats], list[Point]] = ([], [])
        self._at: list[Point] = []
        self._own: Floats = np.zeros(0)
        self._on_bounds: Ints = np.zeros(0, dtype=np.int64)
        self._joined: Joined | None = None
        self._active: Bools | None = None  # (components + 1,); None: they are solved as one
        self._ended: Bools | None = None  # (size,)
        self._acting = list(range(len(recipes)))
        self._factor: tuple[list[Damped], Floats] | None = None
        self._factored = -1
        self._system: tuple[BoundarySystem, int] | None = None
        self._descent: Floats = np.zeros(0)  # negative gradient at the state of the parts
        self._curved: tuple[Floats, Floats] = (np.zeros(0), np.zeros(1))
        self._is_small = sum(8 * len(at.boundary) ** 2 for at in self._places) <= _SMALL

    def describe(self) -> list[tuple[int, bool, int]]:
        """Of each part `requests.describe`."""
        return self._ask(requests.describe, [((), ())] * len(self._shares))

    def components(self) -> Joined:
        """The connected components of the whole, from those of the parts."""
        if self._joined is None:
            found = self._ask(requests.components, [((), ())] * len(self._shares))
            self.traffic.back += sum(labels.nbytes + guarded.nbytes for labels, guarded in found)
            self._joined = joined_components(self._shares, len(self._sizes), found)
        return self._joined

    def explain(self, states: list[Floats], derivatives: bool) -> Diagnostic | None:
        """The first residual (or derivative) that is not finite at some states."""
        whole = [(point, derivatives) for point in self._point(states)]
        found = self._ask(requests.explain, [(args, args) for args in whole])
        return next((one for one in found if one is not None), None)

    # --- what the loop asks for ----------------------------------------------------------------

    def cost(self, states: list[Floats]) -> float:
        """Sum of squared residuals at states, one array (rows, state) per entity."""
        points = self._point(states)
        self.traffic.out += sum(point.x.nbytes for point in points if point.x is not None)
        return float(sum(self._ask(requests.cost, [((p,), (p,)) for p in points])))

    def choose(self, active: Bools | None) -> None:
        """Solve components separately, of which those go on; None: solve all as one.

        Parameters
        ----------
        active : (components + 1,); the last for instances that read nothing that is solved for
        """
        self._active, self._ended = active, None
        self._acting = list(range(len(self._shares)))
        if active is not None:
            joined = self.components()
            self._acting = [k for k, of in enumerate(joined.of_part) if active[of].any()]
            if not active[:-1].all():
                self._ended = ~active[np.repeat(joined.of_block, self._sizes)]

    def costs(self, states: list[Floats]) -> Floats:
        """(components + 1,) costs at states; 0 of components that have ended."""
        active, of_part = self._active, self.components().of_part
        assert active is not None
        points = self._point(states)
        calls = []
        for k in self._acting:
            point, mine = points[k], active[of_part[k]]
            assert point.x is not None
            self.traffic.out += point.x.nbytes + mine.nbytes
            calls.append(self._call(k, (point, mine), (point, mine)))
        total = np.zeros(len(active))
        for k, found in zip(self._acting, self._asked(requests.costs, calls), strict=True):
            self.traffic.back += found.nbytes
            np.add.at(total, of_part[k], found)
        return np.where(active, total, 0.0)

    def linearise(self, states: list[Floats]) -> tuple[float, Floats, Floats]:
        """Cost, J'r and the diagonal of J'J; 0 where components have ended."""
        self._at = points = self._point(states)
        if self._active is not None:
            active = [self._active[of] for of in self.components().of_part]
            self._at = points = [
                Point(p.number, p.x, own) for p, own in zip(points, active, strict=True)
            ]
        gradient, diagonal = np.zeros(self._size), np.zeros(self._size)
        total = 0.0
        calls = []
        for k in self._acting:
            point = points[k]
            calls.append(self._call(k, (Point(point.number, None, point.active),), (point,)))
        answers = self._asked(requests.linearise, calls)
        for k, (cost, first, second) in zip(self._acting, answers, strict=True):
            at = self._places[k]
            total += cost
            self.traffic.back += first.nbytes + second.nbytes
            for whole, mine in ((at.interior, at.of_interior), (at.boundary, at.of_boundary)):
                gradient[whole] += first[mine]
                diagonal[whole] += second[mine]
        self._own, self._descent = diagonal, -gradient
        self._on_bounds = self._on_bounds[:0]
        self._curved = (np.zeros(0), np.zeros(1))
        return total, gradient, diagonal

    def hold(self, scalars: Ints) -> None:
        """Leave scalars that stand at a bound out of the factors at the present states."""
        self._on_bounds = scalars

    def _left_out(self) -> Bools | None:
        """(size,) scalars that factors leave out: on a bound, or of a component that has ended."""
        if not len(self._on_bounds) and self._ended is None:
            return None
        found = np.zeros(self._size, dtype=bool) if self._ended is None else self._ended.copy()
        found[self._on_bounds] = True
        return found

    def curvature(self, step: Floats) -> Floats:
        """``step' J'J step`` with the present linearisation, (1,) or (components,)."""
        known, total = self._curved
        if len(known) and np.array_equal(known, step):
            return total
        apart = self._active is not None
        calls = []
        for k in self._acting:
            point, at = self._at[k], self._places[k]
            mine = np.zeros(len(at.every))
            mine[at.of_interior] = step[at.interior]
            mine[at.of_boundary] = step[at.boundary]
            self.traffic.out += mine.nbytes
            calls.append(self._call(k, (point.named(), mine, apart), (point, mine, apart)))
        found = self._asked(requests.curvature, calls)
        return self._sums(zip(self._acting, found, strict=True))

    def _sums(self, found: Iterable[tuple[int, Floats]]) -> Floats:
        """Sums over parts of what each has: (1,), or by component (components,)."""
        if self._active is None:
            return np.asarray(np.sum([np.zeros(1), *(one for _, one in found)], axis=0))
        total = np.zeros(len(self._active) - 1)
        for k, one in found:
            np.add.at(total, self.components().of_part[k][:-1], one)
        return total

    def factor(self, damped: Floats, right: Floats) -> tuple[int, Floats | None]:
        """Factorise with a damped diagonal and solve; 1 + the scalar that failed and None."""
        number = self._next()
        out = self._left_out()
        factors = [
            Damped(number, p, damped[at.interior], _places_in(out, at))
            for p, at in zip(self._at, self._places, strict=True)
        ]
        own = self._own if out is None else np.where(out, 0.0, self._own)
        for k in self._acting:
            at = self._places[k]
            held = factors[k].held
            self.traffic.out += 8 * len(at.interior) + (0 if held is None else held.nbytes)
            self.traffic.reduced += 8 * len(at.boundary) * (len(at.boundary) + 1)
        self._factor = (factors, (damped - own)[self.scalars])
        return self._solved(self._rights(right), right)

    def solve(self, right: Floats) -> Floats:
        """Solve with the last factor."""
        failed, found = self._solved(self._rights(right), right, curved=True)
        if found is None:
            raise ArithmeticError(f"a factor failed when it was used again, at scalar {failed}")
        return found

    def _rights(self, right: Floats) -> list[Right | None]:
        """Right-hand sides of the interiors; the parts have that of the gradient."""
        number = self._next()
        rights: list[Right | None] = [None] * len(self._places)
        known = np.array_equal(right, self._descent)
        for k in self._acting:
            inside = self._places[k].interior
            rights[k] = Right(number, None, self._at[k]) if known else Right(number, right[inside])
            self.traffic.out += 0 if known else 8 * len(inside)
        return rights

    def inverse(self, scalars: Ints) -> Floats:
        """(k, k) entries of the inverse between scalars of one block, by the last factor.

        Only the part that has the block is asked for its sweeps.
        """
        part = next(
            (k for k, at in enumerate(self._places) if np.isin(scalars[0], at.interior)), -1
        )
        found = []
        for scalar in scalars:
            rights: list[Right | None] = [None] * len(self._places)
            unit = (self.scalars == scalar).astype(np.float64)
            if part < 0:
                step = self._on_boundary(rights, unit, [])
                assert step.x is not None
                found.append(step.x[np.searchsorted(self.scalars, scalars)])
                continue
            place = self._places[part]
            own = (place.interior == scalar).astype(np.float64)
            rights[part] = Right(self._next(), own)
            step = self._on_boundary(rights, unit, self._sweep(rights))
            assert step.x is not None
            ((x, _),) = self._substituted(rights, step.x)
            found.append(x[np.searchsorted(place.interior, scalars)])
        return np.stack(found, axis=1)

    def _solved(
        self, rights: Sequence[Right | None], right: Floats, curved: bool = False
    ) -> tuple[int, Floats | None]:
        """Sweep, solve the boundary and substitute; or 1 + the scalar that failed and None.

        `curved`: the curvature along the solution will be asked for.
        """
        swept = self._sweep(rights)
        asked = [self._places[k] for k, one in enumerate(rights) if one is not None]
        for at, (failed, _) in zip(asked, swept, strict=True):
            if failed:
                return 1 + int(at.every[failed - 1]), None
        step = self._on_boundary(rights, right[self.scalars], swept)
        if step.x is None:
            return 1 + int(self.scalars[step.failed - 1]), None
        x = np.zeros(self._size)
        x[self.scalars] = step.x
        found = self._substituted(rights, step.x, curved)
        for at, (own, _) in zip(asked, found, strict=True):
            self.traffic.back += own.nbytes
            x[at.interior] = own
        if curved:
            total = self._sums(zip(self._acting, (own for _, own in found), strict=True))
            self._curved = (x.copy(), total)
        return 0, x

    def _sweep(
        self, rights: Sequence[Right | None], only: Sequence[int] | None = None
    ) -> list[Any]:
        """Ask the parts with a right-hand side for their forward sweeps; see `requests.sweep`."""
        assert self._factor is not None
        factors = self._factor[0]
        # Diagonals are sent with the first right-hand side of a factor.
        first = factors[0].number != self._factored if factors else False
        wanted: requests.Wanted = "nothing"
        if self._is_small:
            wanted = "whole" if first else "right"
        calls = []
        for k in range(len(rights)) if only is None else only:
            right = rights[k]
            if right is None:
                continue
            damped = factors[k]
            thin = Damped(
                damped.number,
                damped.at.named(),
                damped.diagonal if first else None,
                damped.held if first else None,
            )
            own = Right(right.number, right.values, right.at and right.at.named())
            calls.append(self._call(k, (thin, own, wanted), (damped, right, wanted)))
        self._factored = factors[0].number if factors else -1
        return self._asked(requests.sweep, calls)

    def _on_boundary(
        self, rights: Sequence[Right | None], right: Floats, swept: Sequence[Any]
    ) -> BoundaryStep:
        """The solution of the boundary system, here or on a worker."""
        if self._is_small:
            return self._on_boundary_here(rights, right, swept)
        assert self._factor is not None
        factors, added = self._factor
        rights = list(rights)
        for _ in range(_REPEATS):
            sources = [
                one
                and (
                    self._executor.source(k),
                    (self._recipes[k].name, factors[k].named(), one.named()),
                )
                for k, one in enumerate(rights)
            ]
            idle = tuple(k for k in range(len(rights)) if k not in self._acting)
            rest = (factors[0].number if factors else 0, sources, added, right, idle)
            full = partial(_all_of, self._run, self.boundary, rest)
            call = Call(0, (self._run, None, *rest), full)
            (step,) = self._asked(requests.solve_boundary, [call])
            found: BoundaryStep = step
            if not found.missing:
                return found
            for k in found.missing:
                if rights[k] is None:  # of which only the matrix is missing
                    rights[k] = Right(self._next(), np.zeros(len(self._places[k].interior)))
            self._sweep(rights, found.missing)
        raise lost_too_often("the answers of parts do not reach the worker of the boundary")

    def _on_boundary_here(
        self, rights: Sequence[Right | None], right: Floats, swept: Sequence[Any]
    ) -> BoundaryStep:
        """A small system is solved in this process, from what came with the sweeps."""
        assert self._factor is not None
        factors, added = self._factor
        answers = iter(swept)
        parts = [None if one is None else next(answers)[1] for one in rights]
        number = factors[0].number if factors else 0
        system, factor = self._system or (BoundarySystem(self.boundary), -1)
        if factor != number:
            failed = system.factorise([one and one.matrix for one in parts], added)
            self._system = (system, -1 if failed else number)
            if failed:
                return BoundaryStep(None, failed)
        return BoundaryStep(system.solve([one and one.right for one in parts], right))

    def _substituted(
        self, rights: Sequence[Right | None], boundary: Floats, curved: bool = False
    ) -> list[tuple[Floats, Floats]]:
        """Solutions of the interiors of the parts with a right-hand side, and curvatures."""
        assert self._factor is not None
        calls = []
        for k, right in enumerate(rights):
            if right is not None:
                damped, own = self._factor[0][k], boundary[self._places[k].on_boundary]
                at = self._at[k] if curved else None
                apart = self._active is not None
                thin = (damped.named(), right.named(), own, at and at.named(), apart)
                calls.append(self._call(k, thin, (damped, right, own, at, apart)))
        return self._asked(requests.substitute, calls)

    # --- requests ------------------------------------------------------------------------------

    def _next(self) -> int:
        self._number += 1
        return self._number

    def _call(self, part: int, thin: tuple[Any, ...], full: tuple[Any, ...]) -> Call:
        recipe = self._recipes[part]
        return Call(part, (recipe.name, *thin), lambda: (recipe, *full))

    def _ask(
        self, function: Any, arguments: Sequence[tuple[tuple[Any, ...], tuple[Any, ...]]]
    ) -> list[Any]:
        """Answers of all parts; arguments are those for a part that has the rest, and all."""
        return self._asked(function, [self._call(k, *both) for k, both in enumerate(arguments)])

    def _asked(self, function: Any, calls: Sequence[Call]) -> list[Any]:
        """Answers to requests, each exactly once, in their order."""
        self.traffic.rounds += 1
        return self._executor.ask(function, calls)

    def _point(self, states: list[Floats]) -> list[Point]:
        """The states of the parts; those of the last call if they are the same."""
        known, points = self._last
        xs = [self._stored(share, states) for share in self._shares]
        same = len(known) == len(xs) and all(map(np.array_equal, xs, known))
        if not same:
            number = self._next()
            points = [Point(number, x) for x in xs]
            self._last = (xs, points)
        return points

    def _stored(self, share: Share, states: list[Floats]) -> Floats:
        found = [np.zeros(0)]
        for state, rows, width in zip(states, share.entity_rows, self._widths, strict=True):
            found.append(state[rows, :width].ravel())
        return np.concatenate(found)


def _places_in(chosen: Bools | None, at: Places) -> Ints | None:
    """Scalars of a part that are chosen of the whole."""
    return None if chosen is None else np.flatnonzero(chosen[at.every])


def _all_of(run: str, boundary: Boundary, rest: tuple[Any, ...]) -> tuple[Any, ...]:
    return (run, boundary, *rest)


def boundary_of(shares: Sequence[Share], sizes: Ints) -> tuple[Boundary, Ints]:
    """The boundary of all parts, and its scalars in the whole system."""
    own = [share.blocks[share.boundary] for share in shares]
    every = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *own]))
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    of_part = tuple(np.searchsorted(every, blocks) for blocks in own)
    return Boundary(sizes[every], of_part), scalars_of(offsets, every)


def places_of(share: Share, sizes: Ints, boundary: Boundary, number: int) -> Places:
    """Where the scalars of a part are."""
    offsets = np.concatenate(([0], np.cumsum(sizes)))
    every = scalars_of(offsets, share.blocks)
    block = np.repeat(np.arange(len(share.blocks)), sizes[share.blocks])
    inside = np.flatnonzero(share.interior[block])
    between = np.flatnonzero(share.boundary[block])
    return Places(
        every[inside],
        every[between],
        inside,
        between,
        boundary.scalars(boundary.of_part[number]),
        every,
    )


__all__ = ["PartRecipe", "Team", "Traffic"]
