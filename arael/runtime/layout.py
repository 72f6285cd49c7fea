"""A compiled model for the runtime: tables, parameters, constraints as tapes, passes.

The compiler writes a `Layout`; the store, the data readers, the solver and the diagnosis read it.
It is plain data and is stored as JSON beside the compiled kernels, so that a cached model is loaded
without the language packages.

Words
-----
table
    A place where a struct can occur in a collection (``poses``, ``landmarks.frines``), or the root
    (path ``""``, one row). By-value structs do not make tables: their fields are columns of the
    owner's table under a dotted path (``info.gps.pos``).
entity
    A struct with parameters at one place: a table and a prefix within its rows.
slot
    A path from a constraint's row to a row of some table (through parent, refs, root).
state
    Per entity row, the values that kernels read: the stored form of its parameters, then caches
    (sines, rotation matrices and their derivatives).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.runtime.machine.tape import Tape

LAYOUT_VERSION = 5

ReadBy = tuple[int, ...]
"""Numbers of groups that are prepared from the same."""


class Step(msgspec.Struct, frozen=True):
    """One step from row to row: to the owner of this row, through a ref column, or to the root.

    In a typed model there are also steps to every row of the collection `ref`, for sums; where such
    a sum is written out, steps to one ``row`` of it, ``landmarks.frines[2]``. A step to ``near``
    leads to one of the rows that the value of a look-up depends on: the third of those of the
    second look-up is ``knots@2[2]``.
    """

    kind: Literal["parent", "ref", "root", "rows", "row", "near"]
    ref: str = ""

    @property
    def element(self) -> tuple[str, int]:
        """Collection and number of a ``row``, counted from 0 among the rows of one owner."""
        path, _, number = self.ref.removesuffix("]").rpartition("[")
        return path, int(number)

    @property
    def shown(self) -> str:
        """The step as a model writes it: ``prev``, ``knots[0]``, ``parent``."""
        if self.kind in ("rows", "row", "near"):
            return self.ref.rpartition(".")[2]
        name, _, last = self.ref.rpartition(".")
        return f"{name}[{last}]" if name and last.isdecimal() else self.ref or self.kind


class Part(msgspec.Struct, frozen=True):
    """Tangent scalars that are frozen together: ``translation`` of a transform."""

    name: str
    first: int
    count: int


class Param(msgspec.Struct, frozen=True):
    """How a column is solved for.

    `stored` scalars hold the value, `tangent` scalars are solved for; `parts` of them have
    `optimize` flags of their own. Bounds are one number per tangent scalar, or None where open;
    only plain parameters have them. Tangent scalars `held` are never solved for. What a component
    carries along is used as ``carried``, without a tangent; its column is data.
    """

    kind: Literal[
        "real",
        "vec",
        "euler",
        "rotation",
        "quaternion",
        "angle",
        "direction",
        "transform",
        "similarity",
        "carried",
    ]
    stored: int
    tangent: int
    low: tuple[float | None, ...] = ()
    high: tuple[float | None, ...] = ()
    parts: tuple[Part, ...] = ()
    held: tuple[int, ...] = ()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the tangent scalars that freeze by themselves: ``x``, ``y``, ``z``."""
        named = self.kind in ("vec", "euler") and self.tangent <= 3
        return ("x", "y", "z")[: self.tangent] if named else ()


def has_some(ends: Sequence[float | None]) -> bool:
    """Whether some component has a bound."""
    return ends.count(None) < len(ends)


class Target(msgspec.Struct, frozen=True):
    """Target of a ref: a table, and the path to the row that owns the collection.

    With ``feature: ref PointFeature in pose.info.features`` the table is ``poses.info.features``
    and `base` is ``(ref pose,)``; data files count the target within that owner.
    """

    table: str
    struct: str
    base: tuple[Step, ...]
    text: str  # the path as written


