"""`arael fit`: a formula and a table of points, without a model file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import click

from arael.cli.exits import Exit
from arael.cli.fit_formula import read_formula
from arael.cli.options import json_option
from arael.cli.summary import plain
from arael.io.csv_numbers import Points
from arael.io.plain_numbers import real
from arael.runtime_residuals import runtime_model, runtime_residual

if TYPE_CHECKING:
    from arael.model import Model
    from arael.residuals.expression import RuntimeResidual
    from arael.result import Result


@click.command("fit", short_help="Fit a formula to the columns of a CSV file.")
@click.argument("formula")
@click.argument("data")
@click.option("--y", "target", metavar="COLUMN", help="Column that FORMULA predicts.  [default: y]")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="Start value of a parameter.")
@click.option(
    "--sigma", type=click.FloatRange(min=0, min_open=True), help="Standard deviation of the points."
)
@click.option("--loss", metavar="LOSS", help="A robust loss: cauchy(2), huber(1.5), tukey(4).")
@click.option("-v", "--verbose", is_flag=True, help="Trace every step on stderr.")
@json_option
def command(
    formula: str,
    data: str,
    target: str | None,
    start: tuple[str, ...],
    sigma: float | None,
    loss: str | None,
    verbose: bool,
    as_json: bool,
) -> int:
    """Fit FORMULA to the points in DATA, a CSV file.

    For example `arael fit "a * exp(-b * x) + c" points.csv`. Names in FORMULA that are columns of
    DATA are data; all others are parameters, which start at 1 unless --start gives another value.
    The column that FORMULA predicts is `y`, that of --y, or that on the left of `v = FORMULA`. A
    FORMULA that contains the column `y`, or `0 = FORMULA`, is a residual to minimise. Without
    --sigma the scatter of the points is used.
    """
    points = Points(data)
    found = read_formula(formula, target, points.titles, data)
    starts = _starts(start, found.parameters, points.titles)
    residual = runtime_residual(
        f"({found.residual}) / sigma_",
        label="formula",
        parameters=starts,
        data={**points.columns(found.columns), "sigma_": 1.0 if sigma is None else sigma},
        loss=loss,
    )
    model = runtime_model(residual)
    result = model.solve(rel_precision=1e-12, verbose=verbose)
    _show(model, residual, result, sigma is None, found.predicts, as_json)
    return Exit.OK if result.converged else Exit.NOT_CONVERGED


def _starts(
    given: tuple[str, ...], parameters: Sequence[str], columns: Iterable[str]
) -> dict[str, float]:
    if not parameters:
        raise click.BadParameter(
            f"every name in it is a column ({', '.join(columns)}): there is nothing to fit",
            param_hint="'FORMULA'",
        )

    starts = dict.fromkeys(parameters, 1.0)
    for item in given:
        name, _, text = item.partition("=")
        if name not in starts:
            raise click.BadParameter(
                f"'{name}' is not a parameter of the formula; it has {', '.join(parameters)}",
                param_hint="'--start'",
            )
        try:
            starts[name] = real(text)
        except ValueError:
            raise click.BadParameter(
                f"expected NAME=NUMBER, found '{item}'", param_hint="'--start'"
            ) from None
    return starts


def _show(
    model: Model,
    residual: RuntimeResidual,
    result: Result,
    scatter: bool,
    predicts: str | None,
    as_json: bool,
) -> None:
    count, unknowns = len(residual.residuals), len(residual.parameters)
    rms = (result.end_cost / count) ** 0.5
    # Estimate of one point's sigma, with `unknowns` degrees of freedom subtracted.
    spare = count - unknowns
    deviation = (result.end_cost / spare) ** 0.5 if spare > 0 else math.nan
    sigmas = model.covariance().sigma() * (deviation if scatter else 1.0)
    found = {
        name: {"value": float(value), "sigma": float(sigma)}
        for (name, value), sigma in zip(residual.parameters.items(), sigmas, strict=True)
    }
    if as_json:
        outcome = {
            "status": result.status,
            "predicts": predicts,
            "parameters": found,
            "points": count,
            "cost": result.end_cost,
            "rms": rms,
            "residual_sd": deviation,
            "iterations": result.iterations,
        }
        click.echo(json.dumps(plain(outcome), indent=2))
        return
    width = max(map(len, found))
    for name, one in found.items():
        spread = "unknown" if math.isnan(one["sigma"]) else f"{one['sigma']:.2g}"
        click.echo(f"{name:<{width}} = {one['value']:.6g} +- {spread}")
    unit = "" if scatter else " sigmas"
    texts = [f"{result.status} after {result.iterations} iterations", f"{count} points"]
    texts.append(f"rms {rms:.3g}{unit}")
    if spare > 0:
        texts.append(f"residual standard deviation {deviation:.3g}{unit}")
    elif scatter:
        texts.append("as many parameters as points: sigma cannot be estimated")
    click.echo(", ".join(texts))
    if predicts is None:
        click.echo("the formula was minimised as a residual: it predicts no column")
