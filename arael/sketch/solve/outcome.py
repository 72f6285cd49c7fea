"""What became of a solve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

#: ``side``: no way on without changing a side; ``stalled``: the equations have no common solution
#: near, or none at all.
Status = Literal["solved", "stalled", "side", "not_finite", "step_limit", "interrupted"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a solve.

    Attributes
    ----------
    status : ``solved``, or why not; then the document is as it was
    moved : entities whose numbers changed, in the order of the document
    largest : largest residual, a length in the document's unit
    row : name of the record it belongs to; empty where there are no equations
    open : records with residuals above the tolerance, largest first
    steps : Newton steps of the component that took most
    fraction : share of the way from the old to the new value that could be gone, 1 if solved
    """

    status: Status
    moved: tuple[str, ...] = ()
    largest: float = 0.0
    row: str = ""
    open: tuple[str, ...] = ()
    steps: int = 0
    fraction: float = 1.0

    @property
    def solved(self) -> bool:
        """Whether all equations hold."""
        return self.status == "solved"
