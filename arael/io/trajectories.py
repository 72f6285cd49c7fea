"""Trajectories without a model, and those of a model."""

from __future__ import annotations

from collections.abc import Mapping

from arael.io import files, formats
from arael.io.files import DEFAULT_LIMIT, StrPath
from arael.io.trajectory import Trajectory, text
from arael.io.trajectory import fields as fields_of_poses
from arael.runtime.store import Store
from arael.runtime.store.messages import error


def read_trajectory(
    path: StrPath, format: str | None = None, *, limit: int = DEFAULT_LIMIT
) -> Trajectory:
    """Read a trajectory without a model.

    Parameters
    ----------
    format : ``tum``, ``kitti`` or ``euroc``; by default from the file's extension or content

    Raises
    ------
    AraelError
        E0712, E0713, E0714, and with file and line E0716, E0705, E0721.
    """
    path = files.check_name(path)
    name = files.shown(path)
    content, found = formats.load(path, format, limit)
    if found == "csv" and format is None:
        found = "euroc"
    if found not in formats.TRAJECTORIES:
        raise error(
            "E0713",
            f"{found} files hold no trajectory",
            name,
            help=f"formats of trajectories are {', '.join(formats.TRAJECTORIES)}",
        )
    return text.parse(content, name, found)


def write_trajectory(trajectory: Trajectory, path: StrPath, format: str | None = None) -> None:
    """Write a trajectory as TUM, KITTI or EuRoC, atomically.

    TUM and EuRoC files have times: without any the row numbers are written, as seconds. What the
    format does not have (times in KITTI, velocities in TUM) is not written.

    Raises
    ------
    AraelError
        E0713 unknown format, E0715 on a system error.
    """
    path = files.check_name(path)
    name = files.shown(path)
    found = formats.known(format) if format else formats.format_of(path, b"")
    if found not in formats.TRAJECTORIES:
        raise error(
            "E0713",
            "expected the format of a trajectory",
            name,
            help=f"formats of trajectories are {', '.join(formats.TRAJECTORIES)}",
        )
    formats.put(text.dump(trajectory, found), path)


def trajectory_of(
    model: formats.HasStore | Store,
    collection: str | None = None,
    fields: Mapping[str, str] | None = None,
) -> Trajectory:
    """The poses of a model as a trajectory; `collection` and `fields` as in `read`.

    Raises
    ------
    AraelError
        E0713 no such collection, E0724 no poses or ambiguous fields, E0705 not finite.
    """
    store = formats.store_of(model)
    found = fields_of_poses.find(store, store.layout.root, collection, fields)
    return fields_of_poses.trajectory_of(found)
