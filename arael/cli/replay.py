"""`arael replay`: a recorded problem row by row, with an update after each."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import click
import numpy as np

from arael.cli.data_files import data_options, model_with_data
from arael.cli.exits import Exit
from arael.cli.guess import model_and_data
from arael.cli.options import json_option
from arael.cli.solve import require_picture
from arael.online.recording import Recording
from arael.online.update import TOLERANCE


@click.command("replay", short_help="Solve a recorded problem row by row.")
@click.argument("arguments", metavar="[MODEL] DATA...", nargs=-1, required=True)
@data_options
@click.option("--by", metavar="NAME", help="Collection whose rows come one at a time, or a column.")
@click.option("--every", type=click.IntRange(1), default=1, help="Rows of it a step.")
@click.option("--tolerance", type=click.FloatRange(0), default=TOLERANCE, show_default=True)
@click.option("--max-seconds", type=click.FloatRange(0, min_open=True), help="Limit of an update.")
@click.option("--plot", type=click.Path(dir_okay=False), help="Draw the times (.png, .pdf, .svg).")
@json_option
def command(
    arguments: tuple[str, ...],
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    by: str | None,
    every: int,
    tolerance: float,
    max_seconds: float | None,
    plot: str | None,
    as_json: bool,
) -> int:
    """Append the rows of DATA one after the other, with an update after each, and print the times.

    The model is found as `arael solve` finds it.
    """
    require_picture(plot)
    guess = model_and_data(arguments, format)
    whole = model_with_data(guess, format, collection, fields, information, quiet=as_json)
    recording = Recording(whole, by, every)
    found = _replay(recording, type(whole)(), tolerance, max_seconds)
    if plot is not None:
        _draw(found["milliseconds"], f"updates of {Path(guess.data[-1]).name}", plot)
    if as_json:
        click.echo(json.dumps({"by": recording.by, "written": [plot] if plot else [], **found}))
        return Exit.OK
    times = np.array(found["milliseconds"] or [0.0])
    middle, high = np.percentile(times, [50, 99])
    click.echo(
        f"{recording.steps} steps by {recording.by}: mean {times.mean():.3g} ms,"
        f" median {middle:.3g}, 99th percentile {high:.3g}, maximum {times.max():.3g}"
    )
    full = f", {found['full']} solved in full" if found["full"] else ""
    click.echo(f"cost {found['cost']:.6g}{full}")
    for reason in found["reasons"]:
        click.echo(f"in full because {reason}")
    if plot is not None:
        click.echo(f"wrote {plot}")
    return Exit.OK


def _replay(
    recording: Recording, model: Any, tolerance: float, max_seconds: float | None
) -> dict[str, Any]:
    """Times of all steps, and what they came to."""
    times: list[float] = []
    reasons: dict[str, None] = {}
    cost, full = 0.0, 0
    began = time.perf_counter()
    for _ in recording.replay(model):
        result = model.update(tolerance=tolerance, max_seconds=max_seconds)
        times.append(1e3 * (time.perf_counter() - began))
        cost, full = result.cost, full + result.full
        if result.full:
            reasons[result.reason] = None
        began = time.perf_counter()
    return {"milliseconds": times, "cost": cost, "full": full, "reasons": list(reasons)}


def _draw(times: list[float], title: str, path: str) -> None:
    # imported here: start-up time
    from arael.plot.figure import save
    from arael.plot.times import times_figure

    save(times_figure(times, title), Path(path))
