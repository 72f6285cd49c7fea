"""`arael fit`: a formula and a table of points, without a model file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from arael.cli.exits import Exit
from arael.cli.options import json_option
from arael.cli.summary import plain
from arael.display.measured import measured
from arael.io.plain_numbers import real

if TYPE_CHECKING:
    from arael.fitting.result import Fit


@click.command("fit", short_help="Fit a formula to the columns of a CSV file.")
@click.argument("formula")
@click.argument("data", nargs=-1, required=True)
@click.option("--y", "target", metavar="COLUMN", help="Column that FORMULA predicts.  [default: y]")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="Start value of a parameter.")
@click.option(
    "--bound",
    multiple=True,
    metavar="NAME=LOW:HIGH",
    help="Bounds of a parameter; either may lack.",
)
@click.option("--fix", multiple=True, metavar="NAME=VALUE", help="A parameter that is not fitted.")
@click.option(
    "--sigma", metavar="S", help="Standard deviation of the points: a number or a column."
)
@click.option("--relative-sigma", is_flag=True, help="Only ratios of the --sigma column count.")
@click.option("--loss", metavar="LOSS", help="A robust loss: cauchy(2), huber(1.5), tukey(4).")
@click.option("--group", metavar="COLUMN", help="Parameters of their own for each value of COLUMN.")
@click.option("--shared", metavar="NAMES", help="Parameters that all groups have in common: a,b.")
@click.option("--summary", is_flag=True, help="Print the report: correlations, chi-square, AIC.")
@click.option("--intervals", is_flag=True, help="Intervals by profile likelihood, in the report.")
@click.option(
    "--level",
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    default=0.95,
    show_default=True,
    help="Probability of bands and intervals.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False),
    help="Write points, curve, bands and residuals (.csv), or the results (.json).",
)
@click.option(
    "--plot",
    type=click.Path(dir_okay=False),
    help="Draw curve, bands and residuals (.png, .pdf, .svg).",
)
@click.option("-v", "--verbose", is_flag=True, help="Trace every step on stderr.")
@json_option
def command(
    formula: str,
    data: tuple[str, ...],
    target: str | None,
    start: tuple[str, ...],
    bound: tuple[str, ...],
    fix: tuple[str, ...],
    sigma: str | None,
    relative_sigma: bool,
    loss: str | None,
    group: str | None,
    shared: str | None,
    summary: bool,
    intervals: bool,
    level: float,
    output: str | None,
    plot: str | None,
    verbose: bool,
    as_json: bool,
) -> int:
    """Fit FORMULA to the points in DATA, one or more CSV files.

    For example `arael fit "a * exp(-b * x) + c" points.csv`. Names in FORMULA that are columns of
    DATA are data; all others are parameters, whose starts are found unless --start gives them.
    The column that FORMULA predicts is `y`, that of --y, or that on the left of `v = FORMULA`. A
    FORMULA that contains the column `y` is a residual to minimise, and so is the difference of the
    sides of `0 = FORMULA` or `FORMULA = FORMULA`. Without --sigma the scatter of the points is
    used.
    """
    # imported here: start-up time
    import arael

    _check_targets(output, plot)
    found = arael.fit(
        formula,
        data[0] if len(data) == 1 else list(data),
        y=target,
        sigma=_sigma(sigma),
        absolute_sigma=not relative_sigma,
        start=_values(start, "start"),
        bounds=_bounds(bound),
        fixed=_values(fix, "fix"),
        loss=loss,
        group=group,
        shared=tuple(name.strip() for name in (shared or "").split(",") if name.strip()),
        verbose=verbose,
    )
    written = _write(found, output, plot, level)
    report = summary or intervals
    details = found.report(level if intervals else None) if report or as_json else None
    if as_json:
        assert details is not None
        click.echo(json.dumps(plain({**_outcome(found), **_figures(details)}), indent=2))
    else:
        if details is not None and report:
            click.echo(str(details))
        else:
            _show(found)
        for path in written:
            click.echo(f"wrote {path}")
    if found.skipped and not report and not as_json:
        click.echo(f"note: {found.skipped} points without a value are left out", err=True)
    return Exit.OK if found.converged else Exit.NOT_CONVERGED


def _sigma(text: str | None) -> float | str | None:
    try:
        return None if text is None else real(text)
    except ValueError:
        return text


def _values(items: tuple[str, ...], option: str) -> dict[str, float]:
    found = {}
    for item in items:
        name, _, text = item.partition("=")
        try:
            found[name.strip()] = real(text)
        except ValueError:
            raise click.BadParameter(
                f"expected NAME=NUMBER, found '{item}'", param_hint=f"'--{option}'"
            ) from None
    return found


def _bounds(items: tuple[str, ...]) -> dict[str, tuple[float | None, float | None]]:
    found = {}
    for item in items:
        name, _, text = item.partition("=")
        low, colon, high = text.partition(":")
        try:
            ends = tuple(real(end) if end.strip() else None for end in (low, high))
        except ValueError:
            ends = ()
        if not colon or len(ends) != 2:
            raise click.BadParameter(
                f"expected NAME=LOW:HIGH, found '{item}'", param_hint="'--bound'"
            )
        found[name.strip()] = (ends[0], ends[1])
    return found


def _check_targets(output: str | None, plot: str | None) -> None:
    """Reject output files that cannot be written, before the fit."""
    # imported here: start-up time
    from arael.cli.solve import require_picture, require_writable

    if output is not None and Path(output).suffix.lower() not in (".csv", ".json"):
        # imported here: start-up time
        from arael.fitting.messages import mistake

        raise mistake(
            "E0855",
            "results of a fit are written as .csv or .json",
            f"--output {output}",
            f"for instance {Path(output).with_suffix('.csv').name}",
        )
    require_picture(plot)
    require_writable(output)


def _write(found: Fit, output: str | None, plot: str | None, level: float) -> list[str]:
    """Write the requested files; return their names."""
    written = []
    if output is not None:
        # imported here: start-up time
        from arael.io.files import write_whole

        if output.lower().endswith(".json"):
            text = json.dumps(plain(found.to_dict()), indent=2) + "\n"
        else:
            columns = found.table(level)
            rows = zip(*(column.tolist() for column in columns.values()), strict=True)
            lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
            text = "\n".join(lines) + "\n"
        write_whole(output, lambda file: file.write(text.encode()))
        written.append(output)
    if plot is not None:
        # imported here: start-up time
        from arael.plot.figure import save

        written.append(save(found.plot(level), Path(plot)))
    return written


def _outcome(found: Fit) -> dict[str, Any]:
    of = found.estimates.statistics
    return {
        "status": _status(found),
        "converged": found.converged,
        "predicts": found.formula.predicts,
        "parameters": {
            name: {
                "value": value,
                "sigma": found.sigma[name],
                **({"note": f"on {found.on_bound[name]}"} if name in found.on_bound else {}),
            }
            for name, value in found.parameters.items()
        },
        "points": of.residuals,
        "skipped": found.skipped,
        "cost": of.cost,
        "rms": of.rms,
        "residual_sd": math.sqrt(of.reduced) if of.freedom > 0 else None,
        "iterations": found.result.iterations,
        "starts": found.starts,
    }


def _status(found: Fit) -> str:
    """The status of the solve, unless its last digits were reached after it."""
    return "converged" if found.converged else found.result.status


def _figures(report: Any) -> dict[str, Any]:
    """What the report adds to the outcome."""
    found = report.to_dict()
    known = {
        name: one["interval"] for name, one in found["parameters"].items() if "interval" in one
    }
    kept = (
        "chi_square",
        "reduced_chi_square",
        "degrees_of_freedom",
        "r_squared",
        "aic",
        "bic",
        "correlations",
        "findings",
        "notes",
    )
    return {**{key: found[key] for key in kept}, **({"intervals": known} if known else {})}


def _show(found: Fit) -> None:
    of, scatter = found.estimates.statistics, not found.known
    width = max(map(len, found.names))
    for k, (name, value) in enumerate(found.parameters.items()):
        sigma = found.sigma[name]
        if not found.curve.free[k]:
            text = "(fixed)"
        elif name in found.on_bound:
            text = f"(on {found.on_bound[name]})"
        else:
            text = "+- unknown" if math.isnan(sigma) else f"+- {measured(value, sigma)[1]}"
        click.echo(f"{name:<{width}} = {measured(value, sigma)[0]} {text}")
    unit = "" if scatter else " sigmas"
    texts = [
        f"{_status(found)} after {found.result.iterations} iterations",
        f"{of.residuals} points",
    ]
    texts.append(f"rms {of.rms:.3g}{unit}")
    if of.freedom > 0:
        texts.append(f"residual standard deviation {math.sqrt(of.reduced):.3g}{unit}")
    elif scatter:
        texts.append("as many parameters as points: sigma cannot be estimated")
    click.echo(", ".join(texts))
    for sentence in found.estimates.flat:
        click.echo(sentence)
    if found.formula.predicts is None:
        click.echo("the formula was minimised as a residual: it predicts no column")
