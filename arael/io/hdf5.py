"""HDF5 files by h5py: a data set for each column, named as in NumPy archives (`arael.io.npz`).

The writer makes data sets ``poses.pos`` in the root group, with the unit of the model as attribute
``units``. The reader also takes groups, ``poses/pos``. External and soft links are not followed.
"""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io import npz, npz_writer
from arael.io.files import too_large
from arael.io.packages import required
from arael.runtime.store import Store
from arael.runtime.store.messages import error, shorten

Array = NDArray[Any]
MAGIC = b"\x89HDF\r\n\x1a\n"
DAMAGED = Exception
"""For damaged files h5py raises OSError, RuntimeError, ValueError, KeyError, OverflowError, ..."""
MOST_SETS = 20_000
DEEPEST = 32


def read(store: Store, content: bytes, name: str, limit: int) -> None:
    """Replace the data of `store` by that of an HDF5 file.

    Raises
    ------
    AraelError
        E0725 without h5py, E0711 not HDF5 or damaged, E0714 too large, E0718 a column twice, E0703
        a link or a type without meaning here, and the errors of `arael.io.npz.read`.
    """
    h5py = required("h5py", name, "HDF5")
    arrays: dict[str, Array] = {}
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _collect(h5py, file, "", arrays, name, limit, DEEPEST)
    except AraelError:
        raise
    except DAMAGED:
        raise error("E0711", "not an HDF5 file, or a damaged one", name) from None
    npz.adopt(store, arrays, name)


def _collect(
    h5py: Any, group: Any, prefix: str, found: dict[str, Array], name: str, limit: int, depth: int
) -> None:
    for key in group:
        path, place = f"{prefix}{key}", f"{name}: {shorten(prefix + key)}"
        if not isinstance(group.get(key, getlink=True), h5py.HardLink):
            raise error("E0703", "links to other data sets or files are not followed", place)
        member = group[key]
        if isinstance(member, h5py.Group):
            if not depth:
                raise error("E0711", f"groups are nested more than {DEEPEST} deep", place)
            _collect(h5py, member, f"{path}.", found, name, limit, depth - 1)
            continue
        if path in found or len(found) >= MOST_SETS:
            text = "is given twice" if path in found else f"is one of more than {MOST_SETS}"
            raise error("E0718", f"the data set {text}", place)
        found[path] = _array(h5py, member, place, limit)
        if sum(array.nbytes for array in found.values()) > limit:
            raise too_large(name, limit)


def _array(h5py: Any, member: Any, place: str, limit: int) -> Array:
    if not isinstance(member, h5py.Dataset) or member.shape is None:
        raise error("E0703", "expected a data set of numbers, bools or strings", place)
    if member.is_virtual or member.external:
        raise error("E0703", "data in other files is not read", place)
    if math.prod(member.shape) * member.dtype.itemsize > limit:
        raise too_large(place, limit)
    if h5py.check_string_dtype(member.dtype) is not None:
        return np.asarray(member.asstr()[()], dtype=np.str_)
    if member.dtype.kind not in "biuf":
        text = f"expected a data set of numbers, bools or strings, found {member.dtype}"
        raise error("E0703", text, place)
    return np.asarray(member[()])


def dump(store: Store, name: str) -> bytes:
    """Return the data of a store as an HDF5 file.

    Raises
    ------
    AraelError
        E0725 without h5py; E0705, E0709, E0702 as for NumPy archives.
    """
    h5py = required("h5py", name, "HDF5")
    units = {
        full: column.unit
        for table in store.tables.values()
        for full, column in npz_writer.columns_by_name(table)
        if column.unit
    }
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        for path, array in npz_writer.arrays_of(store):
            text = array.dtype.kind == "U"
            options = {"dtype": h5py.string_dtype()} if text else {}
            data = array.astype(object) if text else array
            shape: dict[str, Any] = (
                {"compression": "gzip", "compression_opts": 1} if array.ndim and array.size else {}
            )
            made = file.create_dataset(path, data=data, track_times=False, **options, **shape)
            if path in units:
                made.attrs["units"] = units[path]
    return memory.getvalue()
