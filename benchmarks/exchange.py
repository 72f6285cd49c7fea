"""Files of named columns that peers in other languages read and write.

A line per column (name, ``f64`` or ``i64``, dimensions), an empty line, then the values of all
columns in that order, little-endian, row-major. Names and values are those of the model's NPZ file.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import arael

KINDS = {"f64": "<f8", "i64": "<i8"}


def write(path: Path, found: Mapping[str, np.ndarray]) -> None:
    """Write columns; integers and truth values become ``i64``, all else ``f64``."""
    heads, parts = [], []
    for name, values in found.items():
        kind = "i64" if values.dtype.kind in "iub" else "f64"
        heads.append(" ".join([name, kind, *(str(n) for n in values.shape)]))
        parts.append(np.ascontiguousarray(values, dtype=KINDS[kind]).tobytes())
    head = "\n".join([*heads, "", ""]).encode()
    path.write_bytes(head + b"".join(parts))


def read(path: Path) -> dict[str, np.ndarray]:
    """Read what a peer wrote."""
    head, _, rest = path.read_bytes().partition(b"\n\n")
    found, at = {}, 0
    for line in head.decode().splitlines():
        name, kind, *shape = line.split(" ")
        sizes = [int(n) for n in shape]
        count = int(np.prod(sizes, dtype=np.int64))
        values = np.frombuffer(rest, KINDS[kind], count, at)
        found[name] = values.reshape(sizes).copy()
        at += values.nbytes
    return found


def write_model(path: Path, instance: Any) -> None:
    """Write all data of a model instance."""
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / "model.npz"
        arael.write(instance, archive)
        with np.load(archive) as file:
            write(path, {name: file[name] for name in file.files})
