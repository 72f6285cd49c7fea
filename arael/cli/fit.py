"""`arael fit`: a formula and a table of points; no model file."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from arael.cli.exits import Exit
from arael.cli.options import json_option

if TYPE_CHECKING:
    from arael.model import Model
    from arael.residuals.expression import RuntimeResidual
    from arael.result import Result


@click.command("fit", short_help="Fit a formula to the columns of a CSV file.")
@click.argument("formula")
@click.argument("data")
@click.option("--y", "target", metavar="COLUMN", help="What FORMULA predicts.  [default: y]")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="Where a parameter starts.")
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
    DATA are data; all others are parameters, which start at 1 unless --start says otherwise.
    Without --sigma the scatter of the points is taken for it.
    """
    from arael.io.csv_numbers import read_numbers
    from arael.residuals.face import runtime_model, runtime_residual

    columns = read_numbers(data)
    measured = _target(target, columns, data)
    names = _names(formula)
    starts = _starts(start, [name for name in names if name not in columns], columns)
    read = [name for name in dict.fromkeys([*names, measured]) if name in columns]
    residual = runtime_residual(
        f"(({formula}) - {measured}) / sigma_",
        label="formula",
        parameters=starts,
        data={
            **{name: columns[name] for name in read},
            "sigma_": 1.0 if sigma is None else sigma,
        },
        loss=loss,
    )
    model = runtime_model(residual)
    result = model.solve(rel_precision=1e-10, abs_precision=0.0, max_iters=300, verbose=verbose)
    _show(model, residual, result, sigma is None, as_json)
    return Exit.OK if result.converged else Exit.NOT_CONVERGED


def _target(wanted: str | None, columns: dict[str, Any], data: str) -> str:
    name = wanted or "y"
    if name not in columns:
        raise click.BadParameter(
            f"{data} has no column '{name}'; it has {', '.join(columns)}", param_hint="'--y'"
        )
    return name


def _names(formula: str) -> tuple[str, ...]:
    """Free names of the formula; every mistake in it is told here, with its place in it."""
    from arael import sym

    found = sym.parse(formula)
    return tuple(found.free_vars)


def _starts(
    given: tuple[str, ...], parameters: list[str], columns: dict[str, Any]
) -> dict[str, float]:
    if not parameters:
        raise click.BadParameter(
            f"every name in it is a column ({', '.join(columns)}): there is nothing to fit",
            param_hint="'FORMULA'",
        )
    from arael.io.plain_numbers import real

    starts = dict.fromkeys(parameters, 1.0)
    for item in given:
        name, _, text = item.partition("=")
        if name not in starts:
            raise click.BadParameter(
                f"'{name}' is no parameter of the formula; it has {', '.join(parameters)}",
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
    model: Model, residual: RuntimeResidual, result: Result, scatter: bool, as_json: bool
) -> None:
    count, unknowns = len(residual.residuals), len(residual.parameters)
    rms = (result.end_cost / max(count - unknowns, 1)) ** 0.5
    sigmas = model.covariance().sigma() * (rms if scatter else 1.0)
    found = {
        name: {"value": float(value), "sigma": float(sigma)}
        for (name, value), sigma in zip(residual.parameters.items(), sigmas, strict=True)
    }
    if as_json:
        click.echo(
            json.dumps(
                {
                    "status": result.status,
                    "parameters": found,
                    "points": count,
                    "cost": result.end_cost,
                    "rms": rms,
                    "iterations": result.iterations,
                },
                indent=2,
            )
        )
        return
    width = max(map(len, found))
    for name, one in found.items():
        click.echo(f"{name:<{width}} = {one['value']:.6g} +- {one['sigma']:.2g}")
    click.echo(
        f"{result.status} after {result.iterations} iterations, {count} points, rms {rms:.3g}"
    )
