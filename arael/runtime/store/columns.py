"""The values of a table: an array per field; presence, `fixed` and `optimize` flags."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime import layout
from arael.runtime.store import bounds
from arael.runtime.store.buffers import Buffers
from arael.runtime.store.compiled import fingerprint_of_flags, fingerprints, rows_where
from arael.runtime.store.messages import Origin, error, unknown_field
from arael.runtime.store.schema import Group, Leaf, fields_of
from arael.runtime.store.values import blank, convert, default_value, dtype_of

Array = NDArray[Any]
Bools = NDArray[np.bool_]
Rows = slice | NDArray[np.int64] | int


COMPONENTS = ".optimize_components"


def flags_of(column: layout.Column) -> tuple[str, ...]:
    """Paths of the flags of a parameter set from Python: ``pose.optimize_scale``."""
    if column.param is None:
        return ()
    names = ("optimize", *(f"optimize_{part.name}" for part in column.param.parts))
    return tuple(f"{column.path}.{name}" for name in names)


class Columns:
    """Columns of one table by path.

    Paths are those of the layout; ``path?`` is the presence of an optional, ``path.fixed`` the flag
    that fixes a parameter in every solve. ``path.fixed_components``, ``path.low`` and ``path.high``
    exist once they were set.

    Attributes
    ----------
    fields : the tree of fields
    data, optionals : columns with values, and presence masks, by path
    absentable : paths of what is optional or within something optional
    missing : fields of the root without default that are not set yet (other tables: empty)
    optimize_new : the `optimize` flags of rows added later, by their paths
    components_new : the same of components, by the path of the parameter, where any was set
    """

    def __init__(self, model: layout.Layout, table: layout.Table) -> None:
        self.layout = table
        self.fields: Group = fields_of(model, table)
        self.real = np.dtype(np.float32 if model.precision == "f32" else np.float64)
        self.buffers = Buffers()
        self.data: dict[str, layout.Column] = {}
        self.optionals: dict[str, layout.Column] = {}
        for column in table.columns:
            if column.role == "present":
                self.optionals[column.path] = column
                self.buffers.add(f"{column.path}?", np.bool_)
                continue
            self.data[column.path] = column
            self.buffers.add(column.path, dtype_of(column, self.real), column.shape)
            if column.role == "param":
                self.buffers.add(f"{column.path}.fixed", np.bool_)
                for flag in flags_of(column):
                    self.buffers.add(flag, np.bool_)
        self.missing: set[str] = set()
        # New rows get the flag that was last set for the whole collection.
        self.optimize_new = {flag: True for c in self.data.values() for flag in flags_of(c)}
        self.components_new: dict[str, tuple[bool, ...]] = {}
        params = [c.path for c in self.data.values() if c.role == "param"]
        self._flags = [
            *(f"{path}.fixed" for path in params),
            *self.optimize_new,
            *(f"{path}?" for path in self.optionals if params),
        ]
        self._added_flags = [
            *(f"{path}{COMPONENTS}" for path in params),
            *(
                f"{p}.{bounds.COMPONENTS_FIXED}"
                for p in params
                if bounds.has_components(self.data[p])
            ),
        ]
        self._updated = {
            path for e in model.entities if e.table == table.path for path in e.updated
        }
        self._added_bounds = [
            f"{path}.{end}"
            for path in params
            if bounds.may_be_bounded(self.data[path])
            for end in bounds.ENDS
        ]
        self._declared = len(self.buffers)  # further columns are added as they are needed
        self._known = -1  # columns when these were listed
        self._own_bounds: tuple[str, ...] = ()
        self._own_flags: tuple[str, ...] = ()
        self._ancestors = {
            path: [o for o in self.optionals if path == o or path.startswith(f"{o}.")]
            for path in (*self.data, *self.optionals, *(v.path for v in table.values))
        }
        self.absentable = frozenset(path for path, around in self._ancestors.items() if around)

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.buffers.size

    def column(self, path: str) -> Array:
        """Live view (size, *shape) of a column, valid until rows are added or removed.

        For an optional struct: its presence (size,). ``path?`` is the presence of any optional.
        Refs are handles; see `target_rows` for rows.
        """
        if path in self.data or path[-1:] == "?":
            return self.buffers.view(path)
        if path in self.optionals:
            return self.buffers.view(f"{path}?")
        raise AraelError(
            unknown_field(path, self.data, self.layout.struct, self.layout.where, self.layout.path)
        )

    def columns(self, paths: tuple[str, ...]) -> list[Array]:
        """Live views of several columns with values; see `column`."""
        return self.buffers.views(paths)

    def present(self, path: str) -> Bools:
        """Whether `path` and its enclosing optionals are present in each row (size,)."""
        return rows_where(self.size, self._optionals_of(path), [])

    def _optionals_of(self, path: str) -> list[Bools]:
        """Presence (size,) of each optional that encloses `path`, or is there itself."""
        return [self.buffers.view(f"{one}?") for one in self._ancestors.get(path, ())]

    def fixed(self, path: str) -> Bools:
        """Live view (size,): parameters fixed by the data."""
        return self.buffers.view(f"{path}.fixed")

    def column_of_flags(self, path: str, name: str) -> Bools:
        """Live view (size,) of a parameter's flag: ``fixed``, ``optimize``, ``optimize_scale``."""
        return self.buffers.view(f"{path}.{name}")

    def component_flags(self, path: str) -> Bools | None:
        """Live flags (size, tangent): components that are optimised; None if they never were set.

        Few models hold components, so that the column is added when it is first needed.
        """
        return self.buffers.view(name) if (name := f"{path}{COMPONENTS}") in self.buffers else None

    def add_component_flags(self, path: str) -> Bools:
        """Live flags of components, all true where there were none."""
        name = f"{path}{COMPONENTS}"
        if name not in self.buffers:
            param = self.data[path].param
            assert param is not None
            self.buffers.add(name, np.bool_, (param.tangent,))
            self.buffers.view(name)[...] = True
            self.components_new.setdefault(path, (True,) * param.tangent)
        return self.buffers.view(name)

    # --- columns added when they are first needed ----------------------------------------------

    def fixed_components(self, path: str) -> Bools | None:
        """Live flags (size, tangent): components fixed by the data; None if none was."""
        name = f"{path}.{bounds.COMPONENTS_FIXED}"
        return self.buffers.view(name) if name in self.buffers else None

    def bound(self, path: str, end: str) -> Array | None:
        """Live bounds (size, *shape) f64, ``low`` or ``high``; None: those of the model."""
        if len(self.buffers) == self._declared:
            return None
        return self.buffers.view(name) if (name := f"{path}.{end}") in self.buffers else None

    def writable(self, name: str) -> Array:
        """Live view of any column by its full path; flags and bounds are added as needed."""
        if name not in self.buffers:
            path, _, what = name.rpartition(".")
            value = self._value_of_new(self.data[path], what)
            self.buffers.add(name, value.dtype, value.shape)
            self.buffers.view(name)[...] = value
        return self.buffers.view(name)

    def _value_of_new(self, column: layout.Column, what: str) -> Array:
        """Bounds of the model, or that no component is fixed."""
        if what in bounds.ENDS:
            return bounds.of_model(column, what)
        assert column.param is not None
        return np.zeros(column.param.tangent, np.bool_)

    def blank_own(self, column: layout.Column, what: str, count: int) -> Array:
        """An array of the bounds of the model, or of flags of components that are not fixed."""
        value = self._value_of_new(column, what)
        return np.array(np.broadcast_to(value, (count, *value.shape)))

    def own_of_new(self, column: layout.Column) -> dict[str, Array]:
        """Bounds and flags of components of new rows, by path, where such columns exist."""
        names = (bounds.COMPONENTS_FIXED, *bounds.ENDS)
        there = [name for name in names if f"{column.path}.{name}" in self.buffers]
        return {f"{column.path}.{name}": self._value_of_new(column, name) for name in there}

    @property
    def bounds_version(self) -> Any:
        """Differs from what it was whenever bounds of rows do; () while all are of the model."""
        self._list_own()
        return tuple(fingerprints(self.buffers.views(self._own_bounds))) if self._own_bounds else ()

    def flags_of_new(self, column: layout.Column) -> dict[str, Array]:
        """Flags and bounds of new rows of a parameter, by path; each is one value for all."""
        found = {flag: np.asarray(self.optimize_new[flag]) for flag in flags_of(column)}
        if f"{column.path}{COMPONENTS}" in self.buffers:
            found[f"{column.path}{COMPONENTS}"] = np.asarray(self.components_new[column.path])
        return {**found, **self.own_of_new(column)}

    def take_flags_of_new(self, other: Columns) -> None:
        """Let new rows have the flags that those of `other` have."""
        self.optimize_new = dict(other.optimize_new)
        for path, flags in other.components_new.items():
            self.add_component_flags(path)
            self.components_new[path] = flags

    def optimize(self, path: str) -> Bools:
        """Live view (size,): the `optimize` flags set from Python."""
        return self.buffers.view(f"{path}.optimize")

    def free(self, path: str) -> Bools:
        """Free parameters (size,): present, not fixed, and to be optimised."""
        required = [*self._optionals_of(path), self.optimize(path)]
        return rows_where(self.size, required, [self.fixed(path)])

    def free_as_a_whole(self, path: str) -> Bools:
        """Free parameters (size,) of which no component is held by data or flags."""
        found = self.free(path)
        fixed, held = self.fixed_components(path), self.component_flags(path)
        if fixed is not None:
            found &= ~fixed.any(axis=1)
        if held is not None:
            found &= held.all(axis=1)
        return found

    @property
    def flags_version(self) -> Any:
        """Differs from what it was whenever `free` of a parameter or of a part of it does."""
        self._list_own()
        return fingerprint_of_flags(self.buffers.views(self._own_flags))

    def _list_own(self) -> None:
        """List the columns of bounds and of flags that there are; a solve asks several times."""
        there = self.buffers
        if self._known == len(there):
            return
        self._own_flags = (*self._flags, *(name for name in self._added_flags if name in there))
        self._own_bounds = tuple(name for name in self._added_bounds if name in there)
        self._known = len(there)

    def leaf(self, path: str, origin: Origin) -> Leaf:
        """Return the field at `path`; E0701 if there is none."""
        member = self.fields.find(path)
        if isinstance(member, Leaf):
            return member
        raise AraelError(
            unknown_field(path, self.data, self.layout.struct, self.layout.where, origin)
        )

    # --- values of new rows ------------------------------------------------------------------

    def prepare(
        self, given: Mapping[str, Any], count: int, many: bool, origin: Origin, below: str = ""
    ) -> dict[str, Array]:
        """Arrays for every data column of `count` new rows, without refs.

        `given` maps paths to values: arrays with a leading axis of `count`, or one value for all.
        Missing columns get their default; without one, unless in an absent optional, E0702 is
        raised. Only fields under the path `below` are considered (all for "").
        """

        def name_of(path: str) -> Any:
            return lambda i: f"{origin}.{path}" if not many else f"{origin}.{path} (row {i})"

        self._refuse_unknown(given, origin)
        presence = self._presence(given, count, many, origin, below)
        ready: dict[str, Array] = {f"{p}?": mask for p, mask in presence.items()}
        missing = []
        for path, column in self.data.items():
            if not path.startswith(below):
                continue
            mask = None
            for optional in self._ancestors[path]:
                if optional not in presence:
                    continue
                mask = presence[optional] if mask is None else mask & presence[optional]
            if column.role == "param":
                ready.update(self.own_of_new(column) if below else self.flags_of_new(column))
                ready.update(self._given_flags(column, given, count, many, origin))
                ready.update(self._given_bounds(column, given, count, many, origin))
            if column.role == "ref":
                if given.get(path) is None and (mask is None or mask.any()):
                    missing.append(column)
                continue
            if path in given and given[path] is not None:
                values = given[path]
                if mask is not None and not mask.all():
                    values = self._mask_out(column, values, mask, count, many)
                ready[path] = convert(column, values, count, self.real, name_of(path), many)
            elif column.default is not None:
                ready[path] = np.asarray(default_value(column), dtype_of(column, self.real))
            elif column.role == "constraint_index" or (mask is not None and not mask.any()):
                ready[path] = np.asarray(blank(column), dtype_of(column, self.real))
            elif path in given:
                raise error("E0707", "null where a value is needed", f"{origin}.{path}", column)
            else:
                missing.append(column)
        if missing:
            raise AraelError(
                [
                    error("E0702", f"`{c.path}` is missing", origin, c).diagnostics[0]
                    for c in missing
                ]
            )
        return ready

    def _given_flags(
        self,
        column: layout.Column,
        given: Mapping[str, Any],
        count: int,
        many: bool,
        origin: Origin,
    ) -> dict[str, Array]:
        """Checked `fixed` flags of new rows: (count,) or one for all, and of components."""
        name = f"{column.path}.fixed"
        flags = np.asarray(given.get(name, False))
        shapes: list[tuple[int, ...]] = [(), (count,)]
        parts = bounds.has_components(column)
        if parts:
            assert column.param is not None
            k = column.param.tangent
            if not many:
                shapes = [(), (k,)]
            elif flags.ndim == 2:
                shapes = [(count, k), (1, k)]
        if flags.dtype != np.bool_ or flags.shape not in shapes:
            of_each = f"; or {k} for its components" if parts else ""
            raise error(
                "E0703",
                f"expected true or false for each of {count} rows{of_each}",
                f"{origin}.{name}",
                column,
            )
        if flags.ndim < (2 if many else 1):
            return {name: flags}
        whole, some = bounds.split_fixed(flags)
        return {name: whole, f"{column.path}.{bounds.COMPONENTS_FIXED}": some}

    def _given_bounds(
        self,
        column: layout.Column,
        given: Mapping[str, Any],
        count: int,
        many: bool,
        origin: Origin,
    ) -> dict[str, Array]:
        """Checked bounds of new rows."""
        found = {}
        for end in bounds.ENDS:
            name = f"{column.path}.{end}"
            if name in given:
                found[name] = self.checked_bounds(
                    column.path, end, given[name], count if many else None, f"{origin}.{name}"
                )
        return found

    def checked_bounds(
        self, path: str, end: str, given: Any, count: int | None, origin: Origin
    ) -> NDArray[np.float64]:
        """Bounds as numbers; see `arael.runtime.store.bounds.converted`.

        Raises AraelError: E0703 also for a parameter that an update sets, which keeps it within the
        model's bounds.
        """
        column = self.data[path]
        if path in self._updated:
            raise error(
                "E0703",
                "an update sets this parameter: its bounds are those of the model",
                origin,
                column,
                "write them in the model: `param x: real in 0 .. 10`",
            )
        return bounds.converted(column, end, given, count, origin)

    def set_bounds(self, path: str, end: str, rows: Rows, given: Any, origin: Origin) -> None:
        """Write checked bounds of some rows; see `checked_bounds`."""
        count = None if isinstance(rows, int) else len(np.arange(self.size)[rows])
        checked = self.checked_bounds(path, end, given, count, origin)
        self.writable(f"{path}.{end}")[rows] = checked

    def reset_bounds(self, path: str, end: str, rows: Rows) -> None:
        """Let some rows have the model's bounds."""
        own = self.bound(path, end)
        if own is not None:
            own[rows] = bounds.of_model(self.data[path], end)

    def _is_of_parameter(self, path: str) -> bool:
        """Whether `path` is of a parameter: its `fixed` flag or its bounds."""
        bare, _, what = path.rpartition(".")
        column = self.data.get(bare)
        return what in ("fixed", *bounds.ENDS) and column is not None and column.role == "param"

    def _refuse_unknown(self, given: Mapping[str, Any], origin: Origin) -> None:
        for path in given:
            if path in self.data or path in self.optionals:
                continue
            if (path.endswith("?") and path in self.buffers) or self._is_of_parameter(path):
                continue
            known = [*self.data, *self.optionals]
            raise AraelError(
                unknown_field(path, known, self.layout.struct, self.layout.where, origin)
            )

    def _presence(
        self, given: Mapping[str, Any], count: int, many: bool, origin: Origin, below: str
    ) -> dict[str, Bools]:
        """Presence of optionals in the new rows: as given, else whether they have values."""
        presence: dict[str, Bools] = {}
        for path in self.optionals:
            if not f"{path}.".startswith(below):
                continue
            said = given.get(f"{path}?")
            if said is None and path not in self.data:
                said = given.get(path)
            if said is None:
                said = any(
                    f"{p}.".startswith(f"{path}.") and v is not None for p, v in given.items()
                )
            mask = np.asarray(said)
            if mask.dtype != np.bool_ or mask.shape not in ((), (count,)):
                raise error(
                    "E0703", "expected presence as true or false for each row", f"{origin}.{path}"
                )
            mask = np.broadcast_to(mask, (count,))
            for outer in self._ancestors[path]:
                if outer != path and outer in presence:
                    mask = mask & presence[outer]
            presence[path] = mask
        return presence

    def _mask_out(
        self, column: layout.Column, values: Any, mask: Bools, count: int, many: bool
    ) -> Any:
        """Values with neutral content where the field is absent, ignoring values given there."""
        if not many:
            return values if mask.all() else blank(column)
        array = np.asarray(values)
        if array.shape[:1] != (count,) or array.shape == column.shape:
            return values
        array = array.copy()
        if array.shape[1:] == column.shape:
            array[~mask] = blank(column)
        else:  # a rotation or transform in another form
            array[~mask] = np.eye(*array.shape[1:]) if array.ndim == 3 else 0
        return array

    def fill(self, rows: slice, ready: Mapping[str, Array]) -> None:
        """Copy prepared arrays into new rows; refs become null."""
        for path, array in ready.items():
            self.writable(path)[rows] = array
        for path, column in self.data.items():
            if column.role == "ref":
                self.buffers.view(path)[rows] = -1

    # --- changes -----------------------------------------------------------------------------

    def set_values(self, path: str, rows: Rows, values: Any, origin: Origin) -> None:
        """Write checked values of a field that is not a ref; None makes an optional absent."""
        leaf = self.leaf(path, origin)
        column, target = leaf.column, self.buffers.view(path)
        if values is None:
            if not leaf.optional:
                raise error("E0707", "null where a value is needed", origin, column)
            self.buffers.view(f"{path}?")[rows] = False
            target[rows] = blank(column)
            return
        single = isinstance(rows, int)
        count = 1 if single else len(np.arange(self.size)[rows])
        ready = convert(
            column,
            values,
            count,
            self.real,
            lambda i: str(origin) if single else f"{origin} (row {i})",
            not single,
        )
        target[rows] = ready
        self.missing.discard(path)
        if leaf.optional:
            self.buffers.view(f"{path}?")[rows] = True
