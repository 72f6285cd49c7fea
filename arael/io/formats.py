"""Detection of file formats; reading and writing."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from importlib import import_module
from typing import Any, BinaryIO, Protocol

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError
from arael.io import files
from arael.io.files import DEFAULT_LIMIT, StrPath
from arael.io.losses import warn, warn_of_loss
from arael.runtime.store import Store
from arael.runtime.store.messages import error, suggestion

# Name -> description for help texts.
FORMATS = {
    "json": "objects and arrays with the structure of the model (.json, .json.gz)",
    "npz": "NumPy columns by path (.npz)",
    "hdf5": "the same columns as HDF5 data sets (.h5, .hdf5); needs h5py",
    "csv": "one collection, one row per line (.csv, .tsv)",
    "parquet": "one collection, columns as for CSV (.parquet); needs pyarrow",
    "arrow": "one collection, columns as for CSV (.arrow, .feather); needs pyarrow",
    "g2o": "graphs of poses and landmarks of pose_graph_2d and pose_graph_3d (.g2o)",
    "toro": "pose graphs of TORO (.toro, .graph)",
    "bal": "bundle adjustment of bundle_adjustment (.bal, .txt)",
    "bundler": "bundle adjustment of bundle_adjustment, only read (bundle.out)",
    "colmap": "bundle adjustment of bundle_adjustment, only read (a folder with cameras.txt)",
    "tum": "poses of one collection: time x y z qx qy qz qw (.tum)",
    "kitti": "poses of one collection, without times: 12 numbers a line (.kitti)",
    "euroc": "poses of one collection with velocities and biases (.euroc, .csv with its header)",
}
EXTENSIONS = {
    ".json": "json",
    ".npz": "npz",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".csv": "csv",
    ".tsv": "csv",
    ".parquet": "parquet",
    ".arrow": "arrow",
    ".feather": "arrow",
    ".g2o": "g2o",
    ".toro": "toro",
    ".graph": "toro",
    ".bal": "bal",
    ".tum": "tum",
    ".kitti": "kitti",
    ".euroc": "euroc",
}
TRAJECTORIES = ("tum", "kitti", "euroc")
GRAPHS = ("g2o", "toro")
ONE_COLLECTION = ("csv", "parquet", "arrow", *TRAJECTORIES)
"""Formats of which a file holds the rows of one collection."""
READ_ONLY = ("bundler", "colmap")
EUROC_HEAD = re.compile(rb"#\s*timestamp", re.IGNORECASE)
NUMBERS = re.compile(rb"[-+.\deE,\s]+", re.ASCII)


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
    fields: Mapping[str, str] | None = None,
    information: float | tuple[float, float] | None = None,
    limit: int = DEFAULT_LIMIT,
) -> None:
    """Replace the data of a model by that of a file.

    Parameters
    ----------
    model : a model instance or its store; unchanged after an error
    path : the file, or the folder of a COLMAP model; gzipped content is decompressed
    format : one of `FORMATS`; by default from the file's extension, else from its content
    collection : for formats that hold one, the collection that the rows belong to (only its rows
        are replaced); by default the one with the name of the file, or the model's only one, and
        for trajectories the one that holds poses
    fields : for trajectories, the path of a field by what it holds (``position``, ``rotation``,
        ``pose``, ``time``, ``velocity``, ``gyro_bias``, ``accel_bias``); by default from types and
        names
    information : for g2o and TORO, the information of measurements whose line gives none: one
        number, or that of positions [1/m^2] and that of rotations [1/rad^2]
    limit : the most bytes to read, after decompression

    Warns
    -----
    DataWarning
        The model has no field for something in the file.

    Raises
    ------
    AraelError
        E0712 unreadable, E0713 unknown format, E0714 too large, and the errors of the readers;
        several diagnostics at once if there are several errors.
    """
    lost = read_listing(
        model,
        path,
        format,
        collection=collection,
        fields=fields,
        information=information,
        limit=limit,
    )
    warn_of_loss(lost, files.shown(files.check_name(path)))


def read_listing(
    model: HasStore | Store,
    path: StrPath,
    format: str | None = None,
    *,
    collection: str | None = None,
    fields: Mapping[str, str] | None = None,
    information: float | tuple[float, float] | None = None,
    limit: int = DEFAULT_LIMIT,
) -> list[str]:
    """As `read`, but list what the model has no field for in place of warning of it."""
    store = store_of(model)
    path = files.check_name(path)
    _check_collection(collection)
    name = files.shown(path)
    content, found = load(path, format, limit)
    _refuse_options(found, name, collection, fields)
    given = _information(information)
    if found in GRAPHS:
        return list(reader_of(found).read(store, content, name, given))
    if given is not None:
        raise error("E0713", f"`information` is for g2o and TORO; this is {found}", name)
    return _read(store, found, path, content, name, collection, fields, limit)


def load(path: str, format: str | None, limit: int = DEFAULT_LIMIT) -> tuple[bytes, str]:
    """Content and format of a file; a COLMAP folder has no content.

    Raises
    ------
    AraelError
        E0712 unreadable, E0713 unknown format, E0714 too large.
    """
    name = files.shown(path)
    if os.path.isdir(path) and format in (None, "colmap"):
        return _load_folder(path, name, format)
    content = files.read_bytes(path, limit)
    if not content.startswith(b"PK"):
        content = files.without_mark(content, name)
    found = known(format) if format is not None else format_of(path, content)
    if not found:
        raise error(
            "E0713",
            "the format is not recognised",
            name,
            help=f"known formats are {', '.join(FORMATS)}",
        )
    if not content.strip():
        raise error("E0712", "the file is empty", name)
    return content, found


def _information(given: Any) -> tuple[float, float] | None:
    """Information of positions and rotations; E0713 if these are no positive numbers."""
    if given is None:
        return None
    both = (given, given) if isinstance(given, int | float) else given
    if (
        not isinstance(both, tuple | list)
        or len(both) != 2
        or not all(isinstance(v, int | float) and 0 < v < math.inf for v in both)
    ):
        what = "a positive number, or one for positions and one for rotations"
        raise wrong_argument("arael.io", "information", what, given)
    return float(both[0]), float(both[1])


def _load_folder(path: str, name: str, format: str | None) -> tuple[bytes, str]:
    # imported here: start-up time
    from arael.io import colmap

    if format is None and not colmap.is_folder(path):
        if colmap.is_binary_folder(path):
            raise error(
                "E0713",
                "the folder holds a COLMAP model in binary form, which is not read",
                name,
                help="convert it: colmap model_converter --output_type TXT",
            )
        raise error("E0712", "expected a file, found a directory", name)
    return b"", "colmap"


def _refuse_options(
    found: str, name: str, collection: str | None, fields: Mapping[str, str] | None
) -> None:
    """E0713 for options that the format does not have."""
    if collection is not None and found not in ONE_COLLECTION:
        raise error("E0713", f"`collection` is for CSV and other tables; this is {found}", name)
    if fields and found not in TRAJECTORIES:
        raise error("E0713", f"`fields` is for trajectories; this is {found}", name)


def _read(
    store: Store,
    found: str,
    path: str,
    content: bytes,
    name: str,
    collection: str | None,
    fields: Mapping[str, str] | None,
    limit: int,
) -> list[str]:
    """Call the reader of a format; return what the model has no field for."""
    if found in TRAJECTORIES:
        # imported here: start-up time
        from arael.io import trajectory

        target = trajectory.find(store, name, collection, fields)
        return trajectory.fill(store, trajectory.parse(content, name, found), name, target)
    # imported here: start-up time
    reader = reader_of(found)
    if found == "colmap":
        return list(reader.read(store, path, limit))
    if found in ("parquet", "arrow"):
        reader.read(store, content, name, found, collection, limit)
    elif found == "csv":
        reader.read(store, content, name, collection)
    elif found in ("npz", "hdf5"):
        reader.read(store, content, name, limit)
    else:
        return list(reader.read(store, content, name) or ())
    return []


def reader_of(format: str) -> Any:
    """Module of the reader of a format of whole models."""
    return import_module(f"arael.io.{READERS[format]}")


READERS = {
    "json": "json_reader",
    "npz": "npz",
    "hdf5": "hdf5",
    "csv": "csv_reader",
    "parquet": "arrow",
    "arrow": "arrow",
    "g2o": "g2o",
    "toro": "g2o",
    "bal": "bal",
    "bundler": "bundler",
    "colmap": "colmap",
}
"""Module of the reader of each format."""


def write(
    model: HasStore | Store,
    path: StrPath,
    format: str | None = None,
    *,
    collection: str | None = None,
    fields: Mapping[str, str] | None = None,
) -> None:
    """Write the data of a model to a file, atomically; gzipped for a name that ends with .gz.

    Parameters
    ----------
    model : a model instance or its store
    path : the file
    format : one of `FORMATS`; by default from the file's extension
    collection : for formats that hold one, the collection to write; by default the one with the
        name of the file, or the model's only one, and for trajectories the one that holds poses
    fields : for trajectories, the path of a field by what it holds, as in `read`

    Warns
    -----
    DataWarning
        A TUM or EuRoC file without times: the row numbers are written.

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
    found = known(format) if format is not None else format_of(path, b"")
    if not found:
        raise error(
            "E0713",
            "the file's extension does not give a format",
            name,
            help=f"known formats are {', '.join(f for f in FORMATS if f not in READ_ONLY)}",
        )
    _refuse_options(found, name, collection, fields)
    put(dump(store, found, name, collection, fields), path)


