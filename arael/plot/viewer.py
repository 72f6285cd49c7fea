"""A map and the history of a solve in the viewer Rerun (https://rerun.io)."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import check_name
from arael.plot.map import SIGMAS, Map, Points, map_of
from arael.plot.residuals import residuals_of

COLORS = ((31, 95, 168), (217, 96, 26), (42, 127, 79), (34, 38, 43))
GREY = (138, 143, 152)


def rerun(
    *shown: Any,
    save: str | Path | None = None,
    name: str = "arael",
    step: int | None = None,
) -> Any:
    """Show models and results in Rerun: maps in space, costs of a solve over its attempts.

    A model gives points, paths, links and ellipsoids of two sigmas under ``map/``, and the whitened
    residuals of each constraint by row, under ``residuals/``. A result gives cost and size of the
    trust region by attempt, under ``solve/``. Rows and attempts are on the timeline ``number``.

    Parameters
    ----------
    shown : models (`arael.Model`) and results (`arael.Result`), in any number
    save : a file (``.rrd``) to write, instead of starting the viewer
    name : of the application, in the viewer
    step : where on the timeline ``step`` the map is, for one that is shown again as it changes;
        None: it is always shown

    Returns
    -------
    The stream, a `rerun.RecordingStream`, to log more to.

    Raises
    ------
    AraelError
        E0860: rerun-sdk is not installed; E0828: something that is neither model nor result.
    """
    if find_spec("rerun") is None:
        raise AraelError(
            Diagnostic(
                "E0860",
                "the viewer needs rerun-sdk, which is not installed",
                origin="rerun",
                help=("pip install 'arael[rerun]'",),
            )
        )
    # imported here: start-up time
    import rerun as rr

    stream = rr.RecordingStream(name)
    if save is not None:
        stream.save(check_name(save))
    else:
        stream.spawn()
    for one in shown:
        if hasattr(one, "history"):
            _log_result(rr, stream, one)
        elif hasattr(one, "residual_values"):
            _log_model(rr, stream, one, step)
        else:
            raise wrong_argument("rerun", "shown", "a model or the result of a solve", one)
    stream.flush()
    return stream


def _log_model(rr: Any, stream: Any, model: Any, step: int | None) -> None:
    layout = type(model).layout
    if step is not None:
        stream.set_time("step", sequence=step)
    drawn = map_of(model, layout, uncertain=True)
    if drawn is not None:
        _log_map(rr, stream, drawn, static=step is None)
    for one in residuals_of(model, layout):
        values = one.whitened
        stream.send_columns(
            f"residuals/{one.label}",
            indexes=[rr.TimeColumn("number", sequence=np.arange(len(values)))],
            columns=rr.Scalars.columns(scalars=values.ravel()).partition(
                np.full(len(values), values.shape[1])
            ),
        )


def _log_map(rr: Any, stream: Any, drawn: Map, static: bool) -> None:
    up = (
        rr.ViewCoordinates.RIGHT_HAND_Y_UP
        if drawn.up == "y"
        else rr.ViewCoordinates.RIGHT_HAND_Z_UP
    )
    stream.log("map", up, static=True)
    for number, (table, points) in enumerate(drawn.points.items()):
        color = COLORS[number % len(COLORS)]
        places = _in_space(points.places)
        labels = list(points.names) if points.names else None
        stream.log(f"map/{table}", rr.Points3D(places, colors=color, labels=labels), static=static)
        if points.covariances is not None:
            _log_ellipsoids(rr, stream, table, points, color, static)
    for one in drawn.links:
        a, b = (_in_space(drawn.points[end].places) for end in (one.a, one.b))
        strips = np.stack((a[one.pairs[:, 0]], b[one.pairs[:, 1]]), axis=1)
        path = f"map/links/{one.a}" + (f"-{one.b}" if one.a != one.b else "")
        stream.log(path, rr.LineStrips3D(strips, colors=GREY), static=static)


def _log_ellipsoids(
    rr: Any, stream: Any, table: str, points: Points, color: tuple[int, int, int], static: bool
) -> None:
    """Ellipsoids of the rows that have a variance; the axes of a plane have no height."""
    covariances = points.covariances
    assert covariances is not None
    whole = np.zeros((len(covariances), 3, 3))
    size = covariances.shape[1]
    whole[:, :size, :size] = covariances
    rows = np.flatnonzero(np.trace(whole, axis1=1, axis2=2) > 0)
    values, axes = np.linalg.eigh(whole[rows])
    axes[:, :, 0] *= np.sign(np.linalg.det(axes))[:, None]  # a rotation
    stream.log(
        f"map/{table}/uncertainty",
        rr.Ellipsoids3D(
            centers=_in_space(points.places)[rows],
            half_sizes=SIGMAS * np.sqrt(np.maximum(values, 0)),
            quaternions=_quaternions(axes),
            colors=color,
        ),
        static=static,
    )


def _quaternions(rotations: Any) -> Any:
    """(n, 4) quaternions x, y, z, w of rotation matrices."""
    # imported here: start-up time
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotations).as_quat()


def _in_space(places: Any) -> Any:
    """(n, 3) places; those of a plane at height 0."""
    found = np.zeros((len(places), 3))
    found[:, : places.shape[1]] = places
    return found


def _log_result(rr: Any, stream: Any, result: Any) -> None:
    records = [record for one in result.passes or (result,) for record in one.history]
    for attempt, record in enumerate(records, 1):
        stream.set_time("number", sequence=attempt)
        accepted = bool(record["accepted"])
        cost = float(record["trial_cost"] if accepted else record["cost"])
        stream.log("solve/cost", rr.Scalars(cost))
        if np.isfinite(record["radius"]):
            stream.log("solve/trust_region", rr.Scalars(float(record["radius"])))
