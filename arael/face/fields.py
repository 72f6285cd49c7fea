"""Attribute access to the fields of one row or of many."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import user_frames
from arael.diagnostics.records import AraelError
from arael.face import formulas, given
from arael.face.blocks import read_block
from arael.face.formulas import read_formula
from arael.face.parameter import Parameter, taken
from arael.runtime.layout import Block
from arael.runtime.store import Table
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.columns import Rows
from arael.runtime.store.messages import UnknownFieldError, error, unknown_field
from arael.runtime.store.schema import Group, Leaf, Nested


class Fields:
    """A struct at some rows of a table: its fields are attributes, or items by dotted path."""

    _table: Table
    _group: Group

    def _rows(self) -> Rows:
        """Dense rows: a number, a slice or an array."""
        raise AssertionError

    def _is_whole(self) -> bool:
        """Whether this is every row of the table."""
        return False

    def _owner(self) -> Any:
        """Return the row if there is exactly one; else None."""
        return None

    # --- names -------------------------------------------------------------------------------

    def _member(self, path: str) -> Group | Leaf | Nested:
        member = self._group.find(path) if path else None
        if member is None:
            where = self._group.where
            raise UnknownFieldError(
                unknown_field(
                    path, self._group.members, self._group.struct, where, self._origin("")
                )
            )
        return member

    def _block(self, path: str) -> Block | None:
        """The block of the Hessian with that name."""
        full = f"{self._group.path}.{path}" if self._group.path else path
        for block in self._table.store.layout.blocks:
            if block.table == self._table.layout.path and block.prefix + block.name == full:
                return block
        return None

    def _origin(self, path: str) -> str:
        """Name of a field for messages."""
        rows = self._rows()
        if isinstance(rows, int):
            return self._table.name_of(rows, path).removesuffix(".") or self._table.label
        return f"{self._table.label}.{path}".removesuffix(".")

    def __getattr__(self, name: str) -> Any:
        group = self.__dict__.get("_group")  # `copy` reads attributes before __init__
        if group is None or name.startswith("__"):
            raise AttributeError(name)
        known = group.plain.get(name)
        if known is not None:
            return self._get(known)
        __tracebackhide__ = True
        with user_frames:
            return self._read(name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_") and name not in self._group.members:
            object.__setattr__(self, name, value)
            return
        if name not in self._group.members and hasattr(type(self), name):
            raise AttributeError(f"`{name}` cannot be set")
        if name not in self._group.members and formulas.formula_at(self, name):
            raise AttributeError(f"`{name}` is a formula: set the fields that it is computed from")
        __tracebackhide__ = True
        with user_frames:
            self._set(self._member(name), value)

    def __getitem__(self, path: str) -> Any:
        """Return the field at a dotted path; ``path?`` is the presence of an optional."""
        self._require_path(path)
        if path.endswith("?"):
            full = f"{self._group.path}.{path[:-1]}" if self._group.path else path[:-1]
            self._member(path[:-1])
            found = self._table.present(full)[self._rows()]
            return found if isinstance(found, np.ndarray) else bool(found)
        return self._read(path)

    def __setitem__(self, path: str, value: Any) -> None:
        self._require_path(path)
        self._set(self._member(path), value)

    def _require_path(self, path: object) -> None:
        if not isinstance(path, str):
            raise wrong_argument(self._origin(""), "path", "the name of a field", path)

    def __dir__(self) -> Iterator[str]:
        here = f"{self._group.path}." if self._group.path else ""
        blocks = self._table.store.layout.blocks
        named = {b.name for b in blocks if (b.table, b.prefix) == (self._table.layout.path, here)}
        yield from {*object.__dir__(self), *self._group.members, *named, *formulas.names(self)}

    # --- reading -----------------------------------------------------------------------------

    def _read(self, path: str) -> Any:
        """The item at a dotted path: a field, a block of the Hessian, a formula."""
        block = self._block(path)
        if block is not None:
            return read_block(self, block)
        found = formulas.formula_at(self, path)
        if found is not None:
            return read_formula(self, *found)
        member = self._group.plain[path] = self._member(path)
        return self._get(member)

    def _get(self, member: Group | Leaf | Nested) -> Any:
        if isinstance(member, Leaf) and member.column.role == "param":
            table, path, rows = self._table, member.path, self._rows()
            one = isinstance(rows, int)
            if one and path in table.absentable and not table.present(path)[rows]:
                return None
            return Parameter(table, path, self._rows, not one and self._is_whole())
        # imported here: the circle of fields, collections and refs
        # imported here: start-up time
        from arael.face.collection import Collection
        from arael.face.ref import Ref, Refs

        rows, table = self._rows(), self._table
        single = isinstance(rows, int)
        if isinstance(member, Nested):
            child = table.store.tables[member.table.path]
            if single:
                return Collection(child, parent=int(table.handles(rows)[0]))
            if self._is_whole():
                return Collection(child)
            held = np.isin(child.parent_rows(), np.arange(table.size)[rows])
            return Collection(child, handles=child.handles(np.flatnonzero(held)))
        if single and not table.present(member.path)[rows]:
            return None
        if isinstance(member, Group) and member.refs:
            # imported here: the circle of fields, collections and refs
            from arael.face.ref_list import RefList

            return RefList(self, member)
        if isinstance(member, Group):
            return Part(self, member)
        path, column = member.path, member.column
        if column.role == "ref" and column.target is not None:
            target = table.store.tables[column.target.table]
            handles = table.column(path)[rows]
            if single:
                return Ref(target, int(handles))
            if member.optional:  # null refs and refs to removed rows
                return Refs(target, np.where(table.present(path)[rows], handles, -1))
            return Refs(target, handles.copy())
        part = taken(table.column(path), rows)
        return part.item() if isinstance(part, np.generic) else part

    # --- writing -----------------------------------------------------------------------------

    def _set(self, member: Group | Leaf | Nested, value: Any) -> None:
        rows, table, origin = self._rows(), self._table, self._origin(member.path)
        if isinstance(member, Nested):
            raise error(
                "E0424", "a collection cannot be assigned", origin, help="use append or extend"
            )
        if isinstance(member, Group):
            self._set_group(member, value, origin)
            return
        if isinstance(value, Parameter):
            value = np.array(value.value)
        if member.column.role == "param" and isinstance(value, Mapping):
            parts = given.parts_of(member, value, origin)
            for end in ENDS:  # checked before the value is written
                if f"{member.path}.{end}" in parts:
                    count = None if isinstance(rows, int) else len(np.arange(table.size)[rows])
                    table.checked_bounds(member.path, end, value[end], count, f"{origin}.{end}")
            self._set(member, parts.pop(member.path))
            parameter = self._get(member)
            for path, part in parts.items():
                setattr(parameter, path.rpartition(".")[2], part)
            return
        if member.column.role != "ref":
            if value is not None:
                self._need_present(member, origin)
            table.set_values(member.path, rows, value, origin)
            return
        every = np.atleast_1d(np.arange(table.size)[rows])
        pointed = -1 if value is None else given.refs(value)
        table.set_refs(member.path, every, pointed, origin)

    def _need_present(self, member: Leaf | Group, origin: str) -> None:
        """Report a write to a field of an absent struct, which would be lost."""
        holder = member.path.rpartition(".")[0]
        if holder and not np.all(self._table.present(holder)[self._rows()]):
            raise error(
                "E0707", f"`{holder}` is absent", origin, help="assign the whole struct as a dict"
            )

    def _set_group(self, group: Group, value: Any, origin: str) -> None:
        """Make an optional struct absent (None), or write the fields of a dict into a struct."""
        rows, table = self._rows(), self._table
        if value is None:
            if not group.optional:
                raise error("E0707", "null where a value is needed", origin)
            held = np.zeros(table.size, np.bool_)
            held[rows] = True
            for path in table.children:
                child = table.store.tables[path]
                if child.layout.field.startswith(f"{group.path}."):
                    child.remove_rows(held[child.parent_rows()])
            table.column(f"{group.path}?")[rows] = False
            return
        self._need_present(group, origin)
        flat, children = given.flatten(group, value, origin)
        if children:
            raise error(
                "E0424", "a collection cannot be assigned", origin, help="use append or extend"
            )
        if not isinstance(rows, int):
            for path, item in flat.items():
                if not path.endswith("?") and self._table.fields.find(path) is not None:
                    self._set(self._member_at(path), item)
            return
        table.set_group(group, rows, {p: given.refs(v) for p, v in flat.items()})

    def _member_at(self, path: str) -> Group | Leaf | Nested:
        member = self._table.fields.find(path)
        if member is None:
            raise AraelError(unknown_field(path, self._table.data, self._group.struct, "", path))
        return member

    def short_text(self, member: Group | Leaf | Nested) -> str:
        """The value of a member in few words, for a repr."""
        value = self._get(member)
        if value is None:
            return "None"
        if isinstance(member, Nested):
            return f"[{len(value)}]"
        if isinstance(member, Group) and member.refs:
            return f"[{', '.join(value.short_text(one) for one in member.members.values())}]"
        if isinstance(member, Group):
            return "{...}"
        if isinstance(value, Parameter):
            value = value.value
        if isinstance(value, np.ndarray):
            return np.array2string(value, precision=4, threshold=6, edgeitems=2).replace("\n", "")
        if member.column.role == "ref":
            return _target(value)
        return f"{value:.6g}" if isinstance(value, float) else repr(value)


class Part(Fields):
    """A struct held by value: ``poses[3].info``, ``poses.info``."""

    def __init__(self, of: Fields, group: Group) -> None:
        object.__setattr__(self, "_table", of._table)
        object.__setattr__(self, "_group", group)
        object.__setattr__(self, "_of", of)

    def _rows(self) -> Rows:
        return self._of._rows()  # type: ignore[no-any-return]

    def _is_whole(self) -> bool:
        return bool(self._of._is_whole())

    @property
    def present(self) -> bool | NDArray[np.bool_]:
        """Whether the struct is present: bool, or (N,) bools."""
        if "present" in self._group.members:
            return self._get(self._group.members["present"])  # type: ignore[no-any-return]
        found = self._table.present(self._group.path)[self._rows()]
        return found if isinstance(found, np.ndarray) else bool(found)

    def __repr__(self) -> str:
        return f"<{self._group.struct} {self._origin(self._group.path)}: {summary(self)}>"


def summary(fields: Fields, limit: int = 6) -> str:
    """Return the first few fields with their values, for a repr."""
    texts: list[str] = []
    for name, member in fields._group.members.items():
        if len(texts) == limit:
            texts.append("...")
            break
        texts.append(f"{name}={fields.short_text(member)}")
    return ", ".join(texts)


def _target(value: Any) -> str:
    """The target of a ref, or the number of refs."""
    if not hasattr(value, "_handle"):
        return f"{len(value)} refs"
    table: Table = value._table
    return table.row_name(table.row_of(value._handle)) if value._is_there() else "stale"
