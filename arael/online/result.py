"""What an update came to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from arael.result import Result


@dataclass(frozen=True)
class UpdateResult:
    """Outcome of `Model.update`.

    Attributes
    ----------
    cost : sum of squared residuals at the new estimates
    steps : Gauss-Newton steps; with `full`, iterations of the solve
    moved : number of rows whose values changed by more than the tolerance, and were written
    moved_rows : these rows, by collection
    relinearised : rows that were linearised anew
    refactored : scalars that were eliminated anew, of all steps
    deferred : rows that are to be linearised anew by the next update, as `max_seconds` was over
    undetermined : scalars that no residual determines; they keep their values
    full : whether the problem was solved in full
    reason : why; "" if it was not
    seconds : that the update took
    solved : the result of the solve, if `full`
    """

    cost: float
    steps: int
    moved: int = 0
    moved_rows: Mapping[str, Any] = field(default_factory=dict, repr=False)
    relinearised: int = 0
    refactored: int = 0
    deferred: int = 0
    undetermined: int = 0
    full: bool = False
    reason: str = ""
    seconds: float = 0.0
    solved: Result | None = field(default=None, repr=False)

    def __str__(self) -> str:
        ending = f"cost {self.cost:.6g}, {1e3 * self.seconds:.3g} ms"
        if self.full:
            return f"solved in full: {self.reason}; {ending}"
        left = f", {self.deferred} deferred" if self.deferred else ""
        open_ = f", {self.undetermined} scalars undetermined" if self.undetermined else ""
        return (
            f"{self.moved} rows moved, {self.relinearised} relinearised, {self.refactored} scalars"
            f" refactored{left}{open_}; {ending}"
        )
