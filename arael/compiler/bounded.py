"""A scalar graph with a bound on its number of nodes, against models that would exhaust memory."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic, Span
from arael.symbolic.graph import Graph

# Nodes of one constraint with all its derivatives. The largest constraint of a SLAM model makes
# 3 000; this many take a few seconds.
MAX_NODES = 150_000


class BoundedGraph(Graph):
    """The graph of the constraint or function at `span`.

    Parameters
    ----------
    label : its name, for the message
    used : nodes that others before it have taken of the same allowance

    Raises
    ------
    AraelError
        E0620 from any operation that would make node number `MAX_NODES`.
    """

    def __init__(self, label: str, span: Span, used: int = 0) -> None:
        super().__init__()
        self.label, self.span, self.used = label, span, used

    def reserve(self, operations: int) -> None:
        """Refuse before operations are made that there is no place for."""
        if self.used + len(self.ops) + operations >= MAX_NODES:
            takes = "and those before it take" if self.used else "takes"
            raise AraelError(
                Diagnostic(
                    "E0620",
                    f"`{self.label}` with its derivatives {takes} more than {MAX_NODES} operations",
                    self.span,
                    help=("split the residual, or move what depends on data alone into the data",),
                )
            )

    def _append(self, name: str, args: tuple[int, ...]) -> int:
        self.reserve(0)
        return super()._append(name, args)
