"""JSON reader, column by column: objects are structs, arrays collections (LANGUAGE section 10)."""

from __future__ import annotations

import gc
from collections.abc import Callable
from itertools import chain
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io import json_text
from arael.io.json_values import explain, fast_array
from arael.io.refs import PendingRefs
from arael.io.report import Report
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import (
    COMPONENTS_FIXED,
    ENDS,
    empty,
    first_empty,
    has_components,
    split_fixed,
)
from arael.runtime.store.messages import describe, unknown_field
from arael.runtime.store.schema import Group, Leaf, Nested
from arael.runtime.store.slots import Ints
from arael.runtime.store.values import convert

PRIORS = "$priors"
"""Key of what `arael.windows.saved` writes; no field can have that name."""

Place = Callable[[int], str]
Object = dict[str, Any]


def read(store: Store, content: bytes, name: str) -> None:
    """Replace the data of `store` by that of a JSON text.

    Raises
    ------
    AraelError
        With the first 20 errors, by key path; the store is then unchanged. E0711 not
        JSON, E0701 unknown key, E0702 missing, E0703 wrong type, E0704 wrong length, E0705 not
        finite, E0706 does not fit, E0707 null, E0708 ref out of range, E0718 a key twice, E0721
        not a rotation, E0783 priors that do not fit.
    """
    report = Report(name)
    scene = _decode(content, name)
    fresh = store.fresh()
    reader = _Reader(fresh, report)
    priors = scene.pop(PRIORS, None) if isinstance(scene, dict) else None
    report.run(lambda: reader.read(scene))
    if priors is None:
        report.run(lambda: json_text.refuse_duplicates(content, name, reader.keys, report))
        store.adopt(fresh)
        return
    reader.keys += _keys_in(priors) + 1
    report.run(lambda: json_text.refuse_duplicates(content, name, reader.keys, report))
    model = store.model()
    if model is None:
        store.adopt(fresh)
        return
    found = model._checked_priors(fresh, priors, name)
    store.adopt(fresh)
    model._restore_priors(found)


def _decode(content: bytes, name: str) -> Any:
    collecting = gc.isenabled()
    gc.disable()  # millions of small lists would trigger useless garbage collections
    try:
        return msgspec.json.decode(content)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as failure:
        raise json_text.syntax_error(content, name, failure) from None
    finally:
        if collecting:
            gc.enable()


def _keys_in(given: Any) -> int:
    """Number of keys of all objects."""
    if isinstance(given, dict):
        return len(given) + sum(map(_keys_in, given.values()))
    return sum(map(_keys_in, given)) if isinstance(given, list) else 0


