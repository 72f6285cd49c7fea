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
_THICK, _THIN = -2.5, -0.5  # radii of points and lines; negative: on the screen, not of the map


def rerun(
    *shown: Any,
    save: str | Path | None = None,
    name: str = "arael",
    step: int | None = None,
    stream: Any = None,
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
    stream : what an earlier call returned, to show more there; None: a new one

    Returns
    -------
    The stream, a `rerun.RecordingStream`, to log more to.

    Raises
    ------
    AraelError
        E0860: rerun-sdk is not installed; E0828: something that is neither model nor result, or
        `stream` is no stream.
    """
    rr = _imported()
    if stream is None:
        stream = _stream(rr, save, name)
        models = [one for one in shown if hasattr(one, "residual_values")]
        _arrange(stream, models[:1], "number" if step is None else "step")
    elif not isinstance(stream, rr.RecordingStream):
        raise wrong_argument("rerun", "stream", "what `rerun` returned before", stream)
    for one in shown:
        stream.reset_time()
        if hasattr(one, "history"):
            _log_result(rr, stream, one)
        elif hasattr(one, "residual_values"):
            _log_model(rr, stream, one, step)
        else:
            raise wrong_argument("rerun", "shown", "a model or the result of a solve", one)
    stream.flush()
    return stream


def rerun_solve(
    model: Any, *, save: str | Path | None = None, name: str = "arael", **settings: Any
) -> Any:
    """Solve a model, and show it in Rerun as it moves: the map after each accepted step.

    The start is at 0 of the timeline ``step``, and the solution with its ellipsoids at its end;
    cost and size of the trust region are on the same timeline, residuals on ``number``.

    Parameters
    ----------
    model : an `arael.Model`
    save : a file (``.rrd``) to write, instead of starting the viewer
    name : of the application, in the viewer
    **settings : of the solve; see `arael.solving.solve`

    Returns
    -------
    The result, an `arael.Result`.

    Raises
    ------
    AraelError
        E0860: rerun-sdk is not installed; and what a solve raises.
    """
    rr = _imported()
    stream = _stream(rr, save, name)
    on_step = settings.pop("on_step", None)
    steps = 0

    def show(now: Any, record: Any) -> Any:
        nonlocal steps
        steps += 1
        _log_step(rr, stream, now, steps)
        _log_attempt(rr, stream, record)
        return None if on_step is None else on_step(now, record)

    _arrange(stream, [model], "step")
    _log_step(rr, stream, model, 0)
    result = model.solve(on_step=show, **settings)
    rerun(model, stream=stream, step=steps)
    return result


def _imported() -> Any:
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

    return rr


def _stream(rr: Any, save: str | Path | None, name: str) -> Any:
    """A new recording, into a file or a viewer."""
    stream = rr.RecordingStream(name)
    if save is not None:
        stream.save(check_name(save))
    else:
        stream.spawn()
    return stream


def _log_step(rr: Any, stream: Any, model: Any, step: int) -> None:
    """Log the map without ellipsoids, which would take longer than a step."""
    stream.set_time("step", sequence=step)
    drawn = map_of(model, type(model).layout)
    if drawn is not None:
        _log_map(rr, stream, drawn, static=False)


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
        stream.log(
            f"map/{table}",
            rr.Points3D(places, colors=color, labels=labels, radii=_THICK),
            static=static,
        )
        if points.covariances is not None:
            _log_ellipsoids(rr, stream, table, points, color, static)
    for one in drawn.links:
        a, b = (_in_space(drawn.points[end].places) for end in (one.a, one.b))
        strips = np.stack((a[one.pairs[:, 0]], b[one.pairs[:, 1]]), axis=1)
        path = f"map/links/{one.a}" + (f"-{one.b}" if one.a != one.b else "")
        stream.log(path, rr.LineStrips3D(strips, colors=GREY, radii=_THIN), static=static)


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
        _log_attempt(rr, stream, record)


def _log_attempt(rr: Any, stream: Any, record: Any) -> None:
    """Log cost and size of the trust region at the present time."""
    cost = float(record["trial_cost"] if record["accepted"] else record["cost"])
    stream.log("solve/cost", rr.Scalars(cost))
    if np.isfinite(record["radius"]):
        stream.log("solve/trust_region", rr.Scalars(float(record["radius"])))


def _arrange(stream: Any, models: list[Any], timeline: str) -> None:
    """Arrange the viewer: a large map, seen from above if it is in a plane, beside the curves."""
    # imported here: start-up time
    from rerun import blueprint as rrb

    eye = None
    labels: list[str] = []
    for model in models:
        layout = type(model).layout
        if timeline == "number":
            labels = [one.label for one in residuals_of(model, layout)]
        drawn = map_of(model, layout)
        if drawn is not None and all(p.places.shape[1] == 2 for p in drawn.points.values()):
            eye = _eye_above(rrb, np.concatenate([p.places for p in drawn.points.values()]))
    # Curves are over the timeline that is chosen, and residuals by row are on `number`.
    curves: list[Any] = [
        rrb.TimeSeriesView(origin="solve/cost"),
        rrb.TimeSeriesView(origin="solve/trust_region"),
    ]
    by_row = [rrb.TimeSeriesView(origin=f"residuals/{one}", name=one) for one in labels]
    curves = [*curves, rrb.Tabs(*by_row)] if by_row else curves
    views = (rrb.Spatial3DView(origin="map", eye_controls=eye), rrb.Vertical(*curves))
    stream.send_blueprint(
        rrb.Blueprint(
            rrb.Horizontal(*views, column_shares=[5, 2]),
            rrb.BlueprintPanel(state="collapsed"),
            rrb.SelectionPanel(state="collapsed"),
            rrb.TimePanel(timeline=timeline, state="collapsed"),
        )
    )


def _eye_above(rrb: Any, places: Any) -> Any:
    """The eye above the middle of places in a plane, so high that all of them are seen."""
    low, high = places.min(axis=0), places.max(axis=0)
    middle = (*(low + high) / 2, 0.0)
    height = 1.2 * max(float(np.max(high - low)), 1.0)
    above = (middle[0], middle[1], height)
    return rrb.EyeControls3D(position=above, look_target=middle, eye_up=[0.0, 1.0, 0.0])
