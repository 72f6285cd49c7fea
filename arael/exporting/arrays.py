"""The arrays that exported functions read and write, with the meaning of each scalar."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

from arael.compiler.groups import Kernel
from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.identifiers import Names, identifier
from arael.manifolds.parameters import parameter_type
from arael.manifolds.parameters.kind import numbered, plain
from arael.runtime.layout import Entity, Layout, ParamUse, Table


@dataclass(frozen=True)
class Part:
    """Some neighbouring scalars of an array.

    Attributes
    ----------
    name : as the model has it, ``info.gps.pos``
    first, count : offset of the first scalar, and their number
    unit : of the model; "" without one
    type : as the model declares it, or what it is
    suffixes : what follows `name` in the name of each scalar
    """

    name: str
    first: int
    count: int
    unit: str
    type: str
    suffixes: tuple[str, ...]


@dataclass(frozen=True)
class Array:
    """An array that a function reads: the parameters of an entity, or the data of a row.

    Attributes
    ----------
    name : C identifier within the model, ``pose``, ``edge_data``
    title : in words
    size : scalars
    parts : what they are, in order
    """

    name: str
    title: str
    size: int
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class ParameterSet:
    """Stored scalars of an entity, and the step that moves them.

    Attributes
    ----------
    entity : of the layout
    number : of the entity in the layout
    stored : array of the stored scalars
    tangent : array of a step
    """

    entity: Entity
    number: int
    stored: Array
    tangent: Array


@dataclass(frozen=True)
class Arrays:
    """All arrays of a model.

    Attributes
    ----------
    parameters : by number of the entity
    data : by table, what constraints read of a row of it
    """

    parameters: tuple[ParameterSet, ...]
    data: dict[str, Array]

    def offset(self, table: str, column: str, component: int) -> int:
        """Offset of one scalar in the data of `table`."""
        for part in self.data[table].parts:
            if part.name == column:
                return part.first + component
        raise KeyError((table, column))


_OF_PROGRAMS = (
    "data", "default_options", "options", "parameters", "result", "solve", "state", "status",
    "strategy",
)  # fmt: skip
"""Names that exported programs have for themselves."""


def arrays_of(layout: Layout, kernels: tuple[Kernel, ...]) -> Arrays:
    """Lay out the arrays that the constraints of `kernels` read."""
    names = Names(_OF_PROGRAMS)
    parameters = tuple(
        _parameter_set(names, layout, number, entity)
        for number, entity in enumerate(layout.entities)
    )
    read: dict[str, dict[str, int]] = {}
    for kernel in kernels:
        group = kernel.group
        sizes = {total.name: len(total.tape.outputs) for total in group.totals}
        for raw in [*group.raw, *group.guard_raw]:
            table = group.slots[raw.slot].table
            read.setdefault(table, {})[raw.column] = sizes.get(raw.column, 0)
    data = {
        table.path: _data(names, table, read[table.path])
        for table in layout.tables
        if table.path in read
    }
    return Arrays(parameters, data)


def type_of(use: ParamUse) -> str:
    """Name of a parameter's type as the language spells it."""
    if use.kind in ("vec", "carried"):
        return f"vec{use.stored}" if use.kind == "vec" else "carried along"
    return use.kind


def _parameter_set(names: Names, layout: Layout, number: int, entity: Entity) -> ParameterSet:
    table = layout.table(entity.table)
    within = entity.prefix.removesuffix(".")
    place = f"{entity.table or 'the root'}{f', {within}' if within else ''}"
    name = names.take(identifier(entity.struct))
    stored, tangent = [], []
    for use in entity.params:
        short = use.column.removeprefix(entity.prefix)
        column = table.column(use.column)
        flat = use.kind in ("real", "vec", "carried")
        kind = plain("", use.stored) if flat else parameter_type(use.kind)
        stored.append(
            Part(short, use.stored_start, use.stored, column.unit, type_of(use), kind.stored_names)
        )
        if use.tangent:
            suffixes = kind.tangent_names[: use.tangent]
            step = Part(short, use.tangent_start, use.tangent, column.unit, type_of(use), suffixes)
            tangent.append(step)
    return ParameterSet(
        entity,
        number,
        Array(name, f"parameters of {entity.struct}, {place}", entity.stored, tuple(stored)),
        Array(f"{name}_step", f"a step of {entity.struct}", entity.tangent, tuple(tangent)),
    )


def _data(names: Names, table: Table, read: dict[str, int]) -> Array:
    parts: list[Part] = []
    size = 0

    def add(name: str, count: int, unit: str, what: str) -> None:
        nonlocal size
        parts.append(Part(name, size, count, unit, what, numbered(count)))
        size += count

    for column in table.columns:
        if column.path in read:
            stored = " at the start of a solve" if column.role == "param" else ""
            add(column.path, prod(column.shape), column.unit, f"{column.type}{stored}")
    for name, count in read.items():
        if name.endswith("?"):
            add(name, 1, "", "1 if it is there, else 0")
        elif "#" in name:
            add(name, count, "", "a sum over rows, which the caller computes")
    place = table.path or "the root"
    name = names.take(f"{identifier(table.struct)}_data")
    return Array(name, f"data of {table.struct}, {place}", size, tuple(parts))


def refuse_rows(kernels: tuple[Kernel, ...]) -> None:
    """Refuse constraints whose program depends on the rows of lists."""
    for kernel in kernels:
        if kernel.group.look_ups:
            raise AraelError(
                Diagnostic(
                    "E1501",
                    f"`{kernel.group.label}` looks rows up, which exported code cannot",
                    origin=kernel.group.look_ups[0].where,
                    notes=(f"it reads `{kernel.group.look_ups[0].text}`",),
                    help=(
                        "let the data have the value as a column of its own, or leave the "
                        "constraint out with --constraint",
                    ),
                )
            )
        if kernel.group.require:
            raise AraelError(
                Diagnostic(
                    "E1038",
                    "exported code cannot take what holds exactly: "
                    f"`{kernel.group.label}` is a `require`",
                    origin=kernel.group.where,
                    help=(
                        "write it as a constraint with a small sigma, or leave it out with "
                        "--constraint",
                    ),
                )
            )
        if kernel.group.row_sums is not None:
            raise AraelError(
                Diagnostic(
                    "E1501",
                    f"`{kernel.group.label}` sums over a list term by term, and the length of a "
                    "list is not known when code is exported",
                    origin=kernel.group.where,
                    help=(
                        "give the list a length, `[ref Knot in root.knots; 4]`, or leave the "
                        "constraint out with --constraint",
                    ),
                )
            )
