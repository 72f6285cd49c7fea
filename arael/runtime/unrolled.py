"""Sums over rows written out for the lengths of lists that the data has.

A constraint with `arael.runtime.layout.RowSums` becomes groups, one for each length or a few
lengths, whose uses are those of the constraint and of each row, so that everything behind a group
(scatter plan, linear solvers, Jacobians, reports) needs no special case. The expression machine
runs them. Lists of up to `EXACT` rows have a group for each length. Longer ones share a group with
lists that have up to an eighth more rows; terms beyond the last row are switched off.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import (
    Group,
    Layout,
    Length,
    Piece,
    Raw,
    RowSums,
    Slot,
    Step,
    Total,
    Use,
    without_row_slots,
)
from arael.runtime.machine.programs import group_program
from arael.runtime.machine.tape import Tape
from arael.runtime.machine.writer import TapeWriter
from arael.runtime.store.access import Ints, StoreLike, Walker, lengths_through

EXACT = 16
"""Rows up to which every length has a group of its own."""

MAX_OPERATIONS = 400_000
"""Operations of one instance, written out: their program takes some seconds to assemble."""

MAX_PRODUCTS = 500_500
"""Products in J'J of one instance: a residual of 1000 scalars of parameters."""

_KEPT = 256  # layouts and groups of other lengths that are kept

Lengths = tuple[tuple[int, int], ...]
"""Per list of a constraint, the least and the largest number of rows."""


class Unrolled:
    """Stands in for a store: its data under a layout in which sums over rows are written out.

    Attributes
    ----------
    layout : the layout of the store with groups appended
    programs : per group its program, or None where the compiled kernels have it
    """

    def __init__(self, store: StoreLike, layout: Layout, programs: Sequence[Any]) -> None:
        self._store, self.layout, self.programs = store, layout, tuple(programs)

    @property
    def structure_version(self) -> Any:
        """Changes whenever rows or refs do."""
        return self._store.structure_version

    def __getattr__(self, name: str) -> Any:
        return getattr(self._store, name)


def unrolled(
    layout: Layout, store: Any, programs: Sequence[Any] | None = None
) -> tuple[Layout, Any, Sequence[Any] | None]:
    """Layout, store and programs with sums over rows written out; as they are if there are none.

    The same store, as long as its lists have lengths of the same groups.

    Raises
    ------
    SolveError
        E1017: a list is too long for this.
    """
    if isinstance(store, Unrolled):
        return store.layout, store, store.programs if programs is None else programs
    if not layout.summed:
        return layout, store, programs
    known: tuple[Any, Layout, Unrolled] | None = getattr(store, "unrolled", None)
    version = store.structure_version
    if known is None or known[1] is not layout or known[0] != version:
        whole, added = _layout(layout, store)
        if known is None or known[1] is not layout or known[2].layout is not whole:
            own = [None] * len(layout.groups) if programs is None else list(programs)
            own += [group_program(whole, group) for group in added]
            known = version, layout, Unrolled(store, whole, own)
        known = version, layout, known[2]
        store.unrolled = known
    return known[2].layout, known[2], known[2].programs


def _layout(layout: Layout, store: StoreLike) -> tuple[Layout, tuple[Group, ...]]:
    """The layout with groups for the lengths that the data has, and these groups."""
    wanted = tuple(
        (number, lengths)
        for number in layout.summed
        for lengths in _lengths(store, layout.groups[number])
    )
    cases = _kept(layout, "cases")
    layouts = _kept(layout, "layouts")
    if wanted not in layouts:
        for number, lengths in wanted:
            if (number, lengths) not in cases:
                cases[number, lengths] = _Case(layout, number, lengths).group()
        added = (cases[one] for one in wanted)
        layouts[wanted] = msgspec.structs.replace(layout, groups=(*layout.groups, *added))
    whole: Layout = layouts[wanted]
    return whole, whole.groups[len(layout.groups) :]


def _kept(layout: Layout, name: str) -> dict[Any, Any]:
    found: dict[Any, Any] = layout.__dict__.setdefault(f"unrolled_{name}", {})
    if len(found) > _KEPT:
        found.clear()
    return found


def _lengths(store: StoreLike, group: Group) -> list[Lengths]:
    """Lengths of lists that occur, but for none that has a row."""
    rows: Ints = np.arange(store.tables[group.table].size, dtype=np.int64)
    walker = Walker(store, group.table, rows, True)
    counts = [
        lengths_through(store, one.collection, walker.rows(group.slots[one.slot]))
        for one in group.lengths
    ]
    found = {tuple(bounds(int(n)) for n in one) for one in set(zip(*counts, strict=True))}
    return sorted(found - {((0, 0),) * len(counts)})


