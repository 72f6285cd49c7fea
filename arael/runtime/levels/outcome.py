"""How a solve by levels ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["solved", "stalled", "side", "not_finite", "step_limit"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a solve.

    Attributes
    ----------
    status : ``solved``; ``stalled``: no step makes the residuals smaller; ``side``: every step that
        would is stopped by a guard; ``not_finite``: a residual is not finite at the start;
        ``step_limit``
    steps : Newton steps
    factors : factorisations
    residual : largest residual of the rows that act, at the end
    row : that row; -1 without rows
    guard : of ``side``: the guard, else -1
    distance : of a drag: how far the points stayed from their targets, else 0
    """

    status: Status
    steps: int
    factors: int
    residual: float
    row: int
    guard: int = -1
    distance: float = 0.0

    @property
    def solved(self) -> bool:
        """Whether all rows hold."""
        return self.status == "solved"