class Column(msgspec.Struct, frozen=True):
    """A field with values, as a column of a table.

    Attributes
    ----------
    path : dotted path within a row (``info.gps.pos``)
    kind : type of the scalars
    shape : shape of one value; ``()`` a scalar, ``(3,)`` a vector or Euler angles, ``(4,)`` a unit
        quaternion (w, x, y, z), ``(7,)`` a transform (translation, quaternion), ``(8,)`` one with
        scale, ``(3, 3)`` a matrix
    role : ``present`` marks the presence of an optional struct or scalar at this path
    type : the type as the model declares it (``vec3 [m]``), for messages
    where : place of the declaration (``slam.arael:31:5``), for messages
    default : flat values where the data leaves the field out; None: it must be given
    within : path of the nearest optional struct around (or at) this field, "" if none
    skip : declared with `skip`, so that no constraint reads it; a value or a ref
    """

    path: str
    kind: Literal["real", "int", "bool", "string"]
    shape: tuple[int, ...]
    role: Literal["data", "param", "ref", "present", "skip", "constraint_index"]
    type: str
    where: str
    unit: str = ""
    default: tuple[float, ...] | str | None = None
    param: Param | None = None
    target: Target | None = None
    within: str = ""
    doc: str = ""
    skip: bool = False


class ByValue(msgspec.Struct, frozen=True):
    """A struct held by value (or optionally) within the rows of a table.

    A list of `refs` refs is one as well: its fields ``0``, ``1``, ... are refs to `struct`.
    """

    path: str
    struct: str
    optional: bool
    where: str
    within: str = ""
    refs: int = 0


class Table(msgspec.Struct, frozen=True):
    """A collection, or the root.

    `field` is the path of the collection within a row of the parent table (``info.features``);
    `key` the string column by which refs in data may name a row, "" if none.
    """

    path: str
    struct: str
    collection: Literal["root", "list", "deque", "arena"]
    parent: str
    field: str
    where: str
    columns: tuple[Column, ...]
    values: tuple[ByValue, ...] = ()
    key: str = ""
    doc: str = ""

    def column(self, path: str) -> Column:
        """Return the column of that path; KeyError if there is none."""
        for column in self.columns:
            if column.path == path:
                return column
        raise KeyError(path)


class ParamUse(msgspec.Struct, frozen=True):
    """A parameter's place in its entity."""

    column: str  # full path in the table
    kind: str
    stored_start: int
    stored: int
    tangent_start: int
    tangent: int


class Formula(msgspec.Struct, frozen=True):
    """A formula of a component: outputs of `Entity.values` from number `first` on."""

    path: str
    kind: Literal["real", "bool"]
    shape: tuple[int, ...]
    first: int


class Entity(msgspec.Struct, frozen=True, dict=True):
    """A struct with parameters at one place, those of its components included.

    `refresh` computes the state of a row from its stored scalars and a step: inputs are the stored
    scalars, then the tangent step; outputs the whole state (new stored scalars first). It carries
    out the updates of components as well, which set the columns `updated`. `values` computes
    `formulas` of components from the stored scalars.
    """

    struct: str
    table: str
    prefix: str  # "" or "info." (with the dot)
    params: tuple[ParamUse, ...]
    stored: int
    tangent: int
    state: int
    refresh: Tape
    tangent_names: tuple[str, ...]  # "pos.x", "ea.z"
    updated: tuple[str, ...] = ()
    formulas: tuple[Formula, ...] = ()
    values: Tape | None = None

    @cached_property
    def curved(self) -> bool:
        """Whether some parameter is no vector: its step is not added to its stored scalars."""
        return not all(use.kind in ("real", "vec") for use in self.params)

    @cached_property
    def plain(self) -> bool:
        """Whether a row contains only reals to which a step is added."""
        return not self.updated and self.stored == self.tangent == self.state and not self.curved

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """Columns of the parameters."""
        return tuple(use.column for use in self.params)

    @cached_property
    def stored_starts(self) -> list[int]:
        """First stored scalar of each parameter."""
        return [use.stored_start for use in self.params]

    @cached_property
    def written_by(self) -> tuple[list[int], list[int]]:
        """First and number of the tangent scalars that change each parameter, if they move.

        An update may set what no step moves: what is carried along, and what is fixed.
        """
        firsts, counts = [], []
        for use in self.params:
            updated = use.column in self.updated
            firsts.append(0 if updated else use.tangent_start)
            counts.append(self.tangent if updated else use.tangent)
        return firsts, counts

    @cached_property
    def places(self) -> NDArray[np.int32]:
        """(params, 4) first stored scalar, their number, first tangent scalar, their number."""
        found = np.array(
            [(u.stored_start, u.stored, u.tangent_start, u.tangent) for u in self.params],
            dtype=np.int32,
        ).reshape(-1, 4)
        found.setflags(write=False)
        return found


