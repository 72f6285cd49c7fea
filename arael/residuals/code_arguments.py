"""Arguments of residuals by own code: parameters of the model, given as handles, and data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.collection import Collection
from arael.face.parameter import Parameter
from arael.face.ref import Ref, Refs
from arael.residuals.messages import error, label_problem
from arael.runtime.layout import Entity

Array = NDArray[Any]


@dataclass(frozen=True)
class Argument:
    """A parameter of the model at chosen rows.

    Attributes
    ----------
    table, column : where it is
    refs : its rows, one for all instances or one for each; None for a parameter of the root
    shape : of one value
    """

    table: str
    column: str
    refs: Refs | None
    shape: tuple[int, ...]

    @property
    def name(self) -> str:
        """The parameter without its rows: ``poses.pos``."""
        return f"{self.table}.{self.column}" if self.table else self.column

    def name_at(self, row: int) -> str:
        """The parameter of one instance: ``poses[3].pos``."""
        if self.refs is None:
            return self.column
        refs = self.refs
        at = int(np.broadcast_to(refs.rows, (max(row + 1, len(refs)),))[row])
        return refs._table.name_of(at, self.column) if at >= 0 else f"{self.name} (removed)"

    def same_rows(self, other: Argument) -> bool:
        """Whether both are of the same rows."""
        if self.table != other.table or (self.refs is None) != (other.refs is None):
            return False
        if self.refs is None or other.refs is None:
            return True
        return np.array_equal(self.refs._handles, other.refs._handles)


def arguments(model: Any, handles: Any, label: str) -> tuple[Argument, ...]:
    """Check the handles of a call of `Model.add_residuals`.

    Raises
    ------
    AraelError
        E0770: not parameters of the model.
    """
    if isinstance(handles, Parameter | Collection | Ref | Mapping) or not isinstance(
        handles, Iterable
    ):
        raise error(
            "E0770",
            f"`parameters` is a list of parameters, found {_kind(handles)}",
            label,
            "write `parameters=[model.poses.pos]`",
        )
    found = tuple(_argument(model, one, k, label) for k, one in enumerate(handles))
    return found


def _argument(model: Any, handle: Any, number: int, label: str) -> Argument:
    where = f"{label}: parameters[{number}]"
    if not isinstance(handle, Parameter):
        raise error(
            "E0770",
            f"expected a parameter of the model, found {_kind(handle)}",
            where,
            _advice(handle),
        )
    table = handle._table
    if table.store is not model._store:
        raise error(
            "E0770",
            f"`{handle._name}` is a parameter of another model instance",
            where,
            "take it from the model that the residuals are added to",
        )
    column = handle._column
    refs = None
    if table.layout.path:
        handles = np.atleast_1d(np.asarray(table.handles(handle._rows()), dtype=np.int64))
        refs = Refs(table, handles.copy())
        present = np.ones(len(handles), bool)
        if column.within:
            present = np.asarray(table.present(column.within))[refs.rows]
        if not present.all():
            row = int(refs.rows[np.argmin(present)])
            raise error(
                "E0770",
                f"`{table.name_of(row, handle._path)}` is absent",
                where,
                f"`{column.within}` is optional: choose the rows that have it",
            )
    return Argument(table.layout.path, handle._path, refs, column.shape)


def _kind(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, Collection | Ref | Refs):
        return f"rows of `{value._table.label}`"
    return f"{type(value).__name__}"


def _advice(value: object) -> str:
    if isinstance(value, Collection | Ref | Refs):
        return "name a parameter of these rows: `model.poses.pos`, `model.poses[3].pos`"
    return (
        "choose rows before the parameter: `model.poses[rows].pos` is a parameter, "
        "`model.poses.pos[rows]` are its present values"
    )


def columns(data: Mapping[str, Any] | None, label: str) -> dict[str, Array]:
    """Check data: arrays of numbers with one row per instance, or single numbers.

    Raises
    ------
    AraelError
        E0770: no numbers, or no names.
    """
    if data is not None and not isinstance(data, Mapping):
        raise error(
            "E0770",
            f"data is given by name, found {_kind(data)}",
            label,
            'write `data={"name": array}`',
        )
    return {name: column(name, value, label) for name, value in (data or {}).items()}


def column(name: Any, value: Any, label: str) -> Array:
    """One column of data, as an array of floats, whole numbers or bools of the caller's type."""
    problem = label_problem(name)
    if problem:
        raise error("E0770", f"{name!r:.60} cannot name a data column: {problem}", label)
    array = np.array(value) if not isinstance(value, np.ndarray) else value.copy()
    if array.dtype.kind not in "fiub":
        raise error(
            "E0770",
            f"expected numbers, found {array.dtype} of shape {array.shape}",
            f"{label}: {name}",
            "give anything else to the function itself: `functools.partial(function, camera=...)`",
        )
    if array.dtype.kind == "f":
        array = array.astype(np.float64)
    return np.ascontiguousarray(array)


def count(arguments_: tuple[Argument, ...], data: Mapping[str, Array], label: str) -> int:
    """Number of instances: that of rows and data columns.

    Raises
    ------
    AraelError
        E0770: they differ.
    """
    sizes = [(a.name, len(a.refs)) for a in arguments_ if a.refs is not None and len(a.refs) != 1]
    sizes += [(name, len(x)) for name, x in data.items() if x.ndim and len(x) != 1]
    if len({n for _, n in sizes}) > 1:
        sizes_text = ", ".join(f"`{name}` has {n}" for name, n in sizes)
        raise error(
            "E0770",
            f"parameters and data differ in their number of rows: {sizes_text}",
            label,
            "the first axis of a data column counts instances; give constants to the function "
            "itself: `functools.partial(function, K=K)`",
        )
    return sizes[0][1] if sizes else 1


@dataclass(frozen=True)
class PlacedArgument:
    """An argument in the entities of a problem: its scalars in those of use `use`.

    Attributes
    ----------
    argument : the parameter and its rows
    use : number of the use of its group by which the entity is read
    entity : the entity that has the parameter
    stored_start, stored : first of its stored numbers in the entity, and how many
    tangent_start, tangent : the same of its tangent scalars
    kind : of the parameter, as `Param.kind`
    tangent_names : name of each tangent scalar
    """

    argument: Argument
    use: int
    entity: Entity
    stored_start: int
    stored: int
    tangent_start: int
    tangent: int
    kind: str
    tangent_names: tuple[str, ...]
