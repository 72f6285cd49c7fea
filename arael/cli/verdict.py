"""`arael diagnose --verdict` and `--next`: how good a calibration is, and what to measure next."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import click

from arael.cli.exits import Exit
from arael.cli.pages import rendered
from arael.diagnostics.records import AraelError
from arael.io import formats
from arael.io.columns import scalar_names
from arael.io.csv_reader import choose, csv_rows, read
from arael.io.files import shown, write_whole
from arael.io.several import split

F = TypeVar("F", bound=Callable[..., Any])

_KEEPS = 1e-12
"""`min_diagonal` of the solve: parameters without any effect keep their values and are reported."""


def verdict_options(function: F) -> F:
    """Add ``--verdict`` and ``--next``, and the options of both."""
    for option in (
        click.option(
            "--image",
            type=(click.FloatRange(min=1), click.FloatRange(min=1)),
            metavar="WIDTH HEIGHT",
            help="Size of the pictures, for --plot and --report.",
        ),
        click.option(
            "--criterion",
            type=click.Choice(["d", "a"]),
            default="d",
            show_default=True,
            help="What --next lowers: determinant or trace of the covariance.",
        ),
        click.option(
            "--of",
            "wanted",
            multiple=True,
            metavar="NAME",
            help="A parameter whose uncertainty --next lowers.",
        ),
        click.option(
            "--next",
            "candidates",
            type=(click.IntRange(min=1), str),
            metavar="N FILE",
            help="Solve, and choose N of the measurements in a CSV file ([COLLECTION=]FILE).",
        ),
        click.option(
            "--plot",
            type=click.Path(dir_okay=False),
            metavar="FILE",
            help="Draw the uncertainty of projection of a camera (.png, .pdf, .svg).",
        ),
        click.option(
            "--report",
            type=click.Path(),
            metavar="FILE",
            help="Write the verdict as .html, .md or .txt.",
        ),
        click.option(
            "--verdict",
            "judged",
            is_flag=True,
            help="Solve, and judge what the data determines and what is missing.",
        ),
    ):
        function = option(function)
    return function


def solved_kindly(instance: Any, solver: str) -> Any:
    """Solve also where parameters have no effect."""
    return instance.solve(solver=solver, min_diagonal=_KEEPS)


def judge(
    instance: Any,
    result: Any,
    title: str,
    report: str | None,
    plot: str | None,
    image: tuple[float, float] | None,
    as_json: bool,
) -> int:
    """Print the verdict, write its report and its picture; the exit code."""
    found = instance.verdict()
    written = [path for path in (report, plot) if path is not None]
    if plot is not None:
        # imported here: start-up time
        from arael.plot.figure import save
        from arael.plot.projection import projection_figure

        save(projection_figure(instance.projection_uncertainty(image)), Path(plot))
    if report is not None:
        _write(instance, found, result, title, report, image)
    if as_json:
        click.echo(json.dumps({**found.to_dict(), "result": result.to_dict()}))
    else:
        click.echo(f"{_line(result)}\n\n{found}")
        for path in written:
            click.echo(f"wrote {shown(path)}", err=True)
    return Exit.OK if found.good else Exit.NOT_CONVERGED


def choose_next(
    instance: Any,
    count: int,
    argument: str,
    wanted: tuple[str, ...],
    criterion: str,
    as_json: bool,
) -> int:
    """Print which candidates of a CSV file to measure next."""
    # imported here: start-up time
    from arael.analysis.next_data import chosen, measured_columns

    collection, path = split(argument)
    content, found_format = formats.load(path, None)
    if found_format != "csv":
        raise click.UsageError(f"--next takes a CSV file; {shown(path)} is {found_format}")
    trial = instance.copy()
    name = shown(path)
    collection = choose(trial._store, name, collection).layout.path
    header, rows, _ = csv_rows(content, name)
    absent = [
        scalar
        for column in measured_columns(instance, collection)
        for scalar, _ in scalar_names(column)
        if scalar not in header
    ]
    if absent:
        padded = io.StringIO()
        writer = csv.writer(padded)
        writer.writerow([*header, *absent])
        writer.writerows([*row, *["0"] * len(absent)] for row in rows)
        content = padded.getvalue().encode()
    read(trial._store, content, name, collection)
    found = chosen(instance, count, trial, collection, wanted or None, criterion)
    click.echo(json.dumps(found.to_dict()) if as_json else str(found))
    return Exit.OK


def _write(
    instance: Any,
    found: Any,
    result: Any,
    title: str,
    path: str,
    image: tuple[float, float] | None,
) -> None:
    """Write the verdict; the ending chooses the format."""
    ending = path.lower().rpartition(".")[2]
    if ending in ("html", "htm"):
        text = _page(instance, found, result, title, image)
    else:
        lines = [_line(result), "", *str(found).splitlines()]
        if ending == "md":
            lines = [f"# {title}", "", "```text", *lines, "```"]
        else:
            lines = [title, "=" * len(title), "", *lines]
        text = "\n".join(lines) + "\n"
    write_whole(path, lambda file: file.write(text.encode()))


def check_report(path: str) -> None:
    """Reject a report of an unknown format before a long solve."""
    if path.lower().rpartition(".")[2] not in ("html", "htm", "md", "txt"):
        raise click.UsageError(f"--report writes .html, .md or .txt, found '{shown(path)}'")


def _line(result: Any) -> str:
    return str(result).splitlines()[0]


def _page(
    instance: Any, found: Any, result: Any, title: str, image: tuple[float, float] | None
) -> str:
    noise = [(one.label, f"{one.ratio:.3g}", f"{one.freedom:.0f}") for one in found.noise]
    return rendered(
        "verdict.html",
        title=title,
        result=_line(result),
        verdict=found,
        noise=noise,
        figure=_figure(instance, image),
    )


def _figure(instance: Any, image: tuple[float, float] | None) -> str:
    """The picture of a camera calibration as SVG; "" for other models."""
    if find_spec("matplotlib") is None:
        return ""
    try:
        pictures = instance.projection_uncertainty(image)
    except AraelError:
        return ""
    # imported here: start-up time
    from arael.cli.html_report import svg
    from arael.plot.projection import projection_figure

    return svg(projection_figure(pictures))