class Slot(msgspec.Struct, frozen=True):
    """A way from the constraint's row to another; no steps: the row itself."""

    steps: tuple[Step, ...]
    table: str


def without_row_slots(slots: tuple[Slot, ...]) -> tuple[Slot, ...]:
    """The slots of a constraint, with its own row in place of what sums run over."""
    return tuple(slots[0] if any(s.kind == "rows" for s in x.steps) else x for x in slots)


class Use(msgspec.Struct, frozen=True):
    """An entity that a constraint reads at trial values; its tangent columns in `tape.outputs`."""

    slot: int
    entity: int


CONSTANT = "="
"""Column of raw inputs that are a named constant: in groups derived for derivatives by it."""


class Raw(msgspec.Struct, frozen=True):
    """One scalar of a column reached through a slot: data, or the stored value of a parameter.

    A `column` that ends with ``?`` is the presence of the optional at that path; one with a ``#``
    is the name of a `Total` of the group.
    """

    slot: int
    column: str
    component: int = 0


class Total(msgspec.Struct, frozen=True):
    """Sums over the rows of a collection, each of data alone, for every row that owns some.

    Attributes
    ----------
    name : by which a `Raw` of the owner's row reads it: component k is output k of `tape`, summed
    owner : table of the owners
    collection : table of the rows that are added
    slots, raw : ways from such a row, and what `tape` reads through them
    """

    name: str
    owner: str
    collection: str
    slots: tuple[Slot, ...]
    raw: tuple[Raw, ...]
    tape: Tape


class LookUp(msgspec.Struct, frozen=True):
    """A look-up between the rows of a collection.

    The argument is evaluated by `Group.arguments`. The lane inputs from `first` on are the number
    of the interval that it lies in, then the record of this interval (`look_up_tables.py`).

    Attributes
    ----------
    slot : of the row that owns the collection
    collection : table of the rows
    key, column : its columns: where the rows are, and what data is interpolated; "" for parameters
    rows : of parameters, the slots of the rows that a value depends on, in order; else none
    order : rows that a value depends on
    spline : whether rows are the control points of a B-spline; else they are interpolated
    value : ``vector`` also of one scalar; ``wrapped`` an angle; ``weights`` of the rows, where
        these are parameters
    width : scalars of the column; number of the weights
    clamp : whether an argument outside has the value at the nearest end; else none
    first : number of a lane input
    where, text : place and text in the model
    """

    slot: int
    collection: str
    key: str
    column: str
    order: int
    spline: bool
    value: Literal["vector", "wrapped", "rotation", "transform", "weights"]
    width: int
    clamp: bool
    first: int
    where: str
    text: str
    rows: tuple[int, ...] = ()

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self.order - 1

    @property
    def moved(self) -> int:
        """Leading scalars of the column that are interpolated by polynomials."""
        return {"rotation": 0, "transform": 3}.get(self.value, self.width)

    @property
    def turned(self) -> bool:
        """Whether the column ends with a quaternion."""
        return self.value in ("rotation", "transform")

    @property
    def record(self) -> int:
        """Scalars of the record of an interval."""
        size = 1 + 2 * self.clamp + self.moved * self.order
        if self.turned:
            size += 4 + 3 if self.order == 2 else 4 + self.degree * (3 + self.order)
        return size


class Length(msgspec.Struct, frozen=True):
    """Instances of a group by the number of rows in a list: from `low` to `high`.

    Attributes
    ----------
    slot : of the row that owns the list
    collection : table of the rows
    """

    slot: int
    collection: str
    low: int = 0
    high: int = 0


class Piece(msgspec.Struct, frozen=True):
    """One of the programs that a constraint with sums over rows consists of.

    Attributes
    ----------
    inputs : kind of each input and its numbers: ``state`` (use, offset); ``lane`` and ``row``, a
        lane input of the instance or of the row; ``uniform``; ``sum`` (sum, component); ``guard``
    values : number of values; outputs of `tape` are these, then their derivatives
    entries : of each derivative, the value, the use and its tangent scalar; by a component of sum s
        the use is ``-1 - s``
    """

    inputs: tuple[tuple[Literal["state", "lane", "row", "uniform", "sum", "guard"], int, int], ...]
    tape: Tape
    values: int
    entries: tuple[tuple[int, int, int], ...] = ()


