"""Functions whose derivatives are given instead of derived."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from arael.runtime.machine.tape import NATIVE

if TYPE_CHECKING:
    from arael.symbolic.graph import Graph


@dataclass(frozen=True)
class Prescribed:
    """A function of scalars with partial derivatives of its own.

    The partials are made when a call is differentiated and not before, so functions may name each
    other and themselves in them: ``exp`` is its own derivative.

    Attributes
    ----------
    name : as the model spells it
    native : whether its value is known to native code only; else calls have a node of their value
    partials : makes the partial derivatives, one per argument, from a graph and the arguments; None
        of a function of `arael.symbolic.functions`, which SymPy differentiates
    """

    name: str
    native: bool
    partials: Callable[[Graph, Sequence[int]], Sequence[int]] | None = None

    @property
    def operation(self) -> str:
        """Name of the operation in graphs, and of a native one in tapes too."""
        return f"{NATIVE}{self.name}" if self.native else f"derived:{self.name}"

    def arguments(self, operands: tuple[int, ...]) -> tuple[int, ...]:
        """Arguments among the operands of a call."""
        return operands if self.native else operands[1:]
