"""The editor: changes of a document that are validated, solved, judged, or leave no trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.measures import measured, signed
from arael.sketch.document.records import (
    Amount,
    Constraint,
    Dimension,
    Entity,
    Parameter,
    Style,
)
from arael.sketch.editing import notices, refusals
from arael.sketch.editing.cascade import Doomed, disowned, doomed
from arael.sketch.editing.checks import (
    check_amounts,
    check_collapse,
    check_extent,
    check_itself,
    check_largest,
    check_new_constraint,
    same_dimension,
)
from arael.sketch.editing.directions import direction_at, nearly_parallel
from arael.sketch.editing.dragging import Dragging
from arael.sketch.editing.nearby import Points, own_points
from arael.sketch.editing.operands import canonical, matched
from arael.sketch.editing.outlines import is_open, outline
from arael.sketch.editing.remaining import Remaining
from arael.sketch.editing.results import Added, Deleted
from arael.sketch.editing.signs import sided
from arael.sketch.editing.turning import Moves, turned, turned_to
from arael.sketch.expressions.refresh import refresh
from arael.sketch.judge.judge import Judge, Verdict
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.sides import mode_of
from arael.sketch.solve.breaking import broken_off
from arael.sketch.solve.outcome import Outcome
from arael.sketch.solve.solver import Solver

#: Ends this close are connected by themselves.
CONNECT_WITHIN = 1e-3
#: Curves that meet within this angle (degrees) are made tangent by themselves.
TANGENT_WITHIN = 1.0
#: How often values that read geometry are worked out and solved for again.
_ROUNDS = 200
_T = TypeVar("_T")
Floats = NDArray[np.float64]


class _Pretended(Exception):
    """Leaves a transaction that was only to be looked at."""


class Editor:
    """A document with its solver and judge.

    Every method is one transaction, or a part of the one that is open. A refusal raises
    `AraelError` and leaves the document as it was.

    Parameters
    ----------
    document : what is edited

    Attributes
    ----------
    layout : its rows for the solver
    solver : moves geometry so that all constraints hold
    judge : says what is free, redundant, impossible
    remaining : refuses what leaves nothing of an entity, or of the drawing
    notices : what was let in with a reservation, in words; the caller empties it
    followers : run when values were worked out; they change what reads them and return its names
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.layout = Layout(document)
        self.solver = Solver(self.layout)
        self.judge = Judge(self.layout, self.solver)
        self.notices: list[str] = []
        self.followers: list[Callable[[Editor], list[str]]] = []
        self._points = Points(document)
        self._together = 0
        self.remaining = Remaining(self.layout, self.solver)

    # --- transactions -----------------------------------------------------------------------

    @contextmanager
    def together(self) -> Iterator[None]:
        """Several edits that are solved and judged once, at the end."""
        self._together += 1
        try:
            with self.document.transaction("together"):
                names = set(self.document.constraints) | set(self.document.dimensions)
                yield
                if self._together == 1:
                    self._together = 0
                    try:
                        self._settle()
                        new = [
                            name
                            for table in (self.document.constraints, self.document.dimensions)
                            for name in table
                            if name not in names
                        ]
                        self._judge_all(new)
                    finally:
                        self._together = 1
        finally:
            self._together -= 1

    def explain(self, function: Callable[[], _T]) -> _T:
        """What a change would give: it is made, solved and taken back."""
        result: list[_T] = []
        try:
            with self.document.transaction("explain"):
                result.append(function())
                raise _Pretended
        except _Pretended:
            return result[0]

    def solve(self) -> Outcome:
        """Move the geometry so that everything holds.

        Raises
        ------
        AraelError
            E1231, E1233, E1234: there is no solution, or none was found
        """
        with self.document.transaction("solve"):
            return self._settle()

    def _settle(self, cause: str = "") -> Outcome:
        self._refresh()
        outcome = self._solved(cause)
        # values that read geometry move with it until neither changes
        for _ in range(_ROUNDS):
            moving = self._refresh()
            if not moving:
                return outcome
            outcome = self._solved(cause)
        raise refusals.unsettled(moving)

    def _refresh(self) -> list[str]:
        """Work out live values; E1220 if one is what its dimension cannot be."""
        changed = refresh(self.document)
        for follower in self.followers:
            changed += follower(self)
        for name in changed:
            one = self.document.dimensions.get(name)
            if one is not None and not one.broken and not one.derived:
                check_amounts(one.kind, (one.value, one.low, one.high))
        return changed

    def _solved(self, cause: str) -> Outcome:
        before, size = self.document.values.copy(), self.layout.size
        moves = self.document.moves
        outcome = self.solver.solve()
        if outcome.solved:
            label = self._label(cause) if cause else ""
            try:
                self.remaining.check(outcome.moved, before, size, label)
            except AraelError as refused:
                # Another solution, and what contradicts it, is looked for from where it was.
                self.document.set_values(np.arange(len(before)), before)
                found = self.solver.searched()
                if found is None:
                    raise (self._contradiction(cause, collapse=True) or refused) from None
                outcome = found
            self.remaining.check_near(before, size, moves)
            return outcome
        if outcome.status == "interrupted":
            raise broken_off()
        side = self._on_other_side(size)
        if side is not None and (side or outcome.guard):
            raise refusals.other_side(self._label(cause or outcome.row), outcome.guard or side)
        contradiction = self._contradiction(cause)
        if contradiction is not None:
            raise contradiction
        raise refusals.not_converged(outcome.open, outcome.residual)

    def _contradiction(self, cause: str, collapse: bool = False) -> AraelError | None:
        """The refusal that names what cannot hold together, if that is found.

        With `collapse` what cannot without leaving nothing of a line or circle: that names others,
        or says nothing that the refusal of the collapse does not.
        """
        # Where nothing contradicts the cause, another part did so before: a file may bring that.
        members, proven = self.judge.conflict(cause)
        if cause and not members:
            members, proven = self.judge.conflict()
        if self.solver.interrupted:  # trials that were broken off prove nothing
            return broken_off()
        if len(members) < (2 if collapse else 1):
            return None
        main = cause if cause in members else members[-1]
        others = [member for member in members if member != main]
        drop = self._cheapest(others)
        if not proven:
            return refusals.not_found(self._label(main), others, drop)
        return refusals.impossible(self._label(main), others, drop, collapse=collapse)

    def _on_other_side(self, size: float) -> str | None:
        """What is on another side in a solution that need not keep any; None: none was found.

        Empty if all sides are kept where it ends. Nothing collapses there.
        """
        found = self.solver.without_sides()
        if found is None or not self.remaining.is_drawing(found[0], size):
            return None
        return found[1]

    # --- entities ---------------------------------------------------------------------------

    def add(
        self,
        kind: str,
        numbers: ArrayLike,
        *,
        connect: bool = True,
        tangent: bool = True,
        construction: bool = False,
        quiet: bool = False,
        style: Style = "solid",
        text: str = "",
        clockwise: bool = False,
    ) -> Added:
        """A new entity, its ends connected to points that are within 1e-3.

        Parameters
        ----------
        kind, numbers : as `arael.sketch.document.kinds.ENTITIES` says
        connect : whether ends and centres become coincident with points near them
        tangent : whether a line or arc that continues another within 1 degree becomes tangent
        clockwise : of an arc: it starts where its numbers end

        Raises
        ------
        AraelError
            E1220: without extent
        """
        given = np.asarray(numbers, dtype=np.float64).ravel().tolist()
        size = max(self.layout.size, max(map(abs, given), default=1.0))
        check_extent(kind, given, size)
        with self.document.transaction(f"add {kind}"):
            entity = self.document.add_entity(
                kind,
                given,
                construction=construction,
                quiet=quiet,
                style=style,
                text=text,
                clockwise=clockwise,
            )
            connected = self._connect(entity) if connect else []
            tangents = self._tangents(entity, connected) if connect and tangent else []
        return Added(entity, tuple(connected), tuple(tangents))

    def _connect(self, entity: Entity) -> list[Constraint]:
        found: list[Constraint] = []
        for handle, at in own_points(entity).items():
            x, y = self.document.values[at : at + 2].tolist()
            for other in self._points.near(x, y, CONNECT_WITHIN):
                there = self.document.point_at(other)
                if other.partition(".")[0] == entity.name or self._is_same(at, there):
                    continue
                try:
                    with self.document.transaction("connect"):
                        found.append(self.constrain("coincident", (handle, other)))
                except AraelError:
                    if self.solver.interrupted:
                        raise
                    continue  # not connected: the ends cannot be one point
        return found

    def _is_same(self, a: int, b: int) -> bool:
        self.layout.refresh()
        return self.layout.same(a, b)

    def _tangents(self, entity: Entity, connected: Sequence[Constraint]) -> list[Constraint]:
        found: list[Constraint] = []
        for constraint in connected:
            mine, other = constraint.args
            neighbour = self.document.entities[other.partition(".")[0]]
            kinds = {entity.kind, neighbour.kind}
            if "arc" not in kinds or not kinds <= {"line", "arc"} or other.endswith(".center"):
                continue
            if mine.endswith(".center") or not nearly_parallel(
                direction_at(self.document, mine),
                direction_at(self.document, other),
                TANGENT_WITHIN,
            ):
                continue
            before = self.document.values.copy()
            try:
                with self.document.transaction("tangent"):
                    one = self.constrain("tangent", (neighbour.name, entity.name))
                    after = self.document.values
                    moved = np.flatnonzero(np.abs(after - before) > CONNECT_WITHIN)
                    if any(not entity.at <= at < entity.at + entity.size for at in moved):
                        raise _Pretended
                    found.append(one)
            except (AraelError, _Pretended):
                if self.solver.interrupted:
                    raise
                continue
        return found

    def change_entity(self, name: str, **flags: Any) -> Entity:
        """Change ``construction``, ``quiet``, ``style`` or ``text`` of an entity."""
        with self.document.transaction(f"change {name}"):
            return self.document.put("entities", replace(self.document.entity(name), **flags))

    def place(self, offsets: Sequence[int], numbers: ArrayLike) -> Outcome:
        """Put numbers of the document somewhere, then solve from there."""
        with self.document.transaction("place"):
            before, size = self.document.values.copy(), self.layout.size
            check_largest(np.ravel(numbers).tolist())
            self.document.set_values(offsets, numbers)
            outcome = self._settle()
            self.remaining.check_all(before, size)
        return outcome

    # --- constraints ------------------------------------------------------------------------

    def constrain(
        self,
        kind: str,
        args: Sequence[str],
        *,
        numbers: Sequence[float] = (),
        mode: str = "",
        force: bool = False,
    ) -> Constraint:
        """A new relation, which then holds.

        Parameters
        ----------
        kind, args, numbers, mode : as `arael.sketch.document.kinds.CONSTRAINTS` says
        force : let it in although it is redundant

        Raises
        ------
        AraelError
            E1221: there already; E1222: not with these operands; E1230 to E1234: redundant,
            impossible, redundant in this position, on the other side only, no solution found
        """
        _, spelt = matched(self.document, kind, tuple(args))
        check_itself(self.document, kind, spelt)
        self.layout.refresh()
        check_new_constraint(self.document, kind, spelt, self.layout.users_of(spelt[0]))
        check_collapse(self.document, kind, spelt)
        with self.document.transaction(f"{kind} {' '.join(spelt)}"):
            self._start_with(turned(self.layout, kind, spelt))
            record = Constraint(
                self._constraint_name(kind, spelt),
                kind,
                spelt,
                tuple(map(float, numbers)),
                self.layout.side_of(kind, spelt, mode),
                mode or mode_of(self.document, kind, spelt),
                forced=force,
            )
            if kind in ("coincident", "concentric", "lock") and not self._together:
                self._let_tie(record, force)
            else:
                self.document.put("constraints", record)
                self._let_in(record.name, force)
        return self.document.constraints[record.name]

    def _start_with(self, moves: Moves) -> None:
        for at, place in moves.items():
            self.document.set_values([at, at + 1], place)

    def _constraint_name(self, kind: str, args: tuple[str, ...]) -> str:
        if kind in ("horizontal", "vertical") and len(args) == 1:
            return f"C{args[0]}{kind[0].upper()}"
        return self.document.next_name("C")

    def change_constraint(self, name: str, **changes: Any) -> Constraint:
        """Change ``active``, ``numbers``, ``mode`` or ``side`` of a relation, then solve."""
        old = self.document.constraints[name]
        with self.document.transaction(f"change {name}"):
            self.document.put("constraints", replace(old, **changes))
            if changes.get("active") and not old.active:
                self._let_in(name, old.forced)
            else:
                self._settle(name)
        return self.document.constraints[name]

    def _let_tie(self, record: Constraint, force: bool) -> None:
        """Make two points one, or hold one; judged before, as it makes unknowns fewer."""
        points = [self._center_or_point(arg) for arg in record.args]
        self.layout.refresh()
        if record.kind == "lock":
            verdict = self.judge.lock_verdict(record.name, points[0], record.numbers)
        else:
            verdict = self.judge.tie_verdict(record.name, points[0], points[1])
        label = f"{record.kind} {' '.join(record.args)}"
        if verdict.kind == "impossible":
            turned = self._other_side_of(record, verdict.members)
            if turned:
                raise refusals.other_side(label, turned)
        self._refuse(verdict, force, label)
        self.document.put("constraints", record)
        self._settle(record.name)

    def _other_side_of(self, record: Constraint, members: Sequence[str]) -> str:
        """A tangent or distance whose other side lets a tie or lock in, by its curve; or empty."""
        document = self.document
        for name in members:
            table = "constraints" if name in document.constraints else "dimensions"
            one = getattr(document, table).get(name)
            if one is None or one.kind not in ("tangent", "distance") or not one.side:
                continue

            def holds(table: str = table, one: Any = one) -> bool:
                document.put(table, replace(one, side=-one.side))
                document.put("constraints", record)
                return self.solver.solve().solved

            if self.explain(holds):
                return str(one.args[-1].partition(".")[0])
        return ""

    def _center_or_point(self, handle: str) -> int:
        entity, point, _ = canonical(self.document, handle)
        return entity.at if not point else self.document.point_at(handle)

    def _label(self, name: str) -> str:
        """What a record says, for one that is not let in: ``length L2 6``."""
        document = self.document
        record = document.constraints.get(name) or document.dimensions.get(name)
        if record is None:
            return name
        value = ""
        if isinstance(record, Dimension) and record.value is not None:
            value = f" {record.value.text}"
        return f"{record.kind} {' '.join(record.args)}{value}"

    def _refuse(self, verdict: Verdict, force: bool, label: str = "") -> None:
        if self.solver.interrupted:
            raise broken_off()
        name = verdict.name
        label = label or self._label(name)
        others = [member for member in verdict.members if member != name]
        if verdict.kind == "impossible":
            why = "" if others else self.layout.impossible.get(name, "")
            raise refusals.impossible(label, others, self._cheapest(others), why)
        if verdict.kind == "side":
            record = self.document.constraints.get(name) or self.document.dimensions[name]
            raise refusals.other_side(label, record.args[-1].partition(".")[0])
        if verdict.kind == "redundant" and not force:
            raise refusals.redundant(label, others, self._cheapest(others))
        if verdict.kind == "here":
            self.notices.append(notices.only_here(label, verdict))

    def _let_in(self, name: str, force: bool) -> None:
        """Solve with a new row, or raise why not."""
        if self._together:
            return
        verdict, known = self.judge.verdict(name), len(self.notices)
        self._refuse(verdict, force)
        label = self._label(name)
        if name in self.document.dimensions:
            self._start_with(turned_to(self.layout, self.document.dimensions[name]))
        outcome = self._settle(name)
        if verdict.kind == "here" and outcome.moved and self.judge.verdict(name).kind == "helps":
            del self.notices[known:]  # the solution is in another position
        if name in self.document.dimensions:
            self.notices += notices.kept_by(self.document, name, verdict)
        elif verdict.kind == "partly":
            self.notices.append(notices.partly(label, verdict))

    def _judge_all(self, names: Sequence[str]) -> None:
        for verdict in self.judge.verdicts(names):
            self._refuse(verdict, self._forced(verdict.name))

    def _forced(self, name: str) -> bool:
        record = self.document.constraints.get(name) or self.document.dimensions.get(name)
        return record is not None and record.forced

    def _cheapest(self, names: Sequence[str]) -> str:
        """The one that is least missed: dimensions first, then the newest."""
        order = {one: i for i, one in enumerate(self.document.constraints)}
        order |= {one: len(order) + i for i, one in enumerate(self.document.dimensions)}
        return max(names, key=lambda one: order.get(one, -1), default="")

    # --- dimensions and parameters ----------------------------------------------------------

    def dimension(
        self,
        kind: str,
        args: Sequence[str],
        *,
        value: Amount | None = None,
        low: Amount | None = None,
        high: Amount | None = None,
        derived: bool = False,
        mode: str = "",
        force: bool = False,
    ) -> Dimension:
        """A new dimension, or a new value of the one there is.

        Parameters
        ----------
        value, low, high : what it is to be, or between what; all None: what it measures now
        derived : only measured
        mode : of angles ``supplement``, or which of the two is meant: ``closest`` to the value,
            the ``acute``, the ``obtuse`` one now

        Raises
        ------
        AraelError
            E1220: a value that it cannot have; E1222: not with these operands; E1230 to E1234
            as `constrain`
        """
        _, spelt = matched(self.document, kind, tuple(args))
        if kind == "area":
            spelt = outline(self.document, spelt, self._is_same)
        check_itself(self.document, kind, spelt)
        mode = self._mode(kind, spelt, mode, value)
        if value is None and low is None and high is None:
            now = measured(self.document, kind, spelt, mode)
            value = Amount(repr(now), now)
        known = self.known_dimension(kind, spelt)
        args = spelt if known is None else known.args
        value, low, high, side = sided(self.document, kind, spelt, mode, value, low, high, args)
        side = side or self._side(kind, args)
        if known is not None:
            return self.set_dimension(
                known.name,
                value=value,
                low=low,
                high=high,
                derived=derived,
                mode=mode,
                side=side,
            )
        check_amounts(kind, (value, low, high))
        with self.document.transaction(f"{kind} {' '.join(spelt)}"):
            name = self.document.next_name("d")
            record = Dimension(
                name, kind, spelt, value, low, high, derived, side, mode, forced=force
            )
            self.document.put("dimensions", record)
            if derived:
                self._settle(name)
            else:
                self._let_in(name, force)
        return self.document.dimensions[name]

    def known_dimension(self, kind: str, args: tuple[str, ...]) -> Dimension | None:
        """The dimension of a quantity, None if there is none."""
        self.layout.refresh()
        return same_dimension(self.document, kind, args, self.layout.users_of(args[0]))

    def _mode(self, kind: str, args: tuple[str, ...], mode: str, value: Amount | None) -> str:
        if kind == "distance":
            known = self.known_dimension(kind, args)
            return known.mode if known is not None else mode or mode_of(self.document, kind, args)
        if mode not in ("closest", "acute", "obtuse"):
            return mode
        plain, other = (measured(self.document, kind, args, m) for m in ("", "supplement"))
        if mode == "closest":
            wanted = abs(value.number) if value else plain
            return "" if abs(plain - wanted) <= abs(other - wanted) else "supplement"
        return "" if (plain <= other) == (mode == "acute") else "supplement"

    def _side(self, kind: str, args: tuple[str, ...]) -> int:
        if not DIMENSIONS[kind].signed:
            return 0
        return -1 if signed(self.document, kind, args, "") < 0.0 else 1

    def set_dimension(self, name: str, **changes: Any) -> Dimension:
        """Change fields of a dimension (``value``, ``derived``, ``offset``, ...), then solve.

        Raises
        ------
        AraelError
            E1222: an area that is to act again, whose outline is open; else as `dimension`
        """
        old = self.document.dimensions[name]
        only_placed = changes.keys() <= {"offset", "along"}
        if not only_placed:
            mode = changes.get("mode", old.mode)
            value, low, high = (changes.get(one) for one in ("value", "low", "high"))
            value, low, high, side = sided(
                self.document, old.kind, old.args, mode, value, low, high
            )
            if side:
                changes |= {"value": value, "low": low, "high": high, "side": side}
        return self._change_dimension(old, replace(old, **changes), only_placed)

    def _change_dimension(
        self, old: Dimension, new: Dimension, only_placed: bool = False
    ) -> Dimension:
        check_amounts(new.kind, (new.value, new.low, new.high))
        acts = new.active and not new.derived
        begins = acts and (not old.active or old.derived)
        if begins and new.kind == "area":  # it measures an outline that may be open by now
            outline(self.document, new.args, self._is_same)
        with self.document.transaction(f"change {new.name}"):
            if acts and not begins and new.value != old.value:
                self._start_with(turned_to(self.layout, new))
            self.document.put("dimensions", new)
            if not only_placed and new != old:
                self.notices += disowned(self.document, new.name)
            if begins:
                self._let_in(new.name, new.forced)
            elif not only_placed:
                self._settle(new.name)
        return self.document.dimensions[new.name]

    def measure(self, kind: str, args: Sequence[str], mode: str = "") -> float:
        """What a dimension of a kind would show now; angles in degrees."""
        _, spelt = matched(self.document, kind, tuple(args))
        if kind == "distance" and not mode:
            mode = mode_of(self.document, kind, spelt)
        return measured(self.document, kind, spelt, mode)

    def set_parameter(self, name: str, amount: Amount) -> Parameter:
        """A new parameter, or a new value of one; what reads it follows."""
        with self.document.transaction(f"param {name}"):
            self.document.put("parameters", Parameter(name, amount))
            self._settle(name)
        return self.document.parameters[name]

    # --- deleting, moving -------------------------------------------------------------------

    def delete(self, names: Sequence[str]) -> Deleted:
        """Take records out, with everything that rests on them."""
        found = doomed(self.document, names)
        with self.document.transaction(f"delete {' '.join(names)}"):
            self._remove(found)
            refresh(self.document)
            self._release_areas()
            self._renew_sides()
            self._tighten()
        return Deleted(tuple(found.names), found.dissolved)

    def _tighten(self) -> None:
        """Solve again what does not hold by the measure of the drawing that is left.

        Equations hold up to a share of the drawing's size: without its largest part they may not.
        """
        if not self.solver.left_open():
            return
        try:
            with self.document.transaction("tighten"):
                self._settle()
        except AraelError:
            if self.solver.interrupted:
                raise
            open_ = ", ".join(f"`{name}`" for name in self.solver.left_open()[:3])
            self.notices.append(f"notice: no solution was found for {open_} in what is left")

    def _release_areas(self) -> None:
        """Areas whose outline is open now only measure."""
        for one in list(self.document.dimensions.values()):
            if one.kind != "area" or one.derived:
                continue
            if is_open(self.document, one.args, self._is_same):
                self.document.put("dimensions", replace(one, derived=True))
                self.notices.append(f"notice: `{one.name}` only measures now: its outline is open")

    def _renew_sides(self) -> None:
        """Sides of relations that stood for each other's points, from how they are drawn now.

        Curves that touch in a point they share may pass from one side to the other there. Once
        the point is not shared any more, the side is held again: the one that is drawn.
        """
        for name in self.solver.left_open():
            one = self.document.constraints.get(name)
            if one is not None and one.kind == "tangent":
                mode = mode_of(self.document, one.kind, one.args)
                side = self.layout.side_of(one.kind, one.args, mode)
                self.document.put("constraints", replace(one, side=side, mode=mode))

    def _remove(self, found: Doomed) -> None:
        for table in ("groups", "dimensions", "constraints", "parameters", "entities"):
            for name in getattr(found, table):
                self.document.remove(table, name)
        for name in found.dissolved:
            self.document.remove("groups", name)

    @contextmanager
    def dragging(self, handles: Sequence[str]) -> Iterator[Dragging]:
        """A drag frame by frame, one step of undo as a whole.

        What the constraints leave open stays as near as possible to where it was at the beginning,
        not in the frame before: a drag out and back leads to where it began.
        """
        with self.document.transaction(f"drag {' '.join(handles)}"):
            yield Dragging(self, handles)

    def drag(self, moves: Mapping[str, tuple[float, float]]) -> Outcome:
        """Pull points to places as far as the constraints let them.

        Parameters
        ----------
        moves : handle of a point -> where to

        Raises
        ------
        AraelError
            E1220: something would collapse; E1234: no solution, or one at infinity. Everything is
            where it was
        """
        spelt = {canonical(self.document, handle)[2]: place for handle, place in moves.items()}
        with self.document.transaction(f"drag {' '.join(spelt)}"):
            at = [self.document.point_at(handle) for handle in spelt]
            before, size = self.document.values.copy(), self.layout.size
            since = self.document.moves
            outcome = self.solver.drag(at, np.array(list(spelt.values())))
            if outcome.status == "interrupted":
                raise broken_off()
            if not outcome.solved:
                raise refusals.not_converged(outcome.open, outcome.residual)
            self.remaining.check(outcome.moved, before, size)
            self.remaining.check_near(before, size, since)
        return outcome