class RowSums(msgspec.Struct, frozen=True):
    """Sums over rows that are evaluated term by term: `arael.runtime.unrolled` writes them out.

    Attributes
    ----------
    slots, uses : of the constraint, those of rows included; a way to the rows has a step ``rows``
    lists : per list that is summed over, the slots of its owner and of its rows
    raw, prepare : data of an instance, and the program whose outputs are lane inputs, then uniforms
    uniforms : number of uniforms
    row_raw, row_prepare : the same per list, for one row
    main : residuals, which read sums
    sums : per sum the number of its list, and the program of its term; it may read sums before it
    guard : over parameters, which may read sums
    crossed : pairs of uses, ascending, that have a named block of the Hessian
    """

    slots: tuple[Slot, ...]
    uses: tuple[Use, ...]
    lists: tuple[tuple[int, int], ...]
    raw: tuple[Raw, ...]
    prepare: Tape
    uniforms: int
    row_raw: tuple[tuple[Raw, ...], ...]
    row_prepare: tuple[Tape, ...]
    main: Piece
    sums: tuple[tuple[int, Piece], ...]
    guard: Piece | None = None
    crossed: tuple[tuple[int, int], ...] = ()

    def list_of(self, slot: int) -> int:
        """Number of the list whose rows a slot is, or is reached from; -1 if there is none."""
        steps = self.slots[slot].steps
        for number, (_, rows) in enumerate(self.lists):
            way = self.slots[rows].steps
            if steps[: len(way)] == way:
                return number
        return -1


class Place(msgspec.Struct, frozen=True):
    """An expression of the model, for messages about runtime failures."""

    where: str
    text: str


