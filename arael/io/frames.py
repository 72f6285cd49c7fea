"""Data frames: columns of a collection to pandas and xarray, and back.

Columns are named as in CSV files: one for each scalar, ``pos.x``, ``att.w``, ``m[0][1]``; refs are
indices; ``pos.fixed`` where a row is fixed, ``pos.x.low`` where it has bounds of its own. Missing
values are absent optionals, and bounds of the model.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.columns import of_component, scalar_names
from arael.io.json_writer import fixed_flags, own_bounds
from arael.runtime.layout import Column
from arael.runtime.store import Table
from arael.runtime.store.bounds import ENDS, empty, first_empty, has_components
from arael.runtime.store.messages import error, unknown_field
from arael.runtime.store.schema import Group, Leaf

if TYPE_CHECKING:
    import pandas
    import xarray

Array = NDArray[Any]
PARENT = "parent"


# --- out -----------------------------------------------------------------------------------------


def to_pandas(collection: Any) -> pandas.DataFrame:
    """The rows of a collection as a DataFrame; see `Collection.to_pandas`."""
    pd = required("pandas")
    table, rows = collection._table, np.atleast_1d(collection._every())
    found: dict[str, Any] = {}
    if table.layout.parent:
        found[PARENT] = table.parent_rows_of(rows)
    for leaf in _leaves(collection):
        column, path = leaf.column, leaf.path
        there = np.asarray(table.present(path)[rows])
        if column.role == "ref":
            values = table.target_rows(path)[rows]
            known = there & (values >= 0)
            found[path] = values if known.all() else pd.array(values, "Int64")
            if not known.all():
                found[path][~known] = pd.NA
            continue
        array = table.column(path)[rows]
        for name, index in scalar_names(column):
            at: Any = (slice(None), *index)
            scalars = np.array(array[at])
            found[name] = scalars if there.all() else _with_gaps(pd, scalars, there)
        if column.role == "param":
            found.update(_own(table, column, rows))
    index = pd.RangeIndex(len(rows)) if collection._is_whole() else pd.Index(rows)
    return pd.DataFrame(found, index=index.rename("row"))


def _own(table: Table, column: Column, rows: Any) -> dict[str, Array]:
    """Flags and bounds of a parameter, named as in CSV files; a bound of the model is NaN."""
    found = {}
    fixed = fixed_flags(table, column)[rows]
    if fixed.any():
        for name, index in [(column.path, ())] if fixed.ndim == 1 else scalar_names(column):
            found[f"{name}.fixed"] = np.array(of_component(fixed, index))
    for end in ENDS:
        own, differs = own_bounds(table, column, end)
        if differs.any() and differs[rows].any():
            for name, index in scalar_names(column):
                bounds = of_component(own, index)
                found[f"{name}.{end}"] = np.where(differs, bounds, np.nan)[rows]
    return found


def _with_gaps(pd: Any, scalars: Array, there: Array) -> Any:
    """A column with missing values where a field is absent."""
    if scalars.dtype.kind == "f":
        return np.where(there, scalars, np.nan)
    kind = {"i": "Int64", "b": "boolean"}.get(scalars.dtype.kind, "object")
    found = pd.array(scalars, dtype=kind)
    found[~there] = pd.NA if kind != "object" else None
    return found


def to_xarray(collection: Any) -> xarray.Dataset:
    """The rows of a collection as a Dataset; see `Collection.to_xarray`."""
    xr = required("xarray")
    table, rows = collection._table, np.atleast_1d(collection._every())
    found: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"row": rows}
    for leaf in _leaves(collection):
        column, path = leaf.column, leaf.path
        there = np.asarray(table.present(path)[rows])
        if column.role == "ref":
            values = np.where(there, table.target_rows(path)[rows], -1)
        else:
            values = np.array(table.column(path)[rows])
        if values.dtype.kind == "f" and not there.all():
            values[~there] = np.nan
        axes = [f"{path}_{axis}" for axis in ("i", "j")[: len(column.shape)]]
        if column.role != "ref" and len(axes) == 1:
            names = [name.removeprefix(path).strip(".[]") for name, _ in scalar_names(column)]
            coordinates[axes[0]] = names
        units = {"units": column.unit} if getattr(column, "unit", "") else {}
        found[path] = (("row", *(axes if column.role != "ref" else ())), values, units)
    data: xarray.Dataset = xr.Dataset(found, coordinates)
    return data


def _leaves(collection: Any) -> list[Leaf]:
    leaves = collection._table.fields.leaves()
    return [leaf for leaf in leaves if leaf.column.role != "constraint_index"]


def required(package: str) -> Any:
    """Import an optional package.

    Raises
    ------
    AraelError
        E0868: it is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise AraelError(
            Diagnostic(
                "E0868",
                f"this needs {package}, which is not installed",
                origin=f"to_{package}",
                help=("pip install 'arael[frames]'",),
            )
        ) from None


