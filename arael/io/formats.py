"""Detection of file formats; reading and writing."""

from __future__ import annotations

import os
from typing import Any, BinaryIO, Protocol

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError
from arael.io import files
from arael.io.files import DEFAULT_LIMIT, StrPath
from arael.runtime.store import Store
from arael.runtime.store.messages import error, suggestion

# Name -> description for help texts.
FORMATS = {
    "json": "objects and arrays with the structure of the model (.json, .json.gz)",
    "npz": "NumPy columns by path (.npz)",
    "csv": "one collection, one row per line (.csv, .tsv)",
    "g2o": "pose graphs of pose_graph_2d and pose_graph_3d (.g2o)",
    "bal": "bundle adjustment of bundle_adjustment (.bal, .txt)",
}
EXTENSIONS = {
    ".json": "json",
    ".npz": "npz",
    ".csv": "csv",
    ".tsv": "csv",
    ".g2o": "g2o",
    ".bal": "bal",
}


class HasStore(Protocol):
    """A model instance."""

    _store: Store


def store_of(model: HasStore | Store) -> Store:
    """Return the store behind a model, or the store itself."""
    if isinstance(model, Store):
        return model
    store = getattr(model, "_store", None)
    if not isinstance(store, Store):
        raise wrong_argument(
            "arael.io", "model", "an instance of a model", model, "write `arael.read(model, path)`"
        )
    return store


def read(
    model: HasStore | Store,
    path: StrPath,
    format: str | None = None,
    *,
    collection: str | None = None,
    limit: int = DEFAULT_LIMIT,
) -> None:
    """Replace the data of a model by that of a file.

    Parameters
    ----------
    model : a model instance or its store; unchanged after an error
    path : the file; gzipped content is decompressed
    format : one of `FORMATS`; by default from the file's extension, else from its content
    collection : for CSV, the collection that the rows belong to (only its rows are replaced); by
        default the one with the name of the file, or the model's only one
    limit : the most bytes to read, after decompression

    Raises
    ------
    AraelError
        E0712 unreadable, E0713 unknown format, E0714 too large, and the errors of the readers;
        several diagnostics at once if there are several errors.
    """
    store = store_of(model)
    path = files.check_name(path)
    _check_collection(collection)
    name = files.shown(path)
    content = files.read_bytes(path, limit)
    if not content.startswith(b"PK"):
        content = files.without_mark(content, name)
    found = _known(format) if format is not None else format_of(path, content)
    if not found:
        raise error(
            "E0713",
            "the format is not recognised",
            name,
            help=f"known formats are {', '.join(FORMATS)}",
        )
    if not content.strip():
        raise error("E0712", "the file is empty", name)
    if collection is not None and found != "csv":
        raise error("E0713", f"`collection` is for CSV; this is {found}", name)
    if found == "json":
        # imported here: start-up time
        from arael.io import json_reader

        json_reader.read(store, content, name)
    elif found == "npz":
        # imported here: start-up time
        from arael.io import npz

        npz.read(store, content, name, limit)
    elif found == "csv":
        # imported here: start-up time
        from arael.io import csv_reader

        csv_reader.read(store, content, name, collection)
    elif found == "g2o":
        # imported here: start-up time
        from arael.io import g2o

        g2o.read(store, content, name)
    else:
        # imported here: start-up time
        from arael.io import bal

        bal.read(store, content, name)


def write(
    model: HasStore | Store,
    path: StrPath,
    format: str | None = None,
    *,
    collection: str | None = None,
) -> None:
    """Write the data of a model to a file atomically.

    Parameters
    ----------
    model : a model instance or its store
    path : the file; ``.gz`` at the end compresses
    format : one of `FORMATS`; by default from the file's extension
    collection : for CSV, the collection to write; by default the one with the name of the file, or
        the model's only one

    Raises
    ------
    AraelError
        E0713 unknown format, E0715 on a system error (the old file is unchanged), E0705 NaN or
        infinite, E0709 a stale ref, E0722 a model that does not have the structure of the format.
    """
    store = store_of(model)
    path = files.check_name(path)
    _check_collection(collection)
    name = files.shown(path)
    found = _known(format) if format is not None else format_of(path, b"")
    if not found:
        raise error(
            "E0713",
            "the file's extension does not give a format",
            name,
            help=f"known formats are {', '.join(FORMATS)}",
        )
    content = _content(store, found, name, collection)
    if name.endswith(".gz"):
        content = files.compress(content)

    def put(file: BinaryIO) -> None:
        file.write(content)

    files.write_whole(path, put)


def _content(store: Store, format: str, name: str, collection: str | None) -> bytes:
    if format == "json":
        # imported here: start-up time
        from arael.io import json_writer

        return json_writer.dump(store)
    if format == "npz":
        # imported here: start-up time
        from arael.io import npz_writer

        return npz_writer.dump(store)
    if format == "csv":
        # imported here: start-up time
        from arael.io import csv_writer

        return csv_writer.dump(store, name, collection)
    if format == "bal":
        # imported here: start-up time
        from arael.io import bal

        return bal.dump(store, name)
    # imported here: start-up time
    from arael.io import g2o

    return g2o.dump(store, name)


def format_of(path: StrPath, content: bytes) -> str:
    """Name of the format of a file, by its extension or else by its first bytes; "" if unknown."""
    name = os.path.basename(os.fspath(path)).lower().removesuffix(".gz")
    extension = os.path.splitext(name)[1]
    if extension in EXTENSIONS:
        return EXTENSIONS[extension]
    # imported here: start-up time
    from arael.io.bal import HEAD

    if HEAD.match(content[:4096]) or (extension == ".txt" and not content):
        return "bal"
    start = content[:4096].lstrip()
    if start.startswith(b"PK\x03\x04"):
        return "npz"
    if start.startswith(b"{"):
        return "json"
    if start.startswith((b"VERTEX", b"EDGE", b"FIX")):
        return "g2o"
    return ""


def _check_collection(collection: Any) -> None:
    if collection is not None and not isinstance(collection, str):
        raise wrong_argument("arael.io", "collection", "the path of a collection", collection)


def _known(format: Any) -> str:
    if not isinstance(format, str):
        raise wrong_argument("arael.io", "format", f"one of {', '.join(FORMATS)}", format)
    if format in FORMATS:
        return format
    raise AraelError(
        error(
            "E0713", f"there is no format `{format}`", "", help=suggestion(format, list(FORMATS))
        ).diagnostics
    )
