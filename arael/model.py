"""A model instance: its data from Python."""

from __future__ import annotations

import os
from typing import Any, Protocol

from arael.face.collection import Collection, fill
from arael.face.fields import Fields, summary
from arael.runtime.layout import Layout
from arael.runtime.store import Store
from arael.runtime.store.schema import Nested


class Compiled(Protocol):
    """What a model instance needs of a compiled model."""

    @property
    def layout(self) -> Layout:
        """Tables, parameters, constraints."""


class Model(Fields):
    """An instance of a compiled model: the root's fields are attributes.

    Parameters
    ----------
    compiled : the compiled model
    **values : data of the root by field name; collections as lists of dicts

    Raises
    ------
    AraelError
        E0701-E0710 for values that do not fit what the model declares.

    Notes
    -----
    A field named like a method here is reached as ``model["name"]``. Fields of the root without a
    default may be set at any time before solving.
    """

    _compiled: Compiled
    _store: Store

    def __init__(self, compiled: Compiled, /, **values: Any) -> None:
        store = Store(compiled.layout)
        object.__setattr__(self, "_compiled", compiled)
        object.__setattr__(self, "_store", store)
        object.__setattr__(self, "_table", store.root)
        object.__setattr__(self, "_group", store.root.fields)
        for name, value in values.items():
            member = self._member(name)
            if isinstance(member, Nested):
                fill(Collection(store.tables[member.table.path]), value, name)
            else:
                self._set(member, value)

    def _rows(self) -> int:
        return 0

    def _get(self, member: Any) -> Any:
        if isinstance(member, Nested):
            return Collection(self._store.tables[member.table.path])
        return super()._get(member)

    def read(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Replace the data by that of a file (see `arael.io.read`); every earlier ref is stale then."""
        from arael import io

        io.read(self, path, format)

    def write(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Write the data to a file, whole or not at all (see `arael.io.write`)."""
        from arael import io

        io.write(self, path, format)

    def __repr__(self) -> str:
        layout = self._compiled.layout
        return f"<{layout.root} of {layout.source}: {summary(self, 10)}>"
