"""`arael export`: a model as source code that runs without Python."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from arael.cli.data_files import data_options, read_data
from arael.cli.options import json_option
from arael.exporting.exporter import TARGETS, export
from arael.loading import find_model, load


def _sizes(
    context: click.Context, option: click.Parameter, text: str | None
) -> dict[str, int] | str | None:
    """``poses=10,edges=20`` as a dict."""
    if text is None or text == "data":
        return text
    found = {}
    for part in text.split(","):
        name, sign, number = (word.strip() for word in part.partition("="))
        if not (name and sign and number.isascii() and number.isdecimal()):
            raise click.BadParameter(f"expected NAME=N,... or data, found '{part}'")
        if name in found:
            raise click.BadParameter(f"'{name}' has two sizes")
        found[name] = int(number)
    return found


@click.command("export", short_help="Write a model as C, to run without Python.")
@click.argument("model")
@click.argument("data", nargs=-1)
@click.option("--to", "target", type=click.Choice(TARGETS), default="c", show_default=True)
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(file_okay=False),
    help="Folder of the files. [default: the model's name and the target]",
)
@click.option(
    "--constraint", metavar="NAME", multiple=True, help="Only this one: Pose.gps. May be repeated."
)
@click.option(
    "--size",
    metavar="NAME=N,...",
    callback=_sizes,
    help="Also a whole solver, for at most so many rows; `data`: for the rows and refs of DATA.",
)
@click.option("--precision", type=click.Choice(["f32", "f64"]), help="Overrides that of the root.")
@data_options
@json_option
def command(
    model: str,
    data: tuple[str, ...],
    size: dict[str, int] | str | None,
    target: str,
    output: str | None,
    constraint: tuple[str, ...],
    precision: str | None,
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: Any,
    as_json: bool,
) -> None:
    """Write MODEL as source code that needs no Python.

    c: for each constraint a C99 function of plain arrays for its residuals and derivatives, for
    each entity its retraction and local coordinates, in one header and one source; CMakeLists.txt;
    and main.c, which evaluates the first rows of DATA. With --size also a solver of fixed size, and
    main.c solves the problem of DATA.

    ceres: on these functions, cost functions and manifolds of Ceres and a function that builds a
    problem; main.cpp solves that of DATA.

    gtsam: on these functions, factors of GTSAM on its types of poses and points.

    wasm: a solver of fixed size, for the rows of DATA or of --size, as a WebAssembly module, with a
    loader for JavaScript, types for TypeScript, and a page that solves the problem of DATA.
    """
    instance: Any = None
    if data:
        instance = load(model, interpret=True)()  # type: ignore[call-arg]
        read_data(instance, data, format, collection, fields, information)
    project = export(
        model,
        target,  # type: ignore[arg-type]
        data=instance,
        constraint=constraint or None,
        precision=precision,  # type: ignore[arg-type]
        size=size,  # type: ignore[arg-type]
    )
    folder = output or f"{find_model(model).stem}-{target}"
    paths = project.write(folder)
    if as_json:
        click.echo(json.dumps({"target": target, "files": [str(path) for path in paths]}))
        return
    for path in paths:
        click.echo(f"wrote {path}")
    if project.left_out:
        names = ", ".join(project.left_out)
        click.echo(f"left out, since --size has no rows for what they read: {names}", err=True)
    if target == "wasm":
        click.echo(f"serve it: python3 -m http.server --bind 127.0.0.1 --directory {folder}")
        return
    if "CMakeLists.txt" not in project.files:
        return
    build = Path(folder, "build")
    click.echo(f"build it: cmake -S {folder} -B {build} && cmake --build {build}")