def put(content: bytes, path: str) -> None:
    """Write bytes atomically; gzipped for a name that ends with .gz."""
    if path.endswith(".gz"):
        content = files.compress(content)

    def write_to(file: BinaryIO) -> None:
        file.write(content)

    files.write_whole(path, write_to)


def dump(
    store: Store,
    found: str,
    name: str,
    collection: str | None = None,
    fields: Mapping[str, str] | None = None,
) -> bytes:
    """The content of a file of a format; raises AraelError as `write` does."""
    if found in READ_ONLY:
        writable = [f for f in FORMATS if f not in READ_ONLY]
        raise error(
            "E0713",
            f"{found} files are read and not written",
            name,
            help=f"formats for writing are {', '.join(writable)}",
        )
    if found != "json" and store.residuals is not None and store.residuals.priors:
        warn(f"{found} files have no place for priors of marginalised rows: write JSON", name)
    if found in TRAJECTORIES:
        # imported here: start-up time
        from arael.io import trajectory

        poses = trajectory.trajectory_of(trajectory.find(store, name, collection, fields))
        if poses.times is None and found != "kitti":
            warn("no field of the model holds times: row numbers are written as seconds", name)
        return trajectory.dump(poses, found)
    # imported here: start-up time
    module: Any = import_module(f"arael.io.{WRITERS[found]}")
    if found in ("parquet", "arrow"):
        content = module.dump(store, name, found, collection)
    elif found == "csv":
        content = module.dump(store, name, collection)
    elif found in ("json", "npz"):
        content = module.dump(store)
    elif found == "toro":
        content = module.dump_toro(store, name)
    else:
        content = module.dump(store, name)
    return bytes(content)


