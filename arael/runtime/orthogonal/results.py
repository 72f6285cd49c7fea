"""Results of the factorisation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Dependency(NamedTuple):
    """A row c as a combination of independent equations: `J[equations]' factors = c`.

    Attributes
    ----------
    equations : (k,) int32, ascending, those with a factor
    factors : (k,) float64
    remainder : float
        Length of what the equations do not give of c, as a part of the length of c; both in scaled
        unknowns. 0 for a dependent row, at most 1.
    """

    equations: NDArray[np.int32]
    factors: NDArray[np.float64]
    remainder: float


@dataclass(frozen=True, slots=True)
class Vectors:
    """Sparse vectors: vector k has `values[start[k]:start[k + 1]]` at `at[start[k]:start[k + 1]]`.

    Attributes
    ----------
    size : int, length of each vector
    start : (number + 1,) int64
    at : (entries,) int32, ascending within a vector
    values : (entries,) float64
    """

    size: int
    start: NDArray[np.int64]
    at: NDArray[np.int32]
    values: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of vectors."""
        return len(self.start) - 1

    def vector(self, k: int) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Places and values of one vector."""
        part = slice(int(self.start[k]), int(self.start[k + 1]))
        return self.at[part], self.values[part]

    def dense(self) -> NDArray[np.float64]:
        """Vectors as rows of an array of shape (number, size)."""
        made = np.zeros((len(self), self.size))
        made[np.repeat(np.arange(len(self)), np.diff(self.start)), self.at] = self.values
        return made
