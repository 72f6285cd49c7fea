"""`arael show`: a picture of what a data file holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

import arael
from arael.cli.data_files import data_options, model_with_data, named
from arael.cli.exits import Exit
from arael.cli.guess import is_sketch, model_and_data
from arael.cli.instances import row_counts
from arael.cli.options import json_option, view_option
from arael.cli.solve import require_picture
from arael.io import formats
from arael.plot.figure import save
from arael.plot.map import Links, Map, Points, View, map_figure
from arael.plot.problem import model_figure
from arael.plot.table import table_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@click.command("show", short_help="Draw what a data file holds.")
@click.argument("arguments", metavar="[MODEL] DATA...", nargs=-1, required=True)
@data_options
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False),
    help="The picture (.png, .pdf, .svg).  [default: name of the file, .png, in this folder]",
)
@view_option
@json_option
def command(
    arguments: tuple[str, ...],
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    output: str | None,
    view: View,
    as_json: bool,
) -> int:
    """Draw DATA, and say what it holds, without solving.

    Graphs, bundle adjustments and the data of a model are drawn as a map of the values in the file,
    or as residuals if nothing in it has a place; trajectories as a path; other tables as columns
    over the first one. The model is found as `arael solve` finds it.
    """
    last = arguments[-1].rpartition("=")[2]
    stem = Path(last.rstrip("/").removesuffix(".gz")).stem
    target = Path(output or f"{stem}.png")
    if len(arguments) == 1 and _is_drawing(last):
        return _show_sketch(last, target, as_json)
    require_picture(str(target))
    drawn = None
    if len(arguments) == 1:
        drawn = _without_model(last, format)
    if drawn is None:
        guess = model_and_data(arguments, format)
        instance = model_with_data(guess, format, collection, fields, information, quiet=as_json)
        layout = type(instance).layout
        counts = {k: n for k, n in row_counts(instance, layout).items() if n}
        held = ", ".join(f"{n} {path}" for path, n in counts.items())
        title = f"{named(guess.data)} ({layout.name})"
        figure = model_figure(instance, layout, view=view, title=title, uncertain=False)
        drawn = held, {"model": guess.model, "rows": counts}, figure
    text, found, figure = drawn
    written = save(figure, target)
    if as_json:
        click.echo(json.dumps({**found, "written": [written]}))
    else:
        click.echo(f"{last}: {text}\nwrote {written}")
    return Exit.OK


def _is_drawing(path: str) -> bool:
    return (
        path.endswith(".json") and Path(path).is_file() and is_sketch(formats.load(path, "json")[0])
    )


def _show_sketch(path: str, target: Path, as_json: bool) -> int:
    # imported here: start-up time
    from arael.sketch import Sketch

    sketch = Sketch()
    sketch.load(path)
    sketch.export(target)
    if as_json:
        click.echo(json.dumps({"format": "sketch", "written": [str(target)]}))
    else:
        click.echo(f"{path}: a sketch\nwrote {target}")
    return Exit.OK


def _without_model(path: str, format: str | None) -> tuple[str, dict[str, Any], Figure] | None:
    """Text, data and figure of a trajectory or a table; None for what has a model's structure."""
    if path.endswith(".arael") or path in ("", "."):
        return None
    _, found = formats.load(path, format)
    name = named([path])
    if found in formats.TRAJECTORIES:
        poses = arael.io.read_trajectory(path, found)
        steps = np.column_stack((np.arange(len(poses) - 1), np.arange(1, len(poses))))
        length = float(np.linalg.norm(np.diff(poses.positions, axis=0), axis=1).sum())
        drawn = Map({"poses": Points(poses.positions)}, (Links("poses", "poses", steps),))
        text = f"{len(poses)} poses ({found}), {length:.4g} m long"
        if poses.times is not None:
            text += f", {poses.times[-1] - poses.times[0]:.4g} s"
        return text, {"format": found, "poses": len(poses)}, map_figure(drawn, name, text)
    if found != "csv":
        return None
    # imported here: start-up time
    from arael.io.csv_numbers import Points as Table

    table = Table(path)
    columns = {}
    for title in table.titles:
        try:
            columns.update(table.columns([title]))
        except arael.AraelError:  # text
            continue
    text = f"{table.size} rows of {', '.join(table.titles)}"
    if not columns:
        return None
    return text, {"format": "csv", "rows": table.size}, table_figure(columns, f"{name}: {text}")
