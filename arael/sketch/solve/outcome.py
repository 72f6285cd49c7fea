"""What became of a solve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

#: ``stalled``: no common solution near, or none at all; ``side``: none without changing a side.
Status = Literal["solved", "stalled", "side", "not_finite", "step_limit", "interrupted"]


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a solve or drag.

    Attributes
    ----------
    status : ``solved``, or why not; then the document is as it was
    moved : entities whose numbers changed, in the order of the document
    residual : largest residual, a length in the document's unit
    row : name of the record it belongs to; empty where there are no equations
    open : records with residuals above the tolerance, largest first
    guard : record whose side stopped the solve (``side``), else empty
    steps : Newton steps of the component that took most
    fraction : share of the way from the old to the new values that could be gone, 1 if solved
    distance : of a drag: from where the cursor is, a length
    converged : of a drag: whether nothing nearer was left to be found; false if its time was over
    """

    status: Status
    moved: tuple[str, ...] = ()
    residual: float = 0.0
    row: str = ""
    open: tuple[str, ...] = ()
    guard: str = ""
    steps: int = 0
    fraction: float = 1.0
    distance: float = 0.0
    converged: bool = True

    @property
    def solved(self) -> bool:
        """Whether all equations hold."""
        return self.status == "solved"

    def having_moved(self, moved: tuple[str, ...]) -> Outcome:
        """The same with these entities moved; `dataclasses.replace` takes three times as long."""
        return Outcome(
            self.status,
            moved,
            self.residual,
            self.row,
            self.open,
            self.guard,
            self.steps,
            self.fraction,
            self.distance,
            self.converged,
        )
