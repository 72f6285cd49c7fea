"""`arael solve`: a model, a data file, a solution."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import arael
from arael import starts
from arael.cli import summary as outcome
from arael.cli.cluster import cluster_options
from arael.cli.data_files import data_options, named, read_data
from arael.cli.exits import Exit
from arael.cli.guess import model_and_data
from arael.cli.instances import apply_settings
from arael.cli.many import is_many, many_options, solve_many
from arael.cli.options import (
    init_option,
    json_option,
    plot_option,
    plot_target,
    precision_option,
    solver_option,
    strategy_option,
    threads_option,
    view_option,
)
from arael.cli.partition import Partition, check_partition, partition_options, solve_columns
from arael.cli.questions import Questions, as_dict, lines_of, question_options
from arael.cli.solution import check_shown, solution_of
from arael.diagnostics.records import AraelError, Diagnostic
from arael.io import formats

if TYPE_CHECKING:
    from arael.plot.map import View
    from arael.runtime.layout import Layout

EXAMPLES = """\
Three commands to try:

  arael demo slam --plot       solve a map with wrong associations, and draw it
  arael new line               write line.arael and line.json, a small model to change
  arael solve line.json        solve it; the model beside the data is found

Data of others: arael solve graph.g2o, or bundle.txt of BAL. Options: `arael solve --help`."""


@click.command("solve", short_help="Solve a model on a data file.")
@click.argument("arguments", metavar="[MODEL] DATA...", nargs=-1)
@click.option("-o", "--output", type=click.Path(), help="Write the solved data here.")
@data_options
@click.option(
    "--output-format",
    type=click.Choice([f for f in formats.FORMATS if f not in formats.READ_ONLY]),
    metavar="FORMAT",
    help="Format of the output, in place of the one of its ending.",
)
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="Set root data.")
@click.option("--pass", "passes", multiple=True, metavar="NAME", help="Run this pass only.")
@init_option
@solver_option
@strategy_option
@precision_option
@threads_option
@click.option(
    "--max-iters", type=click.IntRange(min=1), help="Maximum of attempted steps per pass."
)
@cluster_options
@partition_options
@click.option("--interpret", is_flag=True, help="Run on the expression machine.")
@click.option("--compiled", is_flag=True, help="Fail if kernels cannot be compiled.")
@click.option("-v", "--verbose", is_flag=True, help="Trace every step on stderr.")
@click.option(
    "--covariance", type=click.Path(dir_okay=False), help="Write sigmas here (.npz, .json)."
)
@click.option(
    "--show",
    "shown",
    multiple=True,
    metavar="NAME[FROM:TO]",
    help="Show solved rows of this collection; the first 5 without a range.",
)
@click.option("--summary", is_flag=True, help="Print a report: errors, correlations, chi-square.")
@click.option(
    "--scale",
    type=click.Choice(["known", "residual"]),
    default="known",
    show_default=True,
    help="Standard errors for whitened residuals, or scaled by their scatter; with --summary.",
)
@question_options
@plot_option
@view_option
@click.option(
    "--report",
    type=click.Path(dir_okay=False),
    help="Write a report on the solve (.html, .md, .txt).",
)
@many_options
@json_option
def command(
    arguments: tuple[str, ...],
    output: str | None,
    output_format: str | None,
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    settings: tuple[str, ...],
    passes: tuple[str, ...],
    init: str,
    solver: str,
    strategy: str | None,
    precision: str | None,
    threads: int,
    max_iters: int | None,
    partition: int | None,
    partition_by: str | None,
    checkpoint: str | None,
    interpret: bool,
    compiled: bool,
    verbose: bool,
    covariance: str | None,
    shown: tuple[str, ...],
    summary: bool,
    scale: str,
    sensitivity: tuple[str, ...],
    uncertain: tuple[str, ...],
    certify: bool,
    escape: bool,
    plot: str | None,
    view: View,
    report: str | None,
    as_json: bool,
    **cluster: Any,
) -> int:
    """Solve MODEL on DATA with the passes of the model.

    MODEL is the name of a standard model or an .arael file; without it the model is found by the
    data: an .arael file of the same name beside it, or a standard model by tags or columns. DATA is
    one file (JSON, NPZ, HDF5, CSV, Parquet, Arrow, g2o, TORO, BAL, Bundler, COLMAP, TUM, KITTI,
    EuRoC), or several of one collection each: poses.csv fills `poses`, scans=day2.csv fills
    `scans`. The exit code is 0 if
    every pass converged, 1 if not, 2 for wrong input. Ctrl-C ends the solve; the best state found
    is still reported and written.

    With --workers or --scheduler each DATA file, or file of a quoted pattern, is a problem of its
    own, and OUTPUT a folder of results and a table; with --partition it is one problem in parts.
    """
    if not arguments:
        click.echo(EXAMPLES)
        return Exit.BAD_INPUT
    guess = model_and_data(arguments, format)
    model, data, collection = guess.model, guess.data, collection or guess.collection
    if not data:
        raise click.UsageError(f"missing argument 'DATA...': arael solve {model} DATA")
    if not as_json:
        guess.announce()
    plot = plot_target(plot, data[-1])
    parts = Partition(
        partition,
        partition_by,
        cluster["scheduler"],
        cluster["workers"],
        checkpoint,
        cluster["resume"],
    )
    if is_many(cluster, parts.wanted):
        wrong = [
            name
            for name, value in (
                ("--set", settings),
                ("--covariance", covariance),
                ("--plot", plot),
                ("--report", report),
                ("--show", shown),
                ("--summary", summary),
                ("--sensitivity", sensitivity),
                ("--uncertain", uncertain),
                ("--certify", certify),
                ("--escape", escape),
                ("--output-format", output_format),
                ("--init", init not in ("auto", "file")),
            )
            if value
        ]
        if wrong:
            raise click.UsageError(f"{wrong[0]} is for one problem, without --workers")
        kind: Any = arael.load(
            model,
            precision=precision,  # type: ignore[arg-type]
            interpret=_check_kernels(interpret, compiled),
        )
        options: dict[str, Any] = {
            "solver": solver,
            "passes": list(passes) or None,
            "num_threads": threads,
            **({} if max_iters is None else {"max_iters": max_iters}),
            **({} if strategy is None else {"strategy": strategy}),
        }
        reading = {
            "format": format,
            "collection": collection,
            "fields": fields,
            "information": information,
        }
        return solve_many(kind, data, {**reading, "options": options}, output, as_json, cluster)
    if output is not None and Path(output).is_dir():
        raise click.BadParameter(f"File '{output}' is a directory.", param_hint="'-o' / '--output'")
    _check_targets(output, covariance, plot, report)
    questions = Questions.of(sensitivity, uncertain, certify or escape)
    kernels = _check_kernels(interpret, compiled)
    _note_threads(threads)
    asked = {
        "--sensitivity": sensitivity,
        "--uncertain": uncertain,
        "--certify": certify,
        "--escape": escape,
    }
    check_partition(parts, {"--solver": solver != "auto", **asked})
    loaded: Any = arael.load(model, precision=precision, interpret=kernels)  # type: ignore[arg-type]
    if parts.wanted and len(data) == 1 and _in_columns(data[0], format):
        unused = {
            "--set": settings,
            "--covariance": covariance,
            "--show": shown,
            "--summary": summary,
            "--plot": plot,
            "--report": report,
            "--init": init not in ("auto", "file"),
        }
        check_partition(parts, unused)
        chosen = _loop_settings(strategy, passes, max_iters, verbose)
        return solve_columns(loaded, data[0], parts, chosen, output, (model, data[0]), as_json)
    instance = loaded()
    read_data(instance, data, format, collection, fields, information)
    apply_settings(instance, loaded.layout, settings)
    check_shown(shown, loaded.layout)
    target = _Target(output, output_format, collection, fields)
    note = _check_writable_format(instance, loaded.layout, target)

    start = _initialise(instance, init)
    if start is not None and not as_json:
        click.echo(str(start), err=True)
    if parts.wanted:
        # imported here: start-up time
        from arael.distributed import solve

        chosen = _loop_settings(strategy, passes, max_iters, verbose)
        result = solve(instance, **parts.options(), **chosen).result
    else:
        result = run(instance, solver, strategy, passes, threads, max_iters, verbose, as_json)
        if escape and not result.certificate.certified:
            if not as_json:
                click.echo(f"{result.certificate.sentence}; leaving it", err=True)
            result = result.escape(solver=solver, passes=list(passes) or None)
    solution = solution_of(instance, loaded.layout, shown)
    details = instance.report(scale) if summary else None
    answers = questions.answers(result, scale)
    if not as_json:
        click.echo(str(result))
        for text in solution.lines():
            click.echo(text)
        if details is not None:
            click.echo(str(details))
        for text in lines_of(answers):
            click.echo(text)
        if result.status == "aborted":
            click.echo("interrupted: this is the best state found so far", err=True)
    if note:
        click.echo(f"note: {note}", err=True)
    written = _write_all(instance, loaded.layout, result, target, covariance)
    if plot is not None:
        # imported here: start-up time
        from arael.plot.problem import plot_solution

        title = f"{loaded.layout.name} on {named(data)}"
        written += plot_solution(instance, loaded.layout, result, Path(plot), title, view)
    if report is not None:
        _write_report(
            instance,
            loaded.layout,
            result,
            solution,
            answers,
            scale,
            f"{named([model])} on {named(data)}",
            report,
        )
        written.append(report)
    if as_json:
        found = {
            "model": model,
            "data": data[0] if len(data) == 1 else list(data),
            **({} if start is None else {"init": outcome.plain(start.to_dict())}),
            **outcome.as_dict(result),
            **_with_notes(solution.as_dict(), result),
            **({} if details is None else {"report": outcome.plain(details.to_dict())}),
            **as_dict(answers),
            "written": written,
        }
        click.echo(json.dumps(found))
    else:
        for path in written:
            click.echo(f"wrote {path}")
    return Exit.OK if outcome.has_converged(result) else Exit.NOT_CONVERGED


def _with_notes(found: dict[str, Any], result: Any) -> dict[str, Any]:
    """What the JSON has of a solution, with the notes of the solve before its own."""
    return {**found, "notes": [*map(str, result.notes), *found["notes"]]}


def _in_columns(path: str, format: str | None) -> bool:
    """Whether each part can read its rows of a data set."""
    return format in (None, "npz") and (os.path.isdir(path) or path.endswith(".npz"))


def _loop_settings(
    strategy: str | None, passes: tuple[str, ...], max_iters: int | None, verbose: bool
) -> dict[str, Any]:
    """Settings of the loop that were given."""
    given = {"strategy": strategy, "max_iters": max_iters, "passes": list(passes) or None}
    return {"verbose": verbose, **{k: v for k, v in given.items() if v is not None}}


def _initialise(instance: Any, init: str) -> Any:
    """Set the initial values of a pose graph; None if those of the file are used unconditionally.

    Raises
    ------
    AraelError
        E0843 if the requested start does not exist for the model; E0844 a singular chordal start.
    """
    if init == "file" or (init == "auto" and not starts.can_initialise(instance)):
        return None
    return starts.initialise(instance, init)  # type: ignore[arg-type]


def run(
    instance: Any,
    solver: str,
    strategy: str | None,
    passes: tuple[str, ...],
    threads: int,
    max_iters: int | None,
    verbose: bool,
    as_json: bool,
) -> Any:
    """Solve `instance`, with a progress line on a terminal."""
    progress = not verbose and not as_json
    options: dict[str, Any] = {"verbose": verbose, "num_threads": threads, "progress": progress}
    if max_iters is not None:
        options["max_iters"] = max_iters
    if strategy is not None:
        options["strategy"] = strategy
    # Single settings override those of the model's passes.
    return instance.solve(solver=solver, passes=list(passes) or None, **options)


def require_writable(path: str | None) -> None:
    """Check before the solve that its result can be written.

    Raises
    ------
    AraelError
        E0853
    """
    if path is None:
        return
    folder = Path(path).resolve().parent
    if not folder.is_dir():
        why, advice = "its folder does not exist", f"create it: mkdir -p '{folder}'"
    elif Path(path).exists() and not os.access(path, os.W_OK):
        why, advice = "the file exists and is read-only", "choose another file"
    elif not os.access(folder, os.W_OK):
        why, advice = "its folder cannot be written", "choose another folder"
    else:
        return
    raise AraelError(
        Diagnostic("E0853", f"cannot write the result: {why}", origin=path, help=(advice,))
    )


def require_picture(path: str | None) -> None:
    """Check before a solve that its picture can be drawn and written.

    Raises
    ------
    AraelError
        E0853; E0860 without matplotlib, E0861 for what is no format of pictures.
    """
    if path is None:
        return
    # imported here: start-up time
    from arael.plot.figure import check_format, require_matplotlib

    require_matplotlib()
    check_format(Path(path))
    require_writable(path)


def _check_kernels(interpret: bool, compiled: bool) -> bool | None:
    """Whether to interpret: as asked, or None to decide by the compiler; E0851 for both."""
    if interpret and compiled:
        raise AraelError(
            Diagnostic(
                "E0851",
                "`--interpret` and `--compiled` exclude each other",
                origin="command line",
                help=("give one of them, or neither: kernels are compiled where that is possible",),
            )
        )
    return True if interpret else False if compiled else None


def _note_threads(threads: int) -> None:
    """Report on stderr if a solve uses fewer threads than asked for."""
    # imported here: start-up time
    from arael.runtime.parallel.compiled import threads_for

    used = threads_for(threads)
    if used < threads:
        click.echo(
            f"note: {used} thread{'s are' if used > 1 else ' is'} the most that a solve uses, "
            f"{threads} were asked for; `--threads 0` takes one per core",
            err=True,
        )


REPORTS = (".html", ".htm", ".md", ".txt")


def _check_report(path: str) -> None:
    """Reject a report of an unknown format; E0858."""
    if Path(path).suffix.lower() not in REPORTS:
        raise AraelError(
            Diagnostic(
                "E0858",
                "reports are written as .html, .md or .txt",
                origin=f"--report {path}",
                help=(f"for instance {Path(path).with_suffix('.html').name}",),
            )
        )


def _write_report(
    instance: Any,
    layout: Layout,
    result: Any,
    solution: Any,
    answers: list[Any],
    scale: str,
    title: str,
    path: str,
) -> None:
    """Write the report in the format that the ending of its name gives."""
    ending = Path(path).suffix.lower()
    # imported here: start-up time
    if ending in (".md", ".txt"):
        from arael.cli.text_report import write_text_report

        markdown = ending == ".md"
        write_text_report(instance, result, solution, answers, scale, title, path, markdown)
        return
    from arael.cli.html_report import write_report

    write_report(instance, layout, result, solution, answers, scale, title, path)


def _check_targets(
    output: str | None, covariance: str | None, plot: str | None, report: str | None
) -> None:
    """Reject output files that cannot be written, before the solve."""
    if covariance is not None:
        # imported here: start-up time
        from arael.cli.marginals import check_ending

        check_ending(covariance)
    if report is not None:
        _check_report(report)
    require_picture(plot)
    for path in (output, covariance, report):
        require_writable(path)


@dataclass(frozen=True)
class _Target:
    """The file for the solved data; `collection` and `fields` are those of trajectories."""

    path: str | None
    format: str | None
    collection: str | None
    fields: dict[str, str] | None

    @property
    def kind(self) -> str:
        """The name of the format."""
        return self.format or formats.format_of(self.path or "", b"")

    def write(self, instance: Any, path: str | Path) -> None:
        """Write the solved data."""
        poses = self.kind in formats.TRAJECTORIES
        arael.write(
            instance,
            path,
            self.format,
            collection=self.collection if poses else None,
            fields=self.fields if poses else None,
        )


def _check_writable_format(instance: Any, layout: Layout, target: _Target) -> str:
    """Check before the solve that the output's format can hold the model's data.

    Returns
    -------
    A note on the values that the file will not hold, or "".
    """
    output = target.path
    if output is None or target.kind in ("json", "npz"):
        return ""

    # imported here: start-up time
    from arael.cli.csv_loss import check_csv_output, note_of_trajectory

    if target.kind == "g2o":  # twice the text of a large graph would take as long as its solve
        # imported here: start-up time
        from arael.io import g2o

        g2o.check(instance._store, output)
        return ""
    note = ""
    if target.kind in formats.TRAJECTORIES:
        note = note_of_trajectory(instance, layout, output, target.collection, target.fields)
    elif target.kind in formats.ONE_COLLECTION:
        note = check_csv_output(instance, layout, output, target.kind)

    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        try:
            with warnings.catch_warnings(action="ignore"):  # the output itself warns
                target.write(instance, Path(folder) / Path(output).name)
        except AraelError as error:
            beside = str(Path(output).parent)
            found = (
                replace(d, origin=d.origin.replace(folder, beside).removeprefix("./"))
                for d in error.diagnostics
            )
            raise AraelError(found) from None
    return note


def _write_all(
    instance: Any,
    layout: Layout,
    result: Any,
    output: _Target,
    covariance: str | None,
) -> list[str]:
    """Write solved data and covariances; return their names."""
    written: list[str] = []
    if output.path is not None:
        output.write(instance, output.path)
        written.append(output.path)
    if covariance is not None:
        # imported here: start-up time
        from arael.cli.marginals import write_marginals

        write_marginals(instance, len(result.x), covariance)
        written.append(covariance)
    return written
