"""`arael diagnose`: why a problem does not converge, or where its solution is poor."""

from __future__ import annotations

import json

import click

from arael.cli.data_files import data_options, model_with_data, named
from arael.cli.exits import Exit
from arael.cli.guess import model_and_data
from arael.cli.instances import apply_settings
from arael.cli.options import json_option, precision_option, solver_option
from arael.cli.verdict import (
    check_report,
    choose_next,
    judge,
    solved_kindly,
    verdict_options,
)


@click.command("diagnose", short_help="Explain why a problem does not converge.")
@click.argument("arguments", metavar="[MODEL] DATA...", nargs=-1, required=True)
@data_options
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="Set root data.")
@click.option("--solve", "solved", is_flag=True, help="Solve first, and analyse the solution.")
@verdict_options
@solver_option
@precision_option
@json_option
def command(
    arguments: tuple[str, ...],
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    settings: tuple[str, ...],
    solved: bool,
    judged: bool,
    report: str | None,
    plot: str | None,
    candidates: tuple[int, str] | None,
    wanted: tuple[str, ...],
    criterion: str,
    image: tuple[float, float] | None,
    solver: str,
    precision: str | None,
    as_json: bool,
) -> int:
    """Analyse MODEL with DATA: costs, non-finite numbers, free directions, scales, outliers.

    The analysis is at the values in DATA, without solving, or at the solution with --solve. With
    --verdict the solution is judged as a calibration: what determines each parameter, which motion
    or view is missing, what is suspicious. With --next candidates for further measurements are
    chosen. The exit code is 0 if nothing suspicious was found, 1 if something was, 2 for wrong
    input.
    """
    if not judged and (report is not None or plot is not None):
        raise click.UsageError("--report and --plot are of a verdict; add --verdict")
    if report is not None:
        check_report(report)
    if judged and candidates is not None:
        raise click.UsageError("give --verdict or --next")
    if candidates is None and wanted:
        raise click.UsageError("--of is for --next")
    guess = model_and_data(arguments, format)
    if not guess.data:
        raise click.UsageError(f"missing argument 'DATA...': arael diagnose {guess.model} DATA")
    instance = model_with_data(
        guess, format, collection, fields, information, precision, quiet=as_json
    )
    apply_settings(instance, type(instance).layout, settings)
    if judged:
        title = f"verdict on {named([guess.model])} with {named(guess.data)}"
        return judge(instance, solved_kindly(instance, solver), title, report, plot, image, as_json)
    if candidates is not None:
        solved_kindly(instance, solver)
        return choose_next(instance, *candidates, wanted, criterion, as_json)
    result = instance.solve(solver=solver) if solved else None
    found = instance.diagnose()
    if as_json:
        outcome = {} if result is None else {"result": result.to_dict()}
        click.echo(json.dumps({**found.to_dict(), **outcome}))
    else:
        if result is not None:
            click.echo(str(result))
            click.echo("")
        click.echo(str(found))
    suspicious = [f for f in found.findings if solved or f.topic != "not-minimal"]
    return Exit.NOT_CONVERGED if suspicious else Exit.OK
