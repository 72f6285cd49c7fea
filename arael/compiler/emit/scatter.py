"""Where the contributions of a block of lanes go, and by which of three ways.

What is added to J'r and J'J falls into *targets*: the gradient of one use, the block of a pair of
uses. One lane's share of a target is contiguous in memory, but the arithmetic leaves it spread over
as many columns of W lanes. So

- targets of the *lead*, the use with the most scalars, are summed lane by lane in accumulators for
  as long as all lanes of a block share its row: the runtime orders instances such that they do. So
  are those of the root, of which there is only one row;
- other targets are brought from columns into rows by a transposition and added whole, or stored
  where nothing was before;
- what is hardly filled, or turned, is added scalar by scalar.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

from arael.compiler.groups import Kernel
from arael.runtime.layout import Entity, pair_of

# Scalars from which a target is added by rows, and the fractions of it that must be nonzero. In a
# diagonal block the lower triangle is used; the upper one is added with it and never read.
_TILE = 16
_FILLED_BLOCK = 1 / 2
_FILLED_DIAGONAL = 1 / 3


@dataclass
class Target:
    """J'r of one use (`b` is None) or the block of a pair of uses.

    `entries` are the outputs of the linearisation by position (row, column) in memory. A pair of
    two entities has the same orientation for all instances, by the order of entities in the system.
    For a pair of one entity `varies` is set: the orientation differs by instance, and positions are
    those of the pair.
    """

    a: int
    b: int | None
    height: int
    width: int
    varies: bool = False
    entries: dict[tuple[int, int], int] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Scalars."""
        return self.height * self.width

    @property
    def pair(self) -> int:
        """Number of the pair of uses."""
        assert self.b is not None
        return pair_of(self.a, self.b)

    @property
    def uses(self) -> set[int]:
        """The uses whose rows determine the offset of the target."""
        return {self.a} if self.b is None else {self.a, self.b}

    @property
    def is_crossed(self) -> bool:
        """Whether it is a block off the diagonal, which an instance may be the first to write."""
        return self.b is not None and self.a != self.b

    @property
    def is_filled(self) -> bool:
        """Whether adding it whole is cheaper than adding what is there."""
        share = _FILLED_DIAGONAL if self.a == self.b else _FILLED_BLOCK
        return self.size >= _TILE and len(self.entries) >= share * self.size

    def mirrored(self) -> dict[tuple[int, int], int]:
        """Entries, of a diagonal block those above the diagonal too."""
        if self.a != self.b:
            return self.entries
        return self.entries | {(j, i): at for (i, j), at in self.entries.items()}


@dataclass
class Plan:
    """The targets of a kernel by the way they are added.

    Attributes
    ----------
    accumulated : targets of the lead alone
    whole : other targets that are added as rows, with their first column among the rows
    single : the rest
    outputs : columns that each output of the linearisation is stored to
    sources : column that each output is read from, with its sign
    shared : number of columns ``o``
    columns : number of columns ``q`` that are turned into rows
    lead : the use whose row decides how long to accumulate
    """

    accumulated: list[Target]
    whole: list[tuple[Target, int]]
    single: list[Target]
    outputs: dict[int, list[str]]
    sources: list[str]
    shared: int
    columns: int
    lead: int


def targets_of(
    uses: Sequence[int],
    tangent: Sequence[int],
    gradient: Mapping[tuple[int, int], int],
    products: Mapping[tuple[int, int, int, int], int],
    ordered: bool = True,
) -> list[Target]:
    """All targets that something is added to.

    Parameters
    ----------
    uses, tangent : by use: its entity, and the scalars solved for in it
    gradient, products : outputs by what they are, as `Kernel` names it
    ordered : whether the system has entities in their order here
    """
    targets: dict[tuple[int, int | None], Target] = {}
    for (use, i), at in gradient.items():
        targets.setdefault((use, None), Target(use, None, 1, tangent[use])).entries[0, i] = at
    for (a, b, i, j), at in products.items():
        turned = ordered and uses[a] < uses[b]
        varies = a != b and (uses[a] == uses[b] or not ordered)
        height, width = (tangent[b], tangent[a]) if turned else (tangent[a], tangent[b])
        target = targets.setdefault((a, b), Target(a, b, height, width, varies))
        target.entries[(j, i) if turned else (i, j)] = at
    return list(targets.values())


def make_plan(kernel: Kernel, entities: Sequence[Entity], ordered: bool = True) -> Plan:
    """Choose the way of each target, and the column of each output."""
    group, tape = kernel.group, kernel.linearise
    uses = [use.entity for use in group.uses]
    tangent = [entities[e].tangent for e in uses]
    sources = [""] * len(tape.outputs)
    first = group.residuals + len(group.jacobian)
    targets = targets_of(
        uses,
        tangent,
        dict(zip(kernel.gradient, count(first))),
        dict(zip(kernel.products, count(first + len(kernel.gradient)))),
        ordered,
    )
    accumulated = [t for t in targets if t.uses <= set(group.lead) and not t.varies]
    others = [t for t in targets if t not in accumulated]
    whole: list[tuple[Target, int]] = []
    outputs: dict[int, list[str]] = {i: [] for i in range(len(tape.outputs))}
    columns = 0
    for target in others:
        if not target.is_filled:
            continue
        whole.append((target, columns))
        entries = target.mirrored()
        for place in range(target.size):
            at = entries.get(divmod(place, target.width))
            if at is None:
                continue
            sources[at] = f"q[{columns + place}][w]"
            outputs[at].append(sources[at])
        columns += target.size
    shared = 0
    column: dict[int, str] = {}
    for i, node in enumerate(tape.outputs):
        if sources[i]:
            continue
        # The same node shares a column; its negative is read with a minus sign.
        negative = tape.ops[node] == "neg" and tape.args[node][0] in column
        base = tape.args[node][0] if negative else node
        if base not in column:
            column[base] = f"o[{shared}][w]"
            outputs[i].append(column[base])
            shared += 1
        sources[i] = ("-" if negative else "") + column[base]
    single = [t for t in others if all(t is not known for known, _ in whole)]
    lead = group.lead[0] if group.lead else -1
    return Plan(accumulated, whole, single, outputs, sources, shared, columns, lead)
