"""A scalar graph that refuses to grow without end, whatever a model asks for."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic, Span
from arael.symbolic.graph import Graph

# Nodes of one constraint with all its derivatives. The largest constraint of a SLAM model makes
# 3 000; this many take a few seconds.
MAX_NODES = 150_000


class BoundedGraph(Graph):
    """The graph of the constraint at `span`.

    Raises
    ------
    AraelError
        E0620 from any operation that would make node number `MAX_NODES`.
    """

    def __init__(self, label: str, span: Span) -> None:
        super().__init__()
        self.label, self.span = label, span

    def _append(self, name: str, args: tuple[int, ...]) -> int:
        if len(self.ops) >= MAX_NODES:
            raise AraelError(
                Diagnostic(
                    "E0620",
                    f"`{self.label}` with its derivatives takes more than {MAX_NODES} operations",
                    self.span,
                    help=("split the residual, or move what depends on data alone into the data",),
                )
            )
        return super()._append(name, args)