class _Reader:
    """Fills an empty store table by table, owners before nested rows; refs at the end."""

    def __init__(self, store: Store, report: Report) -> None:
        self.store = store
        self.report = report
        self.refs = PendingRefs(store, report)
        self.keys = 0  # object keys seen, to detect duplicates

    def read(self, scene: Any) -> None:
        root = self.store.root
        if not isinstance(scene, dict):
            self.report.add("E0703", f"expected an object, found {describe(scene)}", "")
            return
        rows = _Rows(root, [scene], None, lambda i: "")
        self._group(rows, root.fields, rows.objects, np.arange(1), rows.place)
        if not self.report.found:
            for path, array in rows.columns.items():
                root.writable(path)[:] = array
            root.missing.clear()
        self._nested(rows)
        if not self.report.found:
            self.refs.resolve()

    def _table(self, table: Table, objects: list[Any], owners: Ints, place: Place) -> None:
        """Read the rows of one collection (of all owners) and then the rows nested in them."""
        rows = _Rows(table, objects, owners, place)
        if not self._all_objects(table.fields, objects, place):
            return
        self._group(rows, table.fields, objects, np.arange(len(objects)), place)
        if not self.report.found:
            rows.add()
        self._nested(rows)

    def _nested(self, rows: _Rows) -> None:
        for nested, objects, index, place in rows.nested:
            child = self.store.tables[nested.table.path]
            self._collection(child, nested, objects, index, place)
        self.refs.take(rows.table, rows.refs, rows.place)

    def _all_objects(self, group: Group, objects: list[Any], place: Place) -> bool:
        if set(map(type, objects)) <= {dict}:
            return True
        for i, item in enumerate(objects):
            if not isinstance(item, dict):
                self.report.add(
                    "E0703",
                    f"expected an object (`{group.struct}`), found {describe(item)}",
                    place(i),
                )
        return False

    # --- one struct ----------------------------------------------------------------------------

    def _group(
        self, rows: _Rows, group: Group, objects: list[Object], index: Ints, place: Place
    ) -> None:
        """Read the members of a struct that is present at the rows `index`."""
        self.keys += sum(map(len, objects))
        self._refuse_unknown(group, objects, place)
        for name, member in group.members.items():
            if isinstance(member, Leaf):
                if member.column.role != "constraint_index":
                    self._leaf(rows, name, member, objects, index, place)
            elif isinstance(member, Group):
                self._value(rows, name, member, objects, index, place)
            else:
                rows.nested.append((member, [o.get(name, ()) for o in objects], index, place))

    def _refuse_unknown(self, group: Group, objects: list[Object], place: Place) -> None:
        known = {
            n: None
            for n, m in group.members.items()
            if not (isinstance(m, Leaf) and m.column.role == "constraint_index")
        }
        extra = set().union(*objects) - known.keys()
        if not extra:
            return
        for i, item in enumerate(objects):
            for key in item.keys() & extra:
                self.report.take(
                    unknown_field(
                        key, known, group.struct, group.where, self.report.at(_join(place(i), key))
                    )
                )

    def _value(
        self, rows: _Rows, name: str, group: Group, objects: list[Object], index: Ints, place: Place
    ) -> None:
        """Read a struct held by value."""
        missing = [i for i, o in enumerate(objects) if name not in o]
        if missing and not group.optional and any(_needed(m) for m in group.leaves()):
            for i in missing:
                self.report.add(
                    "E0702",
                    f"`{name}` is missing",
                    place(i),
                    help=f"`{name}` is declared at {group.where}"
                    if group.refs
                    else f"`{name}: {group.struct}` is declared at {group.where}",
                )
            return
        if group.refs:
            self._ref_list(rows, name, group, [o[name] for o in objects], index, place)
            return
        inner: list[Any] = [o.get(name, None if group.optional else {}) for o in objects]
        there = np.fromiter((v is not None for v in inner), np.bool_, len(inner))
        if group.optional:
            rows.mask(f"{group.path}?")[index] = there
        elif not there.all():
            for i in np.flatnonzero(~there).tolist():
                self.report.add(
                    "E0707",
                    f"null where a `{group.struct}` is needed",
                    _join(place(i), name),
                    help=f"declare `{name}: {group.struct}?` at {group.where} if it may be absent",
                )
            return
        chosen = np.flatnonzero(there)
        picked = inner if there.all() else [inner[i] for i in chosen.tolist()]

        def inner_place(i: int) -> str:
            return _join(place(int(chosen[i])), name)

        if self._all_objects(group, picked, inner_place):
            self._group(rows, group, picked, index[chosen], inner_place)

    def _ref_list(
        self, rows: _Rows, name: str, group: Group, lists: list[Any], index: Ints, place: Place
    ) -> None:
        """Read a list of refs of fixed length."""
        wrong = False
        for i, value in enumerate(lists):
            if isinstance(value, list) and len(value) == group.refs:
                continue
            wrong = True
            what = f"an array of {group.refs} refs to `{group.struct}`"
            here = "one of length " + str(len(value)) if isinstance(value, list) else ""
            self.report.add(
                "E0704" if here else "E0707" if value is None else "E0703",
                f"expected {what}, found {here or describe(value)}",
                _join(place(i), name),
                help=f"`{name}` is declared at {group.where}",
            )
        if wrong:
            return
        for k, leaf in enumerate(group.leaves()):
            values = [one[k] for one in lists]
            rows.refs.append((leaf.column, values, index, _element(place, name, k)))

    # --- one field -----------------------------------------------------------------------------

    def _leaf(
        self, rows: _Rows, name: str, leaf: Leaf, objects: list[Object], index: Ints, place: Place
    ) -> None:
        column = leaf.column
        try:
            values: list[Any] = [o[name] for o in objects]
        except KeyError:
            given = [i for i, o in enumerate(objects) if name in o]
            if not leaf.optional and column.default is None:
                for i in sorted(set(range(len(objects))) - set(given)):
                    self.report.add("E0702", f"`{name}` is missing", place(i), column)
                return
            values = [objects[i][name] for i in given]
            index, place = index[given], _through(place, given)

        at = _below(place, name)
        if leaf.optional and None in values:
            given = [i for i, v in enumerate(values) if v is not None]
            values = [values[i] for i in given]
            index, at = index[given], _through(at, given)
        if leaf.optional:
            rows.mask(f"{leaf.path}?")[index] = True
        if not values:
            return
        if column.role == "ref":
            rows.refs.append((column, values, index, at))
            return
        if column.role == "param":
            values = self._unwrap(rows, leaf, values, index, at)
        array = self._convert(rows.table, leaf, values, at)
        if array is not None:
            rows.column(leaf.path)[index] = array

    def _unwrap(
        self, rows: _Rows, leaf: Leaf, values: list[Any], index: Ints, place: Place
    ) -> list[Any]:
        """Values of parameters, some given as ``{"value": ..., "fixed": ..., "low": ...}``."""
        if dict not in set(map(type, values)):
            return values
        plain = []
        for i, value in enumerate(values):
            if not isinstance(value, dict):
                plain.append(value)
                continue
            self.keys += len(value)
            for key in value.keys() - {"value", "fixed", *ENDS}:
                self.report.add(
                    "E0701",
                    f"a parameter has no `{key}`, only `value`, `fixed`, `low` and `high`",
                    place(i),
                    leaf.column,
                )
            self._fixed(rows, leaf, value.get("fixed", False), int(index[i]), place(i))
            if any(end in value for end in ENDS):
                self._bounds(rows, leaf, value, int(index[i]), place(i))
            if "value" not in value:
                self.report.add("E0702", "`value` is missing", place(i), leaf.column)
            plain.append(value.get("value"))
        return plain

    def _fixed(self, rows: _Rows, leaf: Leaf, fixed: Any, row: int, place: str) -> None:
        """A flag of a parameter, or a list of them for its components."""
        param = leaf.column.param
        of_each = has_components(leaf.column) and param is not None
        if of_each and isinstance(fixed, list) and all(isinstance(f, bool) for f in fixed):
            assert param is not None
            if len(fixed) != param.tangent:
                self.report.add(
                    "E0704",
                    f"expected {param.tangent} of true or false, found {len(fixed)}",
                    f"{place}.fixed",
                    leaf.column,
                )
                return
            whole, some = split_fixed(np.array(fixed, np.bool_))
            rows.mask(f"{leaf.path}.fixed")[row] = whole
            rows.own(leaf.column, COMPONENTS_FIXED)[row] = some
            return
        if not isinstance(fixed, bool):
            self.report.add(
                "E0703",
                f"expected true or false, found {describe(fixed)}",
                f"{place}.fixed",
                leaf.column,
            )
            return
        rows.mask(f"{leaf.path}.fixed")[row] = fixed

    def _bounds(self, rows: _Rows, leaf: Leaf, value: Object, row: int, place: str) -> None:
        """Bounds of a parameter in one row; null is none."""
        before = len(self.report.found)
        for end in ENDS:
            if end not in value:
                continue
            where = self.report.at(f"{place}.{end}")
            try:
                found = rows.table.checked_bounds(leaf.path, end, value[end], None, where)
            except AraelError as failure:
                for diagnostic in failure.diagnostics:
                    self.report.take(diagnostic)
                continue
            rows.own(leaf.column, end)[row] = found
        if len(self.report.found) == before:
            low, high = (rows.own(leaf.column, end)[row : row + 1] for end in ENDS)
            if first_empty(low, high) is not None:
                self.report.take(empty(self.report.at(place), leaf.column, low[0], high[0]))

    def _convert(
        self, table: Table, leaf: Leaf, values: list[Any], place: Place
    ) -> NDArray[Any] | None:
        """Convert the column at once if it is valid; else value by value, to report the errors."""
        column = leaf.column
        array = fast_array(column, values)
        if array is not None:
            try:
                return convert(column, array, len(values), table.real, place, True)
            except AraelError:
                pass
        result = []
        for i, value in enumerate(values):
            before = len(self.report.found)
            value = explain(column, value, place(i), self.report)
            if len(self.report.found) > before:
                continue
            try:
                where = _constant(self.report.at(place(i)))
                result.append(convert(column, value, 1, table.real, where, False))
            except AraelError as failure:
                for diagnostic in failure.diagnostics:
                    self.report.take(diagnostic)
        return np.array(result) if len(result) == len(values) else None

    def _collection(
        self, table: Table, nested: Nested, held: list[Any], index: Ints, place: Place
    ) -> None:
        """Read the arrays in the rows `index` of the parent as the rows of one table."""
        name = nested.path.rpartition(".")[2]
        if not set(map(type, held)) <= {list, tuple}:
            for i, value in enumerate(held):
                if not isinstance(value, (list, tuple)):
                    kind = f"{table.layout.collection} of {table.layout.struct}"
                    self.report.add(
                        "E0707" if value is None else "E0703",
                        f"expected an array (`{kind}`), found {describe(value)}",
                        _join(place(i), name),
                        help=f"`{name}: {kind}` is declared at {table.layout.where}",
                    )
            return
        counts = np.fromiter(map(len, held), np.int64, len(held))
        first = np.concatenate(([0], np.cumsum(counts)))
        owners = np.repeat(index, counts)

        def row_place(i: int) -> str:
            owner = int(np.searchsorted(first, i, side="right")) - 1
            return f"{_join(place(owner), name)}[{i - int(first[owner])}]"

        self._table(table, list(chain.from_iterable(held)), owners, row_place)