WRITERS = {
    "json": "json_writer",
    "npz": "npz_writer",
    "hdf5": "hdf5",
    "csv": "csv_writer",
    "parquet": "arrow",
    "arrow": "arrow",
    "g2o": "g2o",
    "toro": "g2o",
    "bal": "bal",
}
"""Module of the writer of each format."""


def format_of(path: StrPath, content: bytes) -> str:
    """Name of the format of a file, by its extension or else by its first bytes; "" if unknown."""
    name = os.path.basename(os.fspath(path)).lower().removesuffix(".gz")
    extension = os.path.splitext(name)[1]
    if extension == ".csv" and EUROC_HEAD.match(content[:100].lstrip()):
        return "euroc"
    if extension in EXTENSIONS:
        return EXTENSIONS[extension]
    for magic, binary in MAGIC.items():
        if content.startswith(magic):
            return binary
    if content.startswith(b"# Bundle file"):
        return "bundler"
    # imported here: start-up time
    from arael.io.bal import HEAD

    if HEAD.match(content[:4096]) or (extension == ".txt" and not content):
        return "bal"
    start = content[:4096].lstrip()
    if start.startswith(b"PK\x03\x04"):
        return "npz"
    if start.startswith(b"{"):
        return "json"
    if start.startswith((b"VERTEX", b"EDGE", b"FIX", b"PARAMS_SE", b"TUTORIAL_", b"EQUIV")):
        return "g2o"
    return _kind_of_trajectory(content[:65536])


def _check_collection(collection: Any) -> None:
    if collection is not None and not isinstance(collection, str):
        raise wrong_argument("arael.io", "collection", "the path of a collection", collection)


MAGIC = {b"\x89HDF\r\n\x1a\n": "hdf5", b"PAR1": "parquet", b"ARROW1": "arrow"}
"""First bytes of binary files."""


def _kind_of_trajectory(start: bytes) -> str:
    """The format of a text that begins with a pose; "" for any other."""
    lines = start.splitlines()
    first = next((x for x in lines if x.strip() and not x.lstrip().startswith(b"#")), b"")
    if not NUMBERS.fullmatch(first):
        return ""
    if b"," in first:
        return "euroc" if first.count(b",") in (7, 10, 16) else ""
    return {8: "tum", 12: "kitti"}.get(len(first.split()), "")


def known(format: Any) -> str:
    """The name of a format as given; E0713 for any other."""
    if not isinstance(format, str):
        raise wrong_argument("arael.io", "format", f"one of {', '.join(FORMATS)}", format)
    if format in FORMATS:
        return format
    raise AraelError(
        error(
            "E0713", f"there is no format `{format}`", "", help=suggestion(format, list(FORMATS))
        ).diagnostics
    )
