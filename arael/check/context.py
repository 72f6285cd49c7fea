"""The part of a typist that rules below it use, so that none of them imports it.

`Typist` implements it; the expressions of a body are typed by functions over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from arael.check.binding import Broken, Entity
from arael.check.declared import Declarations
from arael.check.guards import Fact
from arael.check.paths import Paths
from arael.check.report import Reporter
from arael.check.scope import ConstantBinder, Scope
from arael.check.typed import Typed
from arael.check.units_typing import Units
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import Step
from arael.syntax import tree


class Rows(Protocol):
    """The rows that a constraint reads, numbered."""

    def of(self, entity: Entity) -> int:
        """Number of the slot for the row of `entity`."""


class Context(Protocol):
    """Type checking of one body: what is known, and how a node is added or refused."""

    declarations: Declarations
    report: Reporter
    scope: Scope
    facts: frozenset[Fact]
    origins: dict[Typed, Label]
    units: Units
    formulas: dict[tuple[tuple[Step, ...], str], Typed | Broken | None]

    @property
    def constant(self) -> ConstantBinder:
        """Values of constants by name."""

    @property
    def slots(self) -> Rows:
        """The rows that the body reads."""

    @property
    def paths(self) -> Paths:
        """Resolves paths between entities."""

    def value(self, node: tree.Expr) -> Typed | Broken:
        """The value of `node`: a number of any shape, or a boolean."""

    def make(self, node: Typed, cost: int = 0) -> Typed | Broken:
        """Add `node`, and infer its unit."""

    def fail(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        label: str = "",
        labels: Sequence[Label] = (),
        notes: Sequence[str] = (),
        help: Sequence[str] = (),
    ) -> Broken:
        """Report an error; inside a function with a label at its call."""