def bounds(n: int) -> tuple[int, int]:
    """Least and largest length of the lists that share a group with those of `n` rows."""
    if n <= EXACT:
        return n, n
    step = 1 << ((n - 1).bit_length() - 4)
    high = -(-n // step) * step
    return high - step + 1, high


class _Case:
    """One constraint for lists of given lengths."""

    def __init__(self, layout: Layout, number: int, lengths: Lengths) -> None:
        self.layout, self.number, self.lengths = layout, number, lengths
        self.base = layout.groups[number]
        sums = self.base.row_sums
        assert sums is not None
        self.sums: RowSums = sums
        self.highs = [high for _, high in lengths]
        self.list_of = [sums.list_of(slot) for slot in range(len(sums.slots))]
        self._check()
        self._place()

    def group(self) -> Group:
        """The group of these lengths."""
        base, sums = self.base, self.sums
        raws, prepare, data_count = self._prepare()
        program = _Program(self, data_count)
        tape, entries = program.whole()
        states = program.states
        guard = program.guard() if sums.guard is not None else None
        lengths = tuple(
            Length(one.slot, one.collection, *both)
            for one, both in zip(base.lengths, self.lengths, strict=True)
        )
        return msgspec.structs.replace(
            base,
            slots=tuple(self.slots),
            uses=tuple(self.uses),
            raw=raws,
            prepare=prepare,
            data_count=data_count,
            states=states,
            tape=tape,
            jacobian=entries,
            lead=(),
            moving_guard=guard,
            triplet_pairs=self._triplets(),
            totals=(*base.totals, *self._counts()),
            lengths=lengths,
            row_sums=None,
            case_of=self.number,
            operations_before=tape.operations,
            operations_after=tape.operations,
            workspace=0,
        )

    def copies(self, number: int) -> Sequence[int]:
        """Numbers of the rows of a list, or -1 alone for what is of none."""
        return range(self.highs[number]) if number >= 0 else (-1,)

    def _place(self) -> None:
        """Slots and uses: those of the instance, and those of each row."""
        sums = self.sums
        self.slots = list(without_row_slots(sums.slots))
        self.slot_of: dict[tuple[int, int], int] = {}
        for slot, number in enumerate(self.list_of):
            if number >= 0 and _is_nested(sums, slot, number):
                continue  # of a sum that is formed before the solve, and read by its own program
            for k in self.copies(number):
                if k < 0:
                    self.slot_of[slot, k] = slot
                    continue
                self.slot_of[slot, k] = len(self.slots)
                self.slots.append(_element(sums.slots[slot], k))
        self.uses: list[Use] = []
        self.use_of: dict[tuple[int, int], int] = {}
        for number, use in enumerate(sums.uses):
            for k in self.copies(self.list_of[use.slot]):
                self.use_of[number, k] = len(self.uses)
                self.uses.append(Use(self.slot_of[use.slot, k], use.entity))

    def row(self, use: int, k: int) -> int:
        """Number of a use as row `k` of a list reads it."""
        return self.use_of[use, k if self.list_of[self.sums.uses[use].slot] >= 0 else -1]

    def least(self, number: int) -> int:
        """Rows that all lists of that number have."""
        return self.lengths[number][0]

    def _check(self) -> None:
        """Refuse lists that all of these lengths are too long for."""
        operations = sum(
            len(piece.tape.ops) * self.least(number) for number, piece in self.sums.sums
        )
        scalars = sum(
            self.layout.entities[use.entity].tangent * (self.least(number) if number >= 0 else 1)
            for use, number in ((u, self.list_of[u.slot]) for u in self.sums.uses)
        )
        products = self.base.residuals * scalars * (scalars + 1) // 2
        if operations <= MAX_OPERATIONS and products <= MAX_PRODUCTS:
            return
        much = (
            f"it reads {scalars} scalars of parameters, and J'J of an instance takes {products} "
            f"products, more than {MAX_PRODUCTS}"
            if products > MAX_PRODUCTS
            else f"it takes {operations} operations, more than {MAX_OPERATIONS}"
        )
        longest = int(np.argmax(self.highs))
        low, high = self.lengths[longest]
        raise SolveError(
            Diagnostic(
                "E1017",
                f"`{self.base.label}` sums over {low}{' or more' * (low < high)} rows of "
                f"`{self.base.lengths[longest].collection}`, term by term: {much}",
                origin=self.base.where,
                notes=(
                    "a term that is a sum of products of row data and parameters of other rows is "
                    "summed before the solve, for any number of rows",
                ),
                help=(
                    "give each row a parameter for the sum so far, and a constraint that sets it "
                    "to that of the row before plus the row's term",
                ),
            )
        )

    def _count_name(self, number: int) -> str:
        owner = self.layout.table(self.base.lengths[number].collection)
        return f"{owner.field}#rows"

    def _padded(self) -> list[int]:
        return [k for k, (low, high) in enumerate(self.lengths) if low < high]

    def _counts(self) -> list[Total]:
        """The number of rows of each list that may have fewer than the group has."""
        one = Tape(("const",), ((0,),), (1.0,), (0,))
        return [
            Total(
                self._count_name(k),
                self.layout.table(self.base.lengths[k].collection).parent,
                self.base.lengths[k].collection,
                (Slot((), self.base.lengths[k].collection),),
                (),
                one,
            )
            for k in self._padded()
        ]

    def _prepare(self) -> tuple[tuple[Raw, ...], Tape, int]:
        """What is read of the data, the program of the lane inputs, and how many there are.

        They are those of the instance, of each row of each list, whether rows are there, and the
        place of the guard. `lane` maps what they are to their numbers.
        """
        sums = self.sums
        tape = TapeWriter()
        raws: dict[Raw, int] = {}

        def read(raw: Raw, k: int) -> int:
            slot = self.slot_of[raw.slot, k if self.list_of[raw.slot] >= 0 else -1]
            found = Raw(slot, raw.column, raw.component)
            return tape.input(raws.setdefault(found, len(raws)))

        every = tape.add(sums.prepare, [read(raw, -1) for raw in sums.raw])
        uniforms = every[len(every) - sums.uniforms :]
        outputs = every[: len(every) - sums.uniforms]
        self.lane: dict[tuple[int, int, int], int] = {(-1, -1, k): k for k in range(len(outputs))}
        for number, (raw, program) in enumerate(zip(sums.row_raw, sums.row_prepare, strict=True)):
            for k in self.copies(number):
                found = tape.add(program, [read(one, k) for one in raw])
                for j in range(len(found)):
                    self.lane[number, k, j] = len(outputs) + j
                outputs += found
        for number in self._padded():
            count = read(Raw(sums.lists[number][0], self._count_name(number)), -1)
            for k in range(*self.lengths[number]):
                self.lane[number, k, -1] = len(outputs)
                outputs.append(tape.op("lt", tape.const(float(k)), count))
        if self.base.moving_guard is not None:
            self.lane[-1, -1, -1] = len(outputs)
            outputs.append(tape.const(1.0))
        return tuple(raws), tape.tape([*outputs, *uniforms]), len(outputs)

    def _triplets(self) -> tuple[tuple[int, int], ...]:
        """Pairs of uses that stand in the triplets of the root."""
        if not self.base.triplets:
            return ()
        origin = {number: use for (use, _), number in self.use_of.items()}
        apart = set(self.sums.crossed)
        return tuple(
            (a, b)
            for b in range(len(self.uses))
            for a in range(b)
            if tuple(sorted((origin[a], origin[b]))) not in apart
        )


def _is_nested(sums: RowSums, slot: int, number: int) -> bool:
    """Whether a slot is reached through the rows of a further list."""
    way = sums.slots[sums.lists[number][1]].steps
    return any(step.kind == "rows" for step in sums.slots[slot].steps[len(way) :])


def _element(slot: Slot, number: int) -> Slot:
    """A slot that is, or is reached from, the rows of a list, for one of them."""
    at = max(k for k, step in enumerate(slot.steps) if step.kind == "rows")
    own = Step("row", f"{slot.steps[at].ref}[{number}]")
    return Slot((*slot.steps[:at], own, *slot.steps[at + 1 :]), slot.table)


class _Program:
    """The tape of a case: terms of all rows, their sums, residuals, and the chain rule."""

    def __init__(self, case: _Case, data_count: int) -> None:
        self.case, self.sums = case, case.sums
        used: set[tuple[int, int]] = set()
        pieces = [(-1, self.sums.main), *self.sums.sums]
        if self.sums.guard is not None:
            pieces.append((-1, self.sums.guard))
        for number, piece in pieces:
            for kind, a, b in piece.inputs:
                if kind == "state":
                    used.update((case.row(a, k), b) for k in case.copies(number))
        self.states = tuple(sorted(used))
        self.state_at = {state: k for k, state in enumerate(self.states)}
        self.lanes = len(self.states)
        self.uniforms = self.lanes + data_count

    def whole(self) -> tuple[Tape, tuple[tuple[int, int, int], ...]]:
        """Residuals and derivatives, and the places of these."""
        tape = TapeWriter()
        values, slopes = self._terms(tape)
        main = self.sums.main
        outputs = tape.add(main.tape, self._inputs(tape, main, -1, -1, values))
        residuals, derivatives = outputs[: main.values], outputs[main.values :]
        found: dict[tuple[int, int, int], int] = {}
        for (residual, use, tangent), node in zip(main.entries, derivatives, strict=True):
            for where, slope in self._behind(tape, use, tangent, -1, node, slopes):
                _add(tape, found, (residual, *where), slope)
        keys = tuple(sorted(found))
        return tape.tape([*residuals, *(found[key] for key in keys)]), keys

    def guard(self) -> Tape:
        """The guard over parameters."""
        tape = TapeWriter()
        piece = self.sums.guard
        assert piece is not None
        values, _ = self._terms(tape)
        return tape.tape(tape.add(piece.tape, self._inputs(tape, piece, -1, -1, values)))

    def _terms(
        self, tape: TapeWriter
    ) -> tuple[list[list[int]], list[list[dict[tuple[int, int], int]]]]:
        """Components of all sums, and their derivatives by use and tangent scalar."""
        case = self.case
        values: list[list[int]] = []
        slopes: list[list[dict[tuple[int, int], int]]] = []
        zero = tape.const(0.0)
        for number, piece in self.sums.sums:
            total = [zero] * piece.values
            slope: list[dict[tuple[int, int], int]] = [{} for _ in total]
            behind: dict[tuple[int, int, int], int] = {}
            for k in case.copies(number):
                found = tape.add(piece.tape, self._inputs(tape, piece, number, k, values))
                if k >= case.least(number):
                    there = tape.input(self.lanes + case.lane[number, k, -1])
                    found = [tape.op("select", there, node, zero) for node in found]
                for c, node in enumerate(found[: piece.values]):
                    total[c] = node if k == 0 else tape.op("add", total[c], node)
                for (c, use, tangent), node in zip(
                    piece.entries, found[piece.values :], strict=True
                ):
                    if use < 0:
                        _add(tape, behind, (c, use, tangent), node)
                    else:
                        _add(tape, slope[c], (case.row(use, k), tangent), node)
            for (c, use, tangent), node in behind.items():
                for where, one in self._behind(tape, use, tangent, -1, node, slopes):
                    _add(tape, slope[c], where, one)
            values.append(total)
            slopes.append(slope)
        return values, slopes

    def _behind(
        self,
        tape: TapeWriter,
        use: int,
        tangent: int,
        k: int,
        node: int,
        slopes: list[list[dict[tuple[int, int], int]]],
    ) -> list[tuple[tuple[int, int], int]]:
        """A derivative by a scalar as it is; one by a sum by the scalars that this depends on."""
        if use >= 0:
            return [((self.case.row(use, k), tangent), node)]
        slope = slopes[-1 - use][tangent]
        return [(where, tape.op("mul", node, one)) for where, one in slope.items()]

    def _inputs(
        self, tape: TapeWriter, piece: Piece, number: int, k: int, values: list[list[int]]
    ) -> list[int]:
        """Nodes of the inputs of a program, of row `k` of list `number`."""
        case = self.case
        find: dict[str, Callable[[int, int], int]] = {
            "state": lambda a, b: tape.input(self.state_at[case.row(a, k), b]),
            "lane": lambda a, _: tape.input(self.lanes + case.lane[-1, -1, a]),
            "row": lambda a, _: tape.input(self.lanes + case.lane[number, k, a]),
            "uniform": lambda a, _: tape.input(self.uniforms + a),
            "sum": lambda a, b: values[a][b],
            "guard": lambda _a, _b: tape.input(self.lanes + case.lane[-1, -1, -1]),
        }
        return [find[kind](a, b) for kind, a, b in piece.inputs]


def _add(tape: TapeWriter, found: dict[Any, int], key: Any, node: int) -> None:
    known = found.get(key)
    found[key] = node if known is None else tape.op("add", known, node)