# --- in ------------------------------------------------------------------------------------------


def columns_of(frame: Any, table: Table, group: Group) -> tuple[int, dict[str, Any], Any]:
    """Number of rows, values by path as `Collection.extend` takes them, and parents if given.

    Raises
    ------
    AraelError
        E0701 a column that is no field, E0702 some scalars of a field are missing, E0718 a column
        twice, E0730 bounds of a row that leave no value.
    """
    names = [str(name) for name in frame.columns]
    for name in {n for n in names if names.count(n) > 1}:
        raise error("E0718", f"the column `{name}` is given twice", table.label)
    cells = {str(name): _cells(frame[name]) for name in frame.columns}
    count = int(frame.shape[0])
    parent = None
    if table.layout.parent and PARENT in cells and PARENT not in group.members:
        parent = _row_numbers(*cells.pop(PARENT), PARENT, table)
    found: dict[str, Any] = {}
    masks: dict[str, NDArray[np.bool_]] = {}
    for path, column in table.data.items():
        if column.role == "param":
            found.update(_taken_own(column, cells, table, count))
        parts = _taken(column, cells, table)
        if parts is None:
            continue
        missing = np.logical_or.reduce([gaps for _, gaps in parts])
        for optional in table.optionals:
            if f"{path}.".startswith(f"{optional}."):
                masks[optional] = masks.get(optional, np.zeros(count, np.bool_)) | ~missing
                break
        found[path] = _joined(table, column, [values for values, _ in parts], missing, count)
    for name in cells:
        every = [n for c in table.data.values() for n, _ in scalar_names(c)]
        raise AraelError(
            unknown_field(name, dict.fromkeys(every), group.struct, group.where, table.label)
        )
    for optional, mask in masks.items():
        found[f"{optional}?"] = mask
    return count, found, parent


def _cells(series: Any) -> tuple[Array, NDArray[np.bool_]]:
    """Values of a column, and where they are missing."""
    values = series.to_numpy() if hasattr(series, "to_numpy") else np.asarray(series)
    if values.dtype.kind == "f":
        return values, np.isnan(values)
    if values.dtype == object:
        gaps = np.array([v is None or v != v or str(v) == "<NA>" for v in values], np.bool_)
        return values, gaps
    return values, np.zeros(len(values), np.bool_)


def _taken(
    column: Column, cells: dict[str, tuple[Array, NDArray[np.bool_]]], table: Table
) -> list[tuple[Array, NDArray[np.bool_]]] | None:
    """Take the cells of all scalars of a field out of `cells`; None if there is none."""
    if column.role == "ref":
        names = [column.path]
    else:
        names = [name for name, _ in scalar_names(column)]
        numbers = [column.path + "".join(f"[{k}]" for k in i) for _, i in scalar_names(column)]
        if not any(name in cells for name in names):
            names = numbers
    if not any(name in cells for name in names):
        return None
    lacking = [name for name in names if name not in cells]
    if lacking:
        raise error("E0702", f"the column `{lacking[0]}` is missing", table.label, column)
    return [cells.pop(name) for name in names]


