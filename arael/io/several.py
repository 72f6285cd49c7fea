"""Several data files for one model: each goes to the collection of its name."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from arael.io import files, formats, trajectory
from arael.io.csv_reader import choose
from arael.io.files import DEFAULT_LIMIT, StrPath
from arael.io.formats import HasStore
from arael.io.losses import warn_of_loss
from arael.runtime.store import Store, Table
from arael.runtime.store.messages import error


@dataclass(frozen=True)
class Source:
    """One of the files.

    Attributes
    ----------
    collection : the collection that its rows belong to; None for a file of the whole model
    """

    path: str
    format: str
    collection: str | None

    @property
    def name(self) -> str:
        """The name for messages."""
        return files.shown(self.path)


def split(argument: str) -> tuple[str | None, str]:
    """Collection and file of ``name=path``, or None and the file.

    A file whose whole name is `argument` is preferred.
    """
    name, sign, path = argument.partition("=")
    plain = name.replace("_", "").replace(".", "")
    if sign and path and plain.isalnum() and not os.path.exists(argument):
        return name, path
    return None, argument


def read_several(
    model: HasStore | Store,
    paths: Iterable[StrPath | tuple[str | None, StrPath]] | Mapping[str, StrPath],
    format: str | None = None,
    *,
    fields: Mapping[str, str] | None = None,
    limit: int = DEFAULT_LIMIT,
) -> None:
    """Replace the data of a model by that of several files.

    A file of the whole model (JSON, NPZ, HDF5, a graph, a bundle adjustment) is read first. A file
    of one collection replaces its rows; collections that refs point into are read before those with
    the refs. The model is unchanged after an error.

    Parameters
    ----------
    paths : the files, alone or as pairs (collection, file), or by collection; without it the
        collection is the one with the name of the file
    format, fields, limit : as for `read`; `format` is that of all files

    Raises
    ------
    AraelError
        As `read`; E0727 for two files of one collection or of the whole model.
    """
    store = formats.store_of(model)
    listed = list(paths.items()) if isinstance(paths, Mapping) else list(paths)
    pairs = [item if isinstance(item, tuple) else (None, item) for item in listed]
    sources = [_source(store, name, path, format, fields) for name, path in pairs]
    _refuse_conflicts(sources)
    fresh = store.fresh()
    for source in _ordered(store, sources):
        mapping = fields if source.format in formats.TRAJECTORIES else None
        lost = formats.read_listing(
            fresh,
            source.path,
            source.format,
            collection=source.collection,
            fields=mapping,
            limit=limit,
        )
        warn_of_loss(lost, source.name)
    store.adopt(fresh)


def _source(
    store: Store,
    collection: str | None,
    given: StrPath,
    format: str | None,
    fields: Mapping[str, str] | None,
) -> Source:
    path = files.check_name(given)
    _, found = formats.load(path, format)
    if found not in formats.ONE_COLLECTION:
        if collection is not None:
            text = f"a {found} file holds the whole model, not the collection `{collection}`"
            raise error("E0713", text, files.shown(path))
        return Source(path, found, None)
    return Source(path, found, collection_of(store, path, found, collection, fields))


def collection_of(
    store: Store,
    path: str,
    format: str,
    collection: str | None,
    fields: Mapping[str, str] | None,
) -> str:
    """The collection that a file of one collection fills."""
    name = files.shown(path)
    if format in formats.TRAJECTORIES:
        return trajectory.find(store, name, collection, fields).table.layout.path
    return choose(store, name, collection).layout.path


def _refuse_conflicts(sources: list[Source]) -> None:
    seen: dict[str | None, Source] = {}
    for source in sources:
        before = seen.setdefault(source.collection, source)
        # A trajectory replaces values of rows that another file adds.
        if before is source:
            continue
        if source.collection is None:
            what = f"the file holds the whole model, as does {before.name}"
        else:
            what = f"the file holds the collection `{source.collection}`, as does {before.name}"
        raise error(
            "E0727",
            what,
            source.name,
            help="give one of them, or name the collection of a file: name=path",
        )


def _ordered(store: Store, sources: list[Source]) -> list[Source]:
    """Files of the whole model first, then collections, those that refs point into first."""
    left = sorted(sources, key=lambda s: s.collection is not None)
    found: list[Source] = []
    while left:
        waiting = {s.collection for s in left}
        ready = next(
            (
                s
                for s in left
                if s.collection is None
                or not (_targets(store.tables[s.collection]) - {s.collection}) & waiting
            ),
            left[0],
        )
        left.remove(ready)
        found.append(ready)
    return found


def _targets(table: Table) -> set[str | None]:
    """The collections of the root that refs of a table point into."""
    targets = [c.target.table for c in table.data.values() if c.target is not None]
    return {target.partition(".")[0] for target in targets}
