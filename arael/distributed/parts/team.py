"""The parts as the loop sees them: sums over parts, and steps of the whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.distributed.parts import requests
from arael.distributed.parts.boundary import Boundary, scalars_of
from arael.distributed.parts.executors import Executor
from arael.distributed.parts.requests import Damped, PartRecipe, Point, Right
from arael.distributed.parts.shares import Share

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    """What `arael.runtime.levenberg.remote` asks of a problem in parts.

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
        self._size = int(sizes.sum())
        self.boundary, self.scalars = boundary_of(self._shares, sizes)
        self._places = [places_of(s, sizes, self.boundary, k) for k, s in enumerate(self._shares)]
        self._recipes = [executor.submit(_same, recipe, part=k) for k, recipe in enumerate(recipes)]
        self._home_of_boundary = executor.submit(_same, self.boundary, part=0)
        self._number = 0
        self._points: dict[int, list[Any]] = {}
        self._at: list[Any] = []
        self._own: Floats = np.zeros(0)
        self._factor: tuple[int, list[Any], list[Any], Floats] | None = None
        self._last: tuple[bytes, list[Any]] = (b"", [])

    def describe(self) -> list[tuple[int, bool, int]]:
        """Of each part `requests.describe`."""
        return self._ask(requests.describe, [() for _ in self._shares])

    def explain(self, states: list[Floats], derivatives: bool) -> Diagnostic | None:
        """The first residual (or derivative) that is not finite at some states."""
        points = self._point(states)
        found = self._ask(requests.explain, [(point, derivatives) for point in points])
        return next((one for one in found if one is not None), None)

    # --- what the loop asks for ----------------------------------------------------------------

    def cost(self, states: list[Floats]) -> float:
        """Sum of squared residuals at states, one array (rows, state) per entity."""
        points = self._point(states)
        return float(sum(self._ask(requests.cost, [(p,) for p in points])))

    def linearise(self, states: list[Floats]) -> tuple[float, Floats, Floats]:
        """Cost, J'r and the diagonal of J'J."""
        self._at = points = self._point(states)
        gradient, diagonal = np.zeros(self._size), np.zeros(self._size)
        total = 0.0
        for (cost, first, second), at in zip(
            self._ask(requests.linearise, [(p,) for p in points]), self._places, strict=True
        ):
            total += cost
            self.traffic.back += first.nbytes + second.nbytes
            for whole, mine in ((at.interior, at.of_interior), (at.boundary, at.of_boundary)):
                gradient[whole] += first[mine]
                diagonal[whole] += second[mine]
        self._own = diagonal
        return total, gradient, diagonal

    def curvature(self, step: Floats) -> float:
        """``step' J'J step`` with the present linearisation."""
        asked = []
        for point, at in zip(self._at, self._places, strict=True):
            mine = np.zeros(len(at.every))
            mine[at.of_interior] = step[at.interior]
            mine[at.of_boundary] = step[at.boundary]
            self.traffic.out += mine.nbytes
            asked.append((point, mine))
        return float(sum(self._ask(requests.curvature, asked)))

    def factor(self, damped: Floats, right: Floats) -> tuple[int, Floats | None]:
        """Factorise with a damped diagonal and solve; 1 + the scalar that failed and None."""
        number = self._next()
        factors = []
        for k, (point, at) in enumerate(zip(self._at, self._places, strict=True)):
            mine = damped[at.interior]
            self.traffic.out += mine.nbytes
            factors.append(self._executor.submit(_damped, number, point, mine, part=k))
        ask = Right(self._next())
        reduced = [
            self._executor.submit(requests.eliminate, recipe, factor, ask, part=k)
            for k, (recipe, factor) in enumerate(zip(self._recipes, factors, strict=True))
        ]
        self.traffic.reduced += sum(
            8 * len(at.boundary) * (len(at.boundary) + 1) for at in self._places
        )
        added = (damped - self._own)[self.scalars]
        self._factor = (number, factors, reduced, added)
        return self._substituted(ask, None, right)

    def solve(self, right: Floats) -> Floats:
        """Solve with the last factor."""
        assert self._factor is not None
        number = self._next()
        asks = []
        for k, at in enumerate(self._places):
            mine = right[at.interior]
            self.traffic.out += mine.nbytes
            asks.append(self._executor.submit(Right, number, mine, part=k))
        swept = [
            self._executor.submit(requests.sweep, recipe, factor, ask, part=k)
            for k, (recipe, factor, ask) in enumerate(
                zip(self._recipes, self._factor[1], asks, strict=True)
            )
        ]
        failed, found = self._substituted(asks, swept, right)
        if found is None:
            raise ArithmeticError(f"a factor failed when it was used again, at scalar {failed}")
        return found

    def inverse(self, scalars: Ints) -> Floats:
        """(k, k) entries of the inverse between scalars of one block, by the last factor.

        Only the part that has the block is asked for its sweeps.
        """
        assert self._factor is not None
        number, factors, reduced, added = self._factor
        part = next(
            (k for k, at in enumerate(self._places) if np.isin(scalars[0], at.interior)), -1
        )
        place = self._places[part] if part >= 0 else None
        nothing = [np.zeros(len(at.boundary)) for at in self._places]
        tops, found = [], []
        for scalar in scalars:
            swept: list[Any] = list(nothing)
            right = (self.scalars == scalar).astype(np.float64)
            if place is not None:
                ask = Right(self._next(), (place.interior == scalar).astype(np.float64))
                swept[part] = self._executor.submit(
                    requests.sweep, self._recipes[part], factors[part], ask, part=part
                )
            top = self._executor.submit(
                requests.solve_boundary,
                self._run,
                self._home_of_boundary,
                number,
                reduced,
                swept,
                added,
                right,
                part=0,
            )
            tops.append(top)
            if place is not None:
                recipe, factor = self._recipes[part], factors[part]
                found.append(
                    self._executor.submit(
                        requests.substitute, recipe, factor, ask, top, place.on_boundary, part=part
                    )
                )
        if place is not None:
            at = np.searchsorted(place.interior, scalars)
            return np.stack([x[at] for x in self._executor.gather(found)], axis=1)
        at = np.searchsorted(self.scalars, scalars)
        return np.stack([x[at] for _, x in self._executor.gather(tops)], axis=1)

    def _substituted(
        self, ask: Any, swept: list[Any] | None, right: Floats
    ) -> tuple[int, Floats | None]:
        assert self._factor is not None
        number, factors, reduced, added = self._factor
        x = np.zeros(self._size)
        top = self._executor.submit(
            requests.solve_boundary,
            self._run,
            self._home_of_boundary,
            number,
            reduced,
            swept,
            added,
            right[self.scalars],
            part=0,
        )
        asks = ask if isinstance(ask, list) else [ask] * len(factors)
        steps = [
            self._executor.submit(
                requests.substitute, recipe, factor, one, top, at.on_boundary, part=k
            )
            for k, (recipe, factor, one, at) in enumerate(
                zip(self._recipes, factors, asks, self._places, strict=True)
            )
        ]
        self.traffic.rounds += 1
        (failed, on_boundary), *interiors = self._executor.gather([top, *steps])
        if failed:
            return self._failed(failed, reduced), None
        assert on_boundary is not None
        x[self.scalars] = on_boundary
        for at, step in zip(self._places, interiors, strict=True):
            self.traffic.back += step.nbytes
            x[at.interior] = step
        return 0, x

    def _failed(self, failed: int, reduced: list[Any]) -> int:
        """1 + the scalar of the whole system for a failure in a part (negative) or the boundary."""
        if failed > 0:
            return 1 + int(self.scalars[failed - 1])
        part = -1 - failed
        scalar = self._executor.gather([reduced[part]])[0].failed - 1
        return 1 + int(self._places[part].every[scalar])

    # --- requests ------------------------------------------------------------------------------

    def _next(self) -> int:
        self._number += 1
        return self._number

    def _ask(self, function: Any, arguments: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Answers of all parts, each exactly once, in the order of the parts."""
        self.traffic.rounds += 1
        return self._executor.gather(
            [
                self._executor.submit(function, recipe, *mine, part=k)
                for k, (recipe, mine) in enumerate(zip(self._recipes, arguments, strict=True))
            ]
        )

    def _point(self, states: list[Floats]) -> list[Any]:
        """The states of the parts; those of the last call if they are the same."""
        xs = [self._stored(share, states) for share in self._shares]
        key = b"".join(x.tobytes() for x in xs)
        if self._last[0] != key:
            number = self._next()
            self.traffic.out += sum(x.nbytes for x in xs)
            points = [self._executor.submit(Point, number, x, part=k) for k, x in enumerate(xs)]
            self._last = (key, points)
        return self._last[1]

    def _stored(self, share: Share, states: list[Floats]) -> Floats:
        found = [np.zeros(0)]
        for state, rows, width in zip(states, share.entity_rows, self._widths, strict=True):
            found.append(state[rows, :width].ravel())
        return np.concatenate(found)


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


def _same(value: Any) -> Any:
    """A value as a task, so that it is sent once and found again by all that depend on it."""
    return value


def _damped(number: int, point: Point, diagonal: Floats) -> Damped:
    return Damped(number, point, diagonal)


__all__ = ["PartRecipe", "Team", "Traffic"]
