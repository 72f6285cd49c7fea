"""Trajectories to collections of poses and back: which fields hold what.

By type: a collection holds poses if its struct has a ``transform``, or a position (``vec3``) and a
rotation (``quaternion``, ``rotation``, ``euler``), or in the plane a ``vec2`` and an ``angle``.
Parameters are preferred to data. Of several vectors the one with a usual name is the position;
times, velocities and biases are found by name. The option `fields` overrides all of this.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.csv_reader import choose
from arael.io.json_writer import shortest
from arael.io.trajectory.record import NANO, Trajectory
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table, rotations
from arael.runtime.store.manifolds import kind_of
from arael.runtime.store.messages import error, suggestion

Array = NDArray[Any]

NAMES = {
    "position": ("t", "p", "pos", "position", "translation", "xyz"),
    "rotation": ("q", "r", "rot", "rotation", "orientation", "att", "attitude", "ea", "th"),
    "time": ("time", "t", "stamp", "timestamp", "time_ns", "stamp_ns", "timestamp_ns"),
    "velocity": ("v", "vel", "velocity"),
    "gyro_bias": ("bg", "bw", "b_w", "gyro_bias", "bias_gyro"),
    "accel_bias": ("ba", "b_a", "accel_bias", "acc_bias", "bias_accel"),
}
"""Names that fields usually have, by what they hold."""

WORDS = (*NAMES, "pose")
PARTS = {"velocity": "velocities", "gyro_bias": "gyro_biases", "accel_bias": "accel_biases"}
TURNS = ("quaternion", "euler")
PLANAR_TOLERANCE = 1e-9


@dataclass(frozen=True)
class PoseFields:
    """The fields of a collection that hold a trajectory.

    Attributes
    ----------
    table : the collection
    paths : path of the field by what it holds, a key of `NAMES`, or ``pose`` for a ``transform``
    planar : whether poses are of the plane, a ``vec2`` and an ``angle``
    """

    table: Table
    paths: dict[str, str]
    planar: bool

    def column(self, what: str) -> Column:
        """The column of a part."""
        return self.table.data[self.paths[what]]


def find(
    store: Store, name: str, collection: str | None = None, fields: Mapping[str, str] | None = None
) -> PoseFields:
    """Find the collection of poses and its fields.

    Parameters
    ----------
    name : of the file, for messages
    collection : its path; by default the only collection of poses, or of several the one with the
        name of the file, or ``poses``
    fields : path of a field by what it holds: ``position``, ``rotation`` or ``pose``, and ``time``,
        ``velocity``, ``gyro_bias``, ``accel_bias``

    Raises
    ------
    AraelError
        E0713 no such collection; E0724 no collection of poses or several, or fields that are
        ambiguous or have the wrong type.
    """
    given = dict(fields or {})
    for what in given.keys() - set(WORDS):
        raise error("E0724", f"a pose has no part `{what}`", name, help=suggestion(what, [*WORDS]))
    if collection is not None:
        return _fields_of(choose(store, name, collection), given, name)
    tables = [t for t in store.tables.values() if t.layout.path and not t.layout.parent]
    found = [fit for t in tables if (fit := _try(t, given, name)) is not None]
    stem = os.path.basename(name).partition(".")[0]
    named = [f for f in found if f.table.layout.path == stem]
    named = named or [f for f in found if f.table.layout.path == "poses"]
    if len(named) == 1 or len(found) == 1:
        return (named or found)[0]
    if not found and len(tables) == 1:
        return _fields_of(tables[0], given, name)  # the error names the fields
    what = ", ".join(f"`{f.table.layout.path}`" for f in found)
    raise error(
        "E0724",
        f"several collections hold poses: {what}" if found else "no collection holds poses",
        name,
        help="name one by `--collection` (`collection=`)"
        if found
        else "poses have a `transform`, or a `vec3` and a `quaternion` or `euler`; name other "
        "fields by `--fields position=...,rotation=...` (`fields=`)",
    )


def _try(table: Table, given: dict[str, str], name: str) -> PoseFields | None:
    try:
        return _fields_of(table, given, name)
    except AraelError as failure:
        if "ambiguous" in failure.diagnostics[0].message:
            raise
        return None


def _fields_of(table: Table, given: dict[str, str], name: str) -> PoseFields:
    paths = {what: _given(table, what, path, name) for what, path in given.items()}
    taken = set(paths.values())
    for what in ("time", *PARTS):
        if what not in paths:
            near = [p for p in NAMES[what] if p not in taken and _fits(table, p, what)]
            if near:
                paths[what] = near[0]
                taken.add(near[0])
    if "pose" in paths:
        return PoseFields(table, paths, False)
    planar = False
    if not {"position", "rotation"} & given.keys():
        whole = _candidates(table, taken, "pose")
        if whole:
            paths["pose"] = _only(whole, "pose", table, name)
            return PoseFields(table, paths, False)
    for what in ("position", "rotation"):
        if what in paths:
            continue
        fits = _candidates(table, taken, what)
        if not fits:
            fits, planar = _candidates(table, taken, f"planar {what}"), True
        if not fits:
            raise error(
                "E0724",
                f"the rows of `{table.layout.path}` have no field for the {what} of a pose",
                name,
                help=f"name it by `--fields {what}=...` (`fields=`)",
            )
        paths[what] = _only(fits, what, table, name)
    shape = table.data[paths["position"]].shape
    planar = shape == (2,)
    if planar != (table.data[paths["rotation"]].shape == ()):
        raise error(
            "E0724",
            f"`{paths['position']}` and `{paths['rotation']}` of `{table.layout.path}` are not a "
            "pose: one is of the plane, the other of space",
            name,
        )
    return PoseFields(table, paths, planar)


def _given(table: Table, what: str, path: str, name: str) -> str:
    if path not in table.data:
        raise error(
            "E0724",
            f"`{table.layout.path}` has no field `{path}` for the {what}",
            name,
            help=suggestion(path, list(table.data)),
        )
    if not _fits(table, path, what) and not _fits(table, path, f"planar {what}"):
        column = table.data[path]
        raise error("E0724", f"`{path}` cannot hold the {what} of a pose", name, column)
    return path


def _candidates(table: Table, taken: set[str], what: str) -> list[str]:
    """Paths of the fields that may hold a part; parameters only if there are any."""
    fits = [p for p in table.data if p not in taken and _fits(table, p, what)]
    return [p for p in fits if table.data[p].role == "param"] or fits


def _only(fits: list[str], what: str, table: Table, name: str) -> str:
    """The only candidate, or the only one with a usual name."""
    usual = [p for p in fits if p in NAMES.get(what, ())]
    if len(fits) == 1 or len(usual) == 1:
        return (usual or fits)[0]
    listed = ", ".join(f"`{p}`" for p in fits)
    raise error(
        "E0724",
        f"the {what} of the poses in `{table.layout.path}` is ambiguous: {listed}",
        name,
        help=f"choose one by `--fields {what}={fits[0]}` (`fields=`)",
    )


def _fits(table: Table, path: str, what: str) -> bool:
    """Whether a field has the type of a part."""
    column = table.data.get(path)
    if column is None or column.role == "ref" or column.within:
        return False
    kind, shape = kind_of(column), column.shape
    if what == "time":
        return column.kind in ("real", "int") and shape == ()
    if column.kind != "real":
        return False
    if what == "pose":
        return kind == "transform"
    if what == "rotation":
        return kind in TURNS
    if what == "planar rotation":
        angle = column.param is not None and column.param.kind == "angle"
        return angle or (shape == () and path in NAMES["rotation"])
    if what == "planar position":
        return shape == (2,)
    return shape == (3,) and not kind


# --- in ------------------------------------------------------------------------------------------


def fill(store: Store, trajectory: Trajectory, name: str, found: PoseFields) -> list[str]:
    """Put a trajectory into a collection; see `arael.io.read`.

    An empty collection gets a row for each pose. One with rows must have as many: positions,
    rotations and what else the file has are replaced, the other fields keep their values.

    Returns
    -------
    what of the trajectory the model has no field for

    Raises
    ------
    AraelError
        E0702 a field without default, E0704 another number of rows, E0724 poses that are not
        planar.
    """
    table, count = found.table, len(trajectory)
    values = _values(trajectory, found, name)
    if table.size and table.size != count:
        raise error(
            "E0704",
            f"the file has {count} poses, `{table.layout.path}` has {table.size} rows",
            name,
            help="values of existing rows are replaced; remove the rows first, or give a file with "
            "as many poses",
        )
    kept = [(t, t.snapshot()) for t in table.with_descendants()]
    try:
        if table.size:
            for path, array in values.items():
                table.set_values(path, slice(None), array, f"{name}: {table.layout.path}.{path}")
        else:
            table.extend(count, **values)
    except AraelError as failure:
        for changed, state in kept:
            changed.restore(state)
        raise AraelError(_in_file(d, name) for d in failure.diagnostics) from None
    return _left_out(trajectory, found)


def _in_file(diagnostic: Diagnostic, name: str) -> Diagnostic:
    origin = diagnostic.origin
    known = diagnostic.span is not None or origin.startswith(name)
    return diagnostic if known else replace(diagnostic, origin=f"{name}: {origin}")


def _values(trajectory: Trajectory, found: PoseFields, name: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    if "pose" in found.paths:
        values[found.paths["pose"]] = np.hstack([trajectory.positions, trajectory.quaternions])
    elif found.planar:
        _refuse_spatial(trajectory, name, found)
        w, z = trajectory.quaternions[:, 0], trajectory.quaternions[:, 3]
        angles = 2 * np.arctan2(np.where(w < 0, -z, z), np.abs(w))
        values[found.paths["position"]] = trajectory.positions[:, :2]
        values[found.paths["rotation"]] = angles
    else:
        turns: Array = trajectory.quaternions
        if kind_of(found.column("rotation")) == "euler":
            turns = rotations.euler_from_matrix(rotations.matrix_from_quaternion(turns))
        values[found.paths["position"]] = trajectory.positions
        values[found.paths["rotation"]] = turns
    if "time" in found.paths and trajectory.times is not None:
        values[found.paths["time"]] = (
            trajectory.exact_stamps() if _in_nanoseconds(found) else trajectory.times
        )
    for what, part in PARTS.items():
        array = getattr(trajectory, part)
        if what in found.paths and array is not None:
            values[found.paths[what]] = array
    return values


def _in_nanoseconds(found: PoseFields) -> bool:
    column = found.column("time")
    return column.kind == "int" or column.unit == "ns"


def _refuse_spatial(trajectory: Trajectory, name: str, found: PoseFields) -> None:
    off = np.abs(trajectory.positions[:, 2]) + np.abs(trajectory.quaternions[:, 1:3]).sum(axis=1)
    scale = 1 + np.abs(trajectory.positions).max(initial=0.0)
    bad = np.flatnonzero(off > PLANAR_TOLERANCE * scale)
    if len(bad):
        raise error(
            "E0724",
            f"pose {bad[0]} has a height, roll or pitch, the poses of `{found.table.layout.path}` "
            "are planar",
            name,
        )


def _left_out(trajectory: Trajectory, found: PoseFields) -> list[str]:
    lost = [
        part.replace("_", " ")
        for what, part in PARTS.items()
        if getattr(trajectory, part) is not None and what not in found.paths
    ]
    if trajectory.times is not None and "time" not in found.paths:
        lost.insert(0, "times")
    return lost


# --- out -----------------------------------------------------------------------------------------


def trajectory_of(found: PoseFields, rows: Any = slice(None)) -> Trajectory:
    """The poses of a collection.

    Raises
    ------
    AraelError
        E0705 a value that is not finite.
    """
    table = found.table

    def values(what: str) -> Array:
        return shortest(table.column(found.paths[what])[rows])

    if "pose" in found.paths:
        poses = values("pose")
        positions, turns = poses[:, :3], poses[:, 3:7]
    elif found.planar:
        half = values("rotation") / 2
        flat = values("position")
        none = np.zeros(len(flat))
        positions = np.column_stack([flat, none])
        turns = np.column_stack([np.cos(half), none, none, np.sin(half)])
    else:
        positions, turns = values("position"), values("rotation")
        if kind_of(found.column("rotation")) == "euler":
            turns = rotations.quaternion_from_euler(turns)
    more: dict[str, Any] = {}
    if "time" in found.paths:
        times = table.column(found.paths["time"])[rows]
        if not _in_nanoseconds(found):
            more["times"] = shortest(times)
        elif times.dtype.kind == "i":
            more["stamps"] = times
        else:
            more["times"] = times / NANO
    more |= {part: values(what) for what, part in PARTS.items() if what in found.paths}
    return Trajectory(positions, turns, **more)
