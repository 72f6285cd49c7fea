"""`arael convert`: data files from one format to another, whole or not at all."""

from __future__ import annotations

import json
import warnings
from typing import TYPE_CHECKING, Any

import click

from arael.cli.data_files import data_options
from arael.cli.exits import Exit
from arael.cli.guess import BUNDLES, model_of_format
from arael.cli.options import json_option
from arael.diagnostics.model_warnings import DataWarning
from arael.diagnostics.records import AraelError, Diagnostic
from arael.io import files, formats, losses

if TYPE_CHECKING:
    from arael.io import Trajectory
    from arael.runtime.store import Store


@click.command("convert", short_help="Convert a data file to another format.")
@click.argument("source", metavar="IN")
@click.argument("target", metavar="OUT")
@click.option("--model", metavar="MODEL", help="The model whose data IN and OUT hold.")
@data_options
@click.option(
    "--output-format",
    type=click.Choice([f for f in formats.FORMATS if f not in formats.READ_ONLY]),
    metavar="FORMAT",
    help="Format of OUT, in place of the one of its ending.",
)
@click.option(
    "--times",
    type=click.Path(dir_okay=False),
    help="Times [s] of the poses, one a line, for a trajectory that has none.",
)
@click.option("--lossy", is_flag=True, help="Leave out what OUT has no place for, and list it.")
@json_option
def command(
    source: str,
    target: str,
    model: str | None,
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    output_format: str | None,
    times: str | None,
    lossy: bool,
    as_json: bool,
) -> int:
    """Convert the data file IN to OUT, in the formats of their endings.

    Everything is converted or nothing is written: what OUT has no place for is listed, and needs
    --lossy. Graphs, bundle adjustments and trajectories are converted without --model; other
    formats have the structure of a model.
    """
    # imported here: start-up time
    from arael.cli.solve import require_writable

    require_writable(target)
    name = files.shown(target)
    wanted = output_format or formats.format_of(target, b"")
    if not wanted:
        raise _error("E0713", "the file's extension does not give a format", name, _known_formats())
    content, found = formats.load(source, format)
    if model is None and found == "csv" and wanted in formats.TRAJECTORIES:
        found = "euroc"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)  # listed as losses
        if model is None and found in formats.TRAJECTORIES and wanted in formats.TRAJECTORIES:
            unread: list[str] = []
            result, unwritten = _trajectory(source, found, wanted, times, name)
        else:
            model = model or _model_of(found, content, source)
            result, unread, unwritten = _by_model(
                source, found, wanted, model, collection, fields, information, times, name
            )
    lost = [*unread, *unwritten]
    if lost and not lossy:
        where = [f"`{model}` has no field for {losses.listed(unread)}"] if unread else []
        where += [f"{wanted} has no place for {losses.listed(unwritten)}"] if unwritten else []
        raise AraelError(
            Diagnostic(
                "E0728",
                "; ".join(where),
                origin=name,
                help=("--lossy writes the rest; .json, .npz and .h5 hold whole models",),
            )
        )
    formats.put(result, target)
    if as_json:
        click.echo(json.dumps({"from": found, "to": wanted, "left_out": lost, "written": [target]}))
        return Exit.OK
    for part in lost:
        click.echo(f"note: left out: {part}", err=True)
    click.echo(f"wrote {target}")
    return Exit.OK


def _trajectory(
    source: str, found: str, wanted: str, times: str | None, name: str
) -> tuple[bytes, list[str]]:
    """Convert a trajectory; nothing is rounded but the matrices of KITTI."""
    # imported here: start-up time
    from arael.io import trajectories, trajectory

    poses = trajectories.read_trajectory(source, found)
    poses = _timed(poses, times, wanted, name)
    return trajectory.dump(poses, wanted), _lost_of_poses(poses, wanted)


def _timed(poses: Trajectory, times: str | None, wanted: str, name: str) -> Trajectory:
    """The poses with the times of a file.

    Raises
    ------
    AraelError
        E0724 if the target needs times and there are none, E0704 another number of times.
    """
    if times is not None:
        found = _read_times(times)
        if len(found) != len(poses):
            text = f"the file has {len(found)} times for {len(poses)} poses"
            raise _error("E0704", text, times)
        return poses.with_times(found)
    if poses.times is None and wanted != "kitti":
        text = f"the poses have no times, which {wanted} needs"
        raise _error("E0724", text, name, "give them, one a line: --times FILE")
    return poses


