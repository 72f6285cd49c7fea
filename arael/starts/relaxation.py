"""One sparse linear least-squares solve over the poses of a graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.starts.arithmetic import assembled, places_of, poses_of

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Unknowns up to which the dense solver is taken, without an analysis.
_SMALL = 64


class SingularError(Exception):
    """The measurements do not determine every pose."""


@dataclass(frozen=True)
class Coupling:
    """The pattern of a problem whose blocks are poses.

    Attributes
    ----------
    pattern : of the problem; its symbolic factor is used for the relaxation too
    block_of : (n,) block of each pose, -1 of poses that are fixed as a whole
    """

    pattern: BlockPattern
    block_of: Ints


class Relaxation:
    """Normal equations with one block of `d` scalars per pose, for both stages of a relaxation.

    Poses of which a part is fixed stay in the system as identities, so that ordering and symbolic
    factorisation are done once for any set of fixed parts.

    Parameters
    ----------
    count : number of poses
    d : scalars of a pose
    a, b : (m,) poses that each edge couples
    coupling : pattern of the problem, if its blocks are the poses: ordering and symbolic
        factorisation are then those that the solve uses
    """

    def __init__(
        self, count: int, d: int, a: Ints, b: Ints, coupling: Coupling | None = None
    ) -> None:
        self.count, self.d, self.a, self.b = count, d, a, b
        shared = None
        if coupling is not None:
            try:
                self._couple(coupling.pattern, coupling.block_of)
                shared = coupling.pattern
            except LookupError:  # some edges are no constraints of this model
                pass
        if shared is None:
            sizes = np.full(count, d, np.int64)
            self._couple(BlockPattern.from_pairs(sizes, a, b), np.arange(count))
        self._solver = _solver(self._pattern, shared)

    def _couple(self, pattern: BlockPattern, block_of: Ints) -> None:
        nb, d = pattern.block_count, self.d
        sizes = np.full(nb, d, np.int64)
        starts = np.arange(0, d * d * len(pattern.rows), d * d)
        self._pattern = BlockPattern(sizes, pattern.column_start, pattern.rows, starts)
        # As the cached properties keep them.
        self._pattern.__dict__.update(
            offsets=np.arange(0, d * nb + 1, d),
            size=d * nb,
            value_count=d * d * len(pattern.rows),
        )
        self._block_of = block_of
        self._places = places_of(self._pattern, block_of, self.a, self.b)

    def solved(
        self, blocks: tuple[Array, Array, Array], own: Array, right: Array, held: Bools, at: Array
    ) -> Array:
        """Minimiser of the quadratic whose normal equations are given.

        Parameters
        ----------
        blocks : (m, d, d) of each edge: of `a` with `a`, of `a` with `b`, of `b` with `b`
        own : (count, d, d) additional diagonal blocks
        right : (count, d, k) right-hand sides
        held : (count,) fixed poses; those without a block are
        at : (count, d, k) values of fixed poses

        Returns
        -------
        (count, d, k)

        Raises
        ------
        SingularError
        """
        arrays = (np.ascontiguousarray(one) for one in (own, right, held, at))
        own, right, held, at = arrays  # type: ignore[assignment]
        aa, ab, bb = (np.ascontiguousarray(one) for one in blocks)
        edges = self._places, self.a, self.b, (aa, ab, bb)
        values, diagonal, rhs, sound = assembled(
            self._pattern, self._block_of, *edges, own, right, held, at
        )
        if not sound or self._solver.factorise(values, diagonal):
            raise SingularError
        found, sound = poses_of(self._solver.solved(rhs.T), self._block_of, at)
        if not sound:
            raise SingularError
        return found


def _solver(pattern: BlockPattern, shared: BlockPattern | None) -> Any:
    """A solver for a pattern, with the symbolic factor of one that has the same blocks."""
    if pattern.size <= _SMALL:
        # imported here: start-up time
        from arael.runtime.linear.compiled import DenseSolver

        return DenseSolver(pattern)
    # imported here: start-up time
    from arael.runtime.linear.analysis import analyse
    from arael.runtime.linear.compiled import SparseSolver

    # Two factorisations of it do not repay a comparison of orders.
    analysis = analyse(pattern if shared is None else shared, "minimum_degree")
    return SparseSolver(pattern, analysis=analysis)
