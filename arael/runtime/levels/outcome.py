"""Results of solves by levels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

#: ``solved``: all active rows hold; ``stalled``: no step makes the residuals smaller;
#: ``side``: every step that does would change the sign of a guard; ``not_finite``: a residual or
#: derivative is not a number; ``step_limit``; ``interrupted``: by Ctrl-C, or by
#: `Levels.interrupt`.
Status = Literal["solved", "stalled", "side", "not_finite", "step_limit", "interrupted"]

#: In the order of the numbers in newton.pxd.
STATUSES: tuple[str, ...] = (
    "solved",
    "running",
    "stalled",
    "side",
    "not_finite",
    "step_limit",
    "interrupted",
    "idle",
)


@dataclass(frozen=True, slots=True)
class ComponentOutcome:
    """What became of one component; fields as in `Outcome`."""

    component: int
    status: Status
    largest: float
    row: int
    guard: int
    steps: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a solve.

    Attributes
    ----------
    status
        ``solved`` if all touched components are; else that of the first one that is not.
    largest, row
        Largest residual in magnitude relative to its tolerance, as the residual itself, and its
        row; -1 if no row was looked at.
    guard
        The guard that stopped the solve (``side``), or -1.
    steps
        Steps of the component that took most.
    rounds, factors
        Evaluations of the rows after steps; factorisations of components.
    fraction
        Of the way that `follow` went; 1 elsewhere.
    soft
        Norm of the soft rows, after `minimise` and `drag`.
    distance
        From `home`, in scaled unknowns, after `minimise` and `drag`.
    converged
        Whether lower levels came to their optima; they may end by the step limit, and the exact
        rows hold nevertheless.
    open
        Components that are not solved.
    history
        (rounds, 3) largest residual relative to its tolerance, factorisations made so far, damping;
        of the last time that the exact rows were solved.
    """

    status: Status
    largest: float = 0.0
    row: int = -1
    guard: int = -1
    steps: int = 0
    rounds: int = 0
    factors: int = 0
    fraction: float = 1.0
    soft: float = 0.0
    distance: float = 0.0
    converged: bool = True
    open: tuple[ComponentOutcome, ...] = ()
    history: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)), repr=False)

    @property
    def solved(self) -> bool:
        """Whether all active rows of the touched components hold."""
        return self.status == "solved"