def _read_times(path: str) -> list[float]:
    # imported here: start-up time
    from arael.io.lines import Lines
    from arael.io.report import Report

    report = Report(files.shown(path))
    lines = Lines(report.name, files.read_bytes(path), report)
    found: list[float] = []
    report.run(lambda: found.extend(lines.table([1], "a time in seconds")[:, 0].tolist()))
    return found


def _lost_of_poses(poses: Trajectory, wanted: str) -> list[str]:
    """What a format of trajectories has no place for."""
    lost = []
    if wanted == "kitti" and poses.times is not None:
        lost.append(f"the times of {len(poses)} poses")
    for part in ("velocities", "gyro_biases", "accel_biases"):
        if wanted != "euroc" and getattr(poses, part) is not None:
            lost.append(f"the {part.replace('_', ' ')} of {len(poses)} poses")
    return lost


def _by_model(
    source: str,
    found: str,
    wanted: str,
    model: str,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    times: str | None,
    name: str,
) -> tuple[bytes, list[str], list[str]]:
    """Read into a model and write from it; list what the model and the target have no place for."""
    # imported here: start-up time
    import arael

    instance: Any = arael.load(model, precision="f64", interpret=True)()  # type: ignore[call-arg]
    store: Store = instance._store
    poses = found in formats.TRAJECTORIES
    unread = formats.read_listing(
        store,
        source,
        found,
        collection=collection if found in formats.ONE_COLLECTION else None,
        fields=fields if poses else None,
        information=information,
    )
    if wanted in formats.TRAJECTORIES:
        if times is not None:
            unread = [part for part in unread if part != "times"]
        result, unwritten = _poses_of(store, wanted, collection, fields, times, name)
        return result, unread, unwritten
    if wanted in formats.ONE_COLLECTION:
        # imported here: start-up time
        from arael.io.csv_reader import choose
        from arael.io.several import collection_of

        kept = collection
        if found in formats.ONE_COLLECTION:
            kept = collection_of(store, source, found, collection, fields)
        table = choose(store, name, kept)
        result = formats.dump(store, wanted, name, kept)
        parts = ("", ".fixed", ".low", ".high")
        paths = [f"{path}{part}" for path in table.data for part in parts]
        return result, unread, losses.beside(store, table, paths)
    result = formats.dump(store, wanted, name)
    whole = wanted in ("json", "npz", "hdf5")
    return result, unread, [] if whole else _lost_on_reading(store, result, wanted, name)


def _poses_of(
    store: Store,
    wanted: str,
    collection: str | None,
    fields: dict[str, str] | None,
    times: str | None,
    name: str,
) -> tuple[bytes, list[str]]:
    """The poses of a model in a format of trajectories, and what it has no place for."""
    # imported here: start-up time
    from arael.io import trajectory

    found = trajectory.find(store, name, collection, fields)
    poses = _timed(trajectory.trajectory_of(found), times, wanted, name)
    kept = {*found.paths.values()}
    lost = losses.beside(store, found.table, kept) + _lost_of_poses(poses, wanted)
    return trajectory.dump(poses, wanted), lost


def _lost_on_reading(store: Store, content: bytes, wanted: str, name: str) -> list[str]:
    """What is missing when the new file is read again."""
    again = store.fresh()
    reader = formats.reader_of(wanted)
    reader.read(again, content, name)
    return losses.differences(store, again)


def _model_of(found: str, content: bytes, source: str) -> str:
    """The standard model of a format's data.

    Raises
    ------
    AraelError
        E0713 if the format has the structure of whatever model wrote it.
    """
    if found in (*BUNDLES, *formats.GRAPHS):
        return model_of_format(found, content)
    if found in formats.TRAJECTORIES:
        return "pose_graph_3d"
    raise _error(
        "E0713",
        f"{found} files have the structure of a model, which is not given",
        files.shown(source),
        "name it: --model MODEL",
    )


def _known_formats() -> str:
    return (
        f"known formats are {', '.join(f for f in formats.FORMATS if f not in formats.READ_ONLY)}"
    )


def _error(code: str, message: str, origin: str, help: str = "") -> AraelError:
    return AraelError(Diagnostic(code, message, origin=origin, help=(help,) if help else ()))