class Group(msgspec.Struct, frozen=True, dict=True):
    """One constraint at one table: what is evaluated for each of its instances.

    `prepare` runs once per solve on whole columns: inputs are `raw`, outputs first the `data_count`
    lane inputs of the kernel, then the `uniform_count` ones that are the same for all instances.
    `tape` is the kernel: inputs are the state scalars `states` (use, offset), then the lane inputs,
    then the uniforms; outputs are the residuals, then the structurally non-zero Jacobian entries
    `jacobian` as (residual, use, tangent index). If the constraint has a loss, the squares of
    the residuals sum to it, so that cost and derivatives need no special case.

    Kernels accumulate the blocks of the uses `lead` as long as instances share them; the runtime
    passes instances sorted by the first of these.

    `guard` chooses instances by their data. `moving_guard` reads parameters: it is a tape over the
    inputs of `tape`, evaluated at each linearisation into the last of the lane inputs, which the
    residuals are switched by.

    `arguments` is a tape over the same inputs; its outputs are the arguments of `look_ups`.

    With `require` the residuals add nothing to the cost: they are zero at a solution, or not
    negative.

    `sigma` is over `sigma_raw` alone: standard deviations of a prior, which must be positive.

    With `row_sums` the group is for instances whose lists are empty. The others are in groups that
    `arael.runtime.unrolled` appends, one for each of some `lengths`; `case_of` is the number of the
    group they belong to.
    """

    label: str
    struct: str
    constraint: str
    where: str
    table: str
    prefix: str
    residuals: int
    slots: tuple[Slot, ...]
    uses: tuple[Use, ...]
    raw: tuple[Raw, ...]
    prepare: Tape
    data_count: int
    uniform_count: int
    states: tuple[tuple[int, int], ...]
    tape: Tape
    jacobian: tuple[tuple[int, int, int], ...]
    places: tuple[Place, ...]
    lead: tuple[int, ...] = ()
    guard: Tape | None = None
    guard_raw: tuple[Raw, ...] = ()
    guard_text: str = ""
    sigma: Tape | None = None
    sigma_raw: tuple[Raw, ...] = ()
    moving_guard: Tape | None = None
    look_ups: tuple[LookUp, ...] = ()
    arguments: Tape | None = None
    loss_text: str = ""
    triplets: str = ""  # field of the root that stands for these pairs of uses
    triplet_pairs: tuple[tuple[int, int], ...] = ()
    index_column: str = ""
    totals: tuple[Total, ...] = ()
    lengths: tuple[Length, ...] = ()
    row_sums: RowSums | None = None
    case_of: int = -1
    operations_before: int = 0
    operations_after: int = 0
    require: Literal["", "equal", "at_least"] = ""  # residuals hold: are zero, or not negative
    require_text: str = ""  # the comparison, as written
    units: tuple[str, ...] = ()  # of the residuals that hold; "" where there is none
    workspace: int = 0  # columns of lanes that a kernel in parts keeps; 0: it is in one piece
    doc: str = ""

    @cached_property
    def raw_columns(self) -> Columns:
        """The columns that `raw` reads."""
        return columns_of(self.raw)

    @cached_property
    def reads_rows(self) -> bool:
        """Whether `raw` reads some row other than the root's."""
        return any(self.slots[raw.slot].table != "" for raw in self.raw)

    @cached_property
    def uncoupled(self) -> tuple[tuple[int, int], ...]:
        """`uncoupled_pairs` in order."""
        return tuple(sorted(uncoupled_pairs(self)))

    @cached_property
    def lead_pairs(self) -> list[int]:
        """Pairs of its first lead with the other uses, if it has a lead."""
        return [pair_of(u, self.lead[0]) for u in range(len(self.uses)) if u != self.lead[0]]

    @cached_property
    def written(self) -> tuple[tuple[Literal["guard", "arguments"], Tape, tuple[int, ...]], ...]:
        """Tapes whose results are written into lanes of data, and the numbers of these lanes."""
        found: list[tuple[Literal["guard", "arguments"], Tape, tuple[int, ...]]] = []
        if self.moving_guard is not None:
            found.append(("guard", self.moving_guard, (self.data_count - 1,)))
        if self.arguments is not None:
            found.append(
                ("arguments", self.arguments, tuple(one.first + 1 for one in self.look_ups))
            )
        return tuple(found)

    @cached_property
    def jacobian_table(self) -> NDArray[np.int64]:
        """`jacobian` as an array (entries, 3)."""
        return np.array(self.jacobian, dtype=np.int64).reshape(-1, 3)

    @cached_property
    def is_curved(self) -> bool:
        """Whether derivatives depend on parameters."""
        if self.look_ups:  # what they read depends on parameters
            return True
        tape = self.tape
        depends = [False] * len(tape.ops)
        for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
            if op == "input":
                depends[node] = args[0] < len(self.states)
            elif op != "const":
                depends[node] = any(depends[a] for a in args)
        return any(depends[node] for node in tape.outputs[self.residuals :])

    @cached_property
    def near(self) -> tuple[int, ...]:
        """Numbers of its look-ups of parameters, whose arguments choose rows."""
        return tuple(number for number, one in enumerate(self.look_ups) if one.rows)

    @cached_property
    def moves_rows(self) -> bool:
        """Whether parameters choose which rows an instance reads."""
        if self.arguments is None:
            return False
        return bool(self.near) and any(
            op == "input" and args[0] < len(self.states)
            for op, args in zip(self.arguments.ops, self.arguments.args, strict=True)
        )

    @cached_property
    def calls_natives(self) -> bool:
        """Whether it calls native functions, which may not bear being called concurrently."""
        return any(tape.natives for tape in (self.tape, *(tape for _, tape, _ in self.written)))


Columns = tuple[tuple[int, str, list[int], list[int]], ...]
"""Columns that inputs read: slot, column, numbers of the inputs, their components."""


def columns_of(raws: Sequence[Raw]) -> Columns:
    """The columns that `raws` read, each once."""
    found: dict[tuple[int, str], tuple[list[int], list[int]]] = {}
    for number, raw in enumerate(raws):
        numbers, components = found.setdefault((raw.slot, raw.column), ([], []))
        numbers.append(number)
        components.append(raw.component)
    return tuple((slot, column, *both) for (slot, column), both in found.items())


def pair_of(a: int, b: int) -> int:
    """Number of the pair of uses `a` and `b` of a group: (0, 0), (1, 0), (1, 1), (2, 0) ..."""
    a, b = max(a, b), min(a, b)
    return a * (a + 1) // 2 + b


def pair_count(uses: int) -> int:
    """Pairs of so many uses, each with itself included."""
    return uses * (uses + 1) // 2


