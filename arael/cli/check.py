"""`arael check`: all checks that need no solve."""

from __future__ import annotations

import json
import warnings
from typing import TYPE_CHECKING, Any

import click

import arael
from arael.analysis.gradients import check_gradients
from arael.cli.data_files import data_options, joined, read_data
from arael.cli.guess import model_and_data
from arael.cli.instances import row_counts
from arael.compiler.compilation import compile_text
from arael.diagnostics.records import AraelError, Diagnostic
from arael.loading import find_model
from arael.solving import problem_of
from arael.syntax.files import read_source

if TYPE_CHECKING:
    from arael.analysis.gradients import GradientCheck


@click.command("check", short_help="Check a model, and data against it, without solving.")
@click.argument("arguments", metavar="[MODEL] [DATA...]", nargs=-1, required=True)
@data_options
@click.option(
    "--gradients", is_flag=True, help="Compare derivatives with differences, at the values of DATA."
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    arguments: tuple[str, ...],
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    gradients: bool,
    as_json: bool,
) -> None:
    """Check MODEL: syntax, names, shapes, guards, constraints; and DATA against it, if given."""
    guess = model_and_data(arguments, format)
    model, data, collection = guess.model, guess.data, collection or guess.collection
    if gradients and not data:
        raise click.UsageError("--gradients needs DATA: derivatives are compared at its values")
    path = find_model(model)
    layout = compile_text(read_source(path)).layout
    rows: dict[str, int] = {}
    checks: list[GradientCheck] = []
    if data:
        instance = _instance(model)
        read_data(instance, data, format, collection, fields, information)
        instance._store.check_angles()
        rows = row_counts(instance, layout)
        checks = _gradients(instance) if gradients else []
    if not as_json:
        guess.announce()
    if as_json:
        found = {
            "status": "ok",
            "model": str(path),
            "warnings": list(layout.warnings),
            "constraints": [group.label for group in layout.groups],
            "rows": rows,
            "gradients": {check.label: check.difference for check in checks},
        }
        click.echo(json.dumps(found))
        return
    for warning in layout.warnings:
        click.echo(warning, err=True)
    counts = f"{len(layout.tables)} tables, {len(layout.groups)} constraints"
    click.echo(f"{path}: no errors ({counts})")
    if data:
        held = ", ".join(f"{count} {table}" for table, count in rows.items())
        click.echo(f"{joined(data)}: fits the model ({held})")
    for check in checks:
        click.echo(f"{check.label}: derivatives agree to {check.difference:.1e}")


def _instance(model: str) -> Any:
    """An instance to read data into, which checks every value."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", arael.ModelWarning)  # warnings are printed without data too
        return arael.load(model, precision="f64", interpret=True)()  # type: ignore[call-arg]


def _gradients(instance: Any) -> list[GradientCheck]:
    """Compare derivatives with differences.

    Raises
    ------
    AraelError
        E0630 for every constraint whose derivatives do not agree with its residuals.
    """
    checks = check_gradients(problem_of(instance))
    wrong = [
        Diagnostic(
            "E0630",
            f"derivatives of `{check.label}` do not agree with differences",
            origin=check.worst,
            notes=(
                f"residual {check.residual}: the derivative is {check.derivative:.6g}, the "
                f"residual changes by {check.measured:.6g}, with a relative error below "
                f"{check.bound:.1e}",
                *([f"the derivative by `{check.parameter}` differs most"] * bool(check.parameter)),
            ),
            help=("look for a kink or a jump of the formula at these values",),
        )
        for check in checks
        if not check.agrees
    ]
    if wrong:
        raise AraelError(wrong)
    return checks