def _taken_own(
    column: Column, cells: dict[str, tuple[Array, NDArray[np.bool_]]], table: Table, count: int
) -> dict[str, Array]:
    """Take flags and bounds of a parameter out of `cells`."""
    found: dict[str, Array] = {}
    names = [name for name, _ in scalar_names(column)]
    whole = cells.pop(f"{column.path}.fixed", None)
    if whole is not None:
        found[f"{column.path}.fixed"] = np.asarray(whole[0])
    if has_components(column) and any(f"{name}.fixed" in cells for name in names):
        none = (np.zeros(count, np.bool_), None)
        parts = [np.asarray(cells.pop(f"{name}.fixed", none)[0]) for name in names]
        every = np.zeros(count, np.bool_) if whole is None else np.asarray(whole[0])
        if every.dtype == np.bool_:  # others are refused by the table
            parts = [part | every if part.dtype == np.bool_ else part for part in parts]
            found[f"{column.path}.fixed"] = np.stack(parts, axis=-1)
    for end in ENDS:
        if not any(f"{name}.{end}" in cells for name in names):
            continue
        bounds = table.blank_own(column, end, count)
        flat = bounds.reshape(count, -1)
        for k, name in enumerate(names):
            title = f"{name}.{end}"
            if title in cells:
                given, gaps = cells.pop(title)
                flat[~gaps, k] = _numbers(given, title, table)[~gaps]
        found[f"{column.path}.{end}"] = bounds
    low, high = (
        found.get(f"{column.path}.{end}", table.blank_own(column, end, count)) for end in ENDS
    )
    row = first_empty(low, high)
    if row is not None:
        origin = f"{table.label} row {row}: {column.path}"
        raise AraelError(empty(origin, column, low[row], high[row]))
    return found


def _joined(
    table: Table, column: Column, parts: list[Array], missing: NDArray[np.bool_], count: int
) -> Any:
    """Values (count, *shape) of a field; of rows where it is missing, what is never read."""
    if column.role == "ref":
        if not missing.any():
            return parts[0]
        if any(isinstance(v, str) for v in parts[0]):  # keys
            return [None if gap else v for v, gap in zip(parts[0], missing, strict=True)]
        return _row_numbers(parts[0], missing, column.path, table)
    optional = any(f"{column.path}.".startswith(f"{o}.") for o in table.optionals)
    known = [_numbers(part, column.path, table) if _is_nullable(part) else part for part in parts]
    if len(known) == 1 and not column.shape:
        values = known[0]
    else:
        values = np.stack(known, axis=-1).reshape(count, *column.shape)
    if optional and missing.any():
        blank = table.blank_column(column.path, count)
        values = np.where(missing.reshape(-1, *[1] * len(column.shape)), blank, values)
    if values.dtype == object and column.kind == "string":
        return values.tolist()
    return values


def _numbers(cells: Array, name: str, table: Table) -> Array:
    """Cells as floats; AraelError E0703 where one is no number."""
    try:
        return cells.astype(np.float64)
    except (TypeError, ValueError):
        raise error(
            "E0703", f"the column `{name}` must be numbers, found other values", table.label
        ) from None


def _row_numbers(cells: Array, missing: NDArray[np.bool_], name: str, table: Table) -> Array:
    """Cells as row numbers, -1 where there is none; AraelError E0703 for fractions."""
    found = _numbers(cells, name, table)
    there = ~missing & (np.abs(found) < 2**53)  # not NaN, which compares with nothing
    parts = there & (found != np.floor(found))
    if parts.any():
        raise error(
            "E0703",
            f"the column `{name}` must be row numbers, found {found[parts][0]}",
            table.label,
        )
    # Out of range, and refused by that: what is no row of any collection.
    beyond = np.where(missing, -1, np.iinfo(np.int64).max)
    return np.where(there, np.where(there, found, 0).astype(np.int64), beyond)


def _is_nullable(part: Array) -> bool:
    """Whether an object array holds numbers with gaps."""
    return part.dtype == object and not any(isinstance(v, str | bool) for v in part)