def uncoupled_pairs(group: Group) -> set[tuple[int, int]]:
    """Pairs of uses ``(a, b)``, a > b, that no residual reads together: their block stays zero."""
    residuals: list[set[int]] = [set() for _ in group.uses]
    for residual, use, _ in group.jacobian:
        residuals[use].add(residual)
    uses = range(len(group.uses))
    return {(a, b) for a in uses for b in range(a) if residuals[a].isdisjoint(residuals[b])}


def coupled_pairs(group: Group) -> NDArray[np.uint8]:
    """(pairs,) whether some residual reads both uses of a pair; each use is coupled with itself."""
    found = np.ones(pair_count(len(group.uses)), dtype=np.uint8)
    for a, b in uncoupled_pairs(group):
        found[pair_of(a, b)] = 0
    return found


class BlockEnd(msgspec.Struct, frozen=True):
    """Entity whose parameters give the rows or columns of a block, and the path to its row."""

    slot: Slot
    entity: int


class Block(msgspec.Struct, frozen=True):
    """A block of the Hessian that the model names.

    A self block has one end, a cross block two; `triplets` of the root have none: they stand for
    the pairs of the groups that name them.
    """

    name: str
    table: str
    prefix: str  # "" or "info." (with the dot)
    kind: Literal["self", "cross", "triplets"]
    ends: tuple[BlockEnd, ...]
    where: str
    doc: str = ""


class PassSetting(msgspec.Struct, frozen=True):
    """Root data set before a pass: a column of the root and its flat value."""

    column: str
    value: tuple[float, ...]


class LayoutPass(msgspec.Struct, frozen=True):
    """One pass of the solve schedule; `arael.Pass` is how Python writes one."""

    name: str
    settings: tuple[PassSetting, ...] = ()
    config: dict[str, float | int | bool | str] = {}
    freeze: tuple[str, ...] = ()
    free: tuple[str, ...] = ()


class Function(msgspec.Struct, frozen=True):
    """A function of the model, as a function of scalars.

    Attributes
    ----------
    native : whether its value comes from native code that the caller binds
    text, derivs : formula and derivatives as the model writes them; "" and () where it has none
    shape : shape of its value
    tape : its value, flat; inputs are the parameters. None if its formula does not take scalars.
    partials : its derivatives, one row per scalar of the value, one column per parameter
    """

    name: str
    params: tuple[str, ...]
    native: bool
    text: str
    derivs: tuple[str, ...]
    where: str
    shape: tuple[int, ...] = ()
    tape: Tape | None = None
    partials: Tape | None = None
    doc: str = ""

    @property
    def item(self) -> str:
        """The function as an item of a model's text."""
        head = f"{'extern ' * self.native}fn {self.name}({', '.join(self.params)})"
        derivs = f" derivs [{', '.join(self.derivs)}]" if self.derivs else ""
        return head + derivs + (f" = {self.text}" if self.text else "")


class Constant(msgspec.Struct, frozen=True):
    """A constant of the model, as the model writes it."""

    name: str
    text: str