class _Rows:
    """Columns of one table while they are being read."""

    def __init__(
        self, table: Table, objects: list[Object], owners: Ints | None, place: Place
    ) -> None:
        self.table = table
        self.objects = objects
        self.owners = owners
        self.place = place
        self.columns: dict[str, NDArray[Any]] = {}
        self.nested: list[tuple[Nested, list[Any], Ints, Place]] = []
        self.refs: list[tuple[Any, list[Any], Ints, Place]] = []

    def column(self, path: str) -> NDArray[Any]:
        """Array of the column, with defaults for missing values."""
        if path not in self.columns:
            self.columns[path] = self.table.blank_column(path, len(self.objects))
        return self.columns[path]

    def mask(self, path: str) -> NDArray[np.bool_]:
        """Presence or `fixed`, false if not given."""
        if path not in self.columns:
            self.columns[path] = np.zeros(len(self.objects), np.bool_)
        return self.columns[path]

    def own(self, column: Column, what: str) -> NDArray[Any]:
        """Bounds or flags of components, as of the model if not given."""
        path = f"{column.path}.{what}"
        if path not in self.columns:
            self.columns[path] = self.table.blank_own(column, what, len(self.objects))
        return self.columns[path]

    def add(self) -> None:
        """Add the rows to the table."""
        self.table.extend_trusted(len(self.objects), self.owners, self.columns)


def _needed(leaf: Leaf) -> bool:
    return (
        leaf.column.default is None and not leaf.optional and leaf.column.role != "constraint_index"
    )


def _join(place: str, name: str) -> str:
    return f"{place}.{name}" if place else name


def _below(place: Place, name: str) -> Place:
    return lambda i: _join(place(i), name)


def _element(place: Place, name: str, k: int) -> Place:
    return lambda i: f"{_join(place(i), name)}[{k}]"


def _constant(where: str) -> Place:
    return lambda _: where


def _through(place: Place, given: list[int]) -> Place:
    return lambda i: place(given[i])