class Layout(msgspec.Struct, frozen=True, dict=True):
    """A compiled model."""

    version: int
    name: str  # name of the model: the file's stem
    root: str  # struct name of the root
    precision: Literal["f32", "f64"]
    source: str  # file name as the user gave it
    tables: tuple[Table, ...]  # the root first, owners before what they own
    entities: tuple[Entity, ...]
    groups: tuple[Group, ...]
    passes: tuple[LayoutPass, ...]
    blocks: tuple[Block, ...] = ()
    warnings: tuple[str, ...] = ()  # rendered, for a warm start to repeat
    functions: tuple[Function, ...] = ()
    constants: tuple[Constant, ...] = ()
    marginalize: tuple[str, ...] = ()  # tables that the Schur complement is to eliminate
    doc: str = ""

    @property
    def natives(self) -> tuple[str, ...]:
        """Names of the native functions, in the order in which kernels number them."""
        return tuple(f.name for f in self.functions if f.native)

    @property
    def items(self) -> str:
        """Constants and functions as items of a model's text, one a line."""
        lines = [f"const {c.name} = {c.text}" for c in self.constants]
        lines += [f.item for f in self.functions]
        return "".join(f"{line}\n" for line in lines)

    @cached_property
    def robust(self) -> bool:
        """Whether a constraint has a loss."""
        return any(group.loss_text for group in self.groups)

    @cached_property
    def required(self) -> tuple[int, ...]:
        """Numbers of the groups whose residuals hold exactly."""
        return tuple(n for n, group in enumerate(self.groups) if group.require)

    @cached_property
    def coupled(self) -> tuple[NDArray[np.uint8], ...]:
        """`coupled_pairs` of all groups."""
        return tuple(coupled_pairs(group) for group in self.groups)

    @cached_property
    def bounded(self) -> tuple[bool, ...]:
        """Per entity, whether the model bounds a component of a parameter."""
        return tuple(
            any(
                param is not None and (has_some(param.low) or has_some(param.high))
                for param in (self.table(e.table).column(use.column).param for use in e.params)
            )
            for e in self.entities
        )

    @cached_property
    def passed(self) -> tuple[frozenset[str] | None, ...]:
        """Per group, the tables whose rows and refs alone decide which rows its instances read.

        None where data does as well, and of lists.
        """
        return tuple(self._passed(group) for group in self.groups)

    def _passed(self, group: Group) -> frozenset[str] | None:
        if group.guard is not None or group.lengths:
            return None
        found = {group.table}
        for slot in group.slots:
            path = group.table
            for step in slot.steps:
                if step.kind == "root":
                    path = ""
                elif step.kind == "parent":
                    path = self.table(path).parent
                elif step.kind == "ref" and (to := self.table(path).column(step.ref).target):
                    path = to.table
                else:
                    return None
                found.add(path)
        return frozenset(found)

    @cached_property
    def readers(self) -> dict[tuple[str, str], tuple[int, ...]]:
        """Table and column of all data -> numbers of the groups that are prepared from it."""
        found: dict[tuple[str, str], list[int]] = {}
        for number, group in enumerate(self.groups):
            reads = [(group.slots, raw) for raw in group.raw]
            reads += [(total.slots, raw) for total in group.totals for raw in total.raw]
            places = {(slots[raw.slot].table, raw.column) for slots, raw in reads}
            for one in group.look_ups:
                places.add((one.collection, one.key))
                if one.column:
                    places.add((one.collection, one.column))
            for place in places:
                if "#" not in place[1]:  # a total, whose own reads are here
                    found.setdefault(place, []).append(number)
        return {place: tuple(numbers) for place, numbers in found.items()}

    @cached_property
    def read_columns(
        self,
    ) -> dict[str, tuple[tuple[str, ...], tuple[str, ...], tuple[ReadBy, ...]]]:
        """By table: columns with values, optionals, and of each in turn who reads it."""
        found: dict[str, tuple[dict[str, ReadBy], dict[str, ReadBy]]] = {}
        for (table, column), groups in self.readers.items():
            values, optionals = found.setdefault(table, ({}, {}))
            if column.endswith("?"):
                optionals[column[:-1]] = groups
            else:
                values[column] = groups
        return {
            table: (tuple(values), tuple(optionals), (*values.values(), *optionals.values()))
            for table, (values, optionals) in found.items()
        }

    @cached_property
    def angles(self) -> tuple[tuple[str, Column], ...]:
        """Path of its table and column of what is an angle in radians: parameters and data."""
        return tuple(
            (table.path, column)
            for table in self.tables
            for column in table.columns
            if (column.role == "param" and column.param and column.param.kind in ("angle", "euler"))
            or (column.role == "data" and column.unit == "rad" and column.kind == "real")
        )

    @cached_property
    def summed(self) -> tuple[int, ...]:
        """Numbers of the groups with sums over rows that are evaluated term by term."""
        return tuple(n for n, group in enumerate(self.groups) if group.row_sums is not None)

    @cached_property
    def totals(self) -> dict[tuple[str, str], Total]:
        """Sums over collections, by the table of the owner and name."""
        return {(t.owner, t.name): t for group in self.groups for t in group.totals}

    @cached_property
    def _by_path(self) -> dict[str, Table]:
        return {table.path: table for table in self.tables}

    def table(self, path: str) -> Table:
        """Return the table of that path; KeyError if there is none."""
        return self._by_path[path]


def to_json(layout: Layout) -> bytes:
    """Write the layout as JSON."""
    return msgspec.json.encode(layout)


def from_json(data: bytes) -> Layout:
    """Read a layout from its JSON; msgspec.ValidationError if it is not one."""
    return msgspec.json.decode(data, type=Layout)
