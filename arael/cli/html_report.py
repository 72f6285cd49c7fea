"""The result of a solve as a self-contained HTML page."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from arael.cli.pages import rendered
from arael.cli.questions import tables_of
from arael.display.measured import measured
from arael.io.files import write_whole
from arael.plot.history import history_figure
from arael.plot.map import map_figure, map_of
from arael.plot.problem import outcome_of
from arael.plot.residuals import residual_figure, residuals_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.analysis.report import Report
    from arael.cli.solution import Solution
    from arael.result import Result
    from arael.runtime.layout import Layout

_SCALARS = ("parameter", "value", "standard deviation", "unit", "")
_ROWS = 3000
"""Most scalars of a collection that are listed."""
_COUNTS = ("iterations", "accepted", "seconds")
_PASSES = ("pass", "status", "start cost", "end cost", *_COUNTS, "frozen")


def write_report(
    instance: Any,
    layout: Layout,
    result: Result,
    solution: Solution,
    answers: Sequence[Any],
    scale: str,
    title: str,
    path: str,
) -> None:
    """Write a solve as HTML: solution, fit, parameters by collection, costs, timings, figures.

    Raises
    ------
    AraelError
        E0715 if the file cannot be written; an old file is then unchanged.
    """
    details = instance.report(scale)
    notes = dict.fromkeys((*solution.notes, *details.notes))
    text = rendered(
        "report.html",
        title=title,
        result=result,
        scalars=[(s.name, *measured(s.value, s.sigma), s.unit, s.note) for s in solution.scalars],
        scalar_head=_SCALARS,
        notes=[*notes, *(f"Suspicious: {one}" for one in details.findings)],
        tables=[*_tables(instance, result, solution, details), *tables_of(answers)],
        collections=list(_collections(details)),
        figures=[(name, svg(figure)) for name, figure in _figures(instance, layout, result)],
    )
    write_whole(path, lambda file: file.write(text.encode()))


def _tables(
    instance: Any, result: Result, solution: Solution, details: Report
) -> Iterator[tuple[str, Sequence[str], Sequence[Sequence[object]]]]:
    """Title, head and rows of each table after that of the solution."""
    for rows in solution.shown:
        values = [(name, *(_number(v) for v in row)) for name, row in rows.rows]
        yield rows.asked, ("", *rows.head), values
    yield "Fit", ("", ""), list(details.figures())
    if details.correlations:
        pairs = [(a, b, f"{rho:+.4f}") for a, b, rho in details.correlations]
        yield "Correlations above 0.9", ("parameter", "parameter", "correlation"), pairs
    passes = [
        (p.name, p.status, f"{p.start_cost:.6g}", f"{p.end_cost:.6g}", p.iterations,
         p.accepted_iterations, f"{p.seconds:.4f}", ", ".join(p.frozen))
        for p in result.passes
    ]  # fmt: skip
    yield "Passes", _PASSES, passes
    table = instance.cost_table()
    costs = [(label, f"{cost:.6g}", table.instances[label]) for label, cost in table.items()]
    yield "Cost by constraint", ("constraint", "cost", "instances"), costs
    if result.required is not None:
        yield (
            "What holds exactly",
            ("",),
            [(line,) for line in result.required.sentences(result.cost)],
        )
    phases = [(name, f"{seconds:.6f}") for name, seconds in result.timing.items()]
    yield "Time", ("phase", "seconds"), phases


def _collections(details: Report) -> Iterator[tuple[str, Any, Any, str]]:
    """Name, summaries and rows of the parameters of each collection, and what is left out."""
    for path, columns in details.collections.items():
        names = {one.name for column in columns for one in column.estimates}
        rows = [
            (one.name, *measured(one.value, one.sigma), one.unit, one.note)
            for one in details.parameters
            if one.name in names
        ]
        more = f"{len(rows) - _ROWS} more" if len(rows) > _ROWS else ""
        yield path, [(one.name, str(one)) for one in columns], rows[:_ROWS], more


def _number(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _figures(instance: Any, layout: Layout, result: Result) -> Iterable[tuple[str, Figure]]:
    """Return the figures of a solved model; none if matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        return
    drawn = map_of(instance, layout, uncertain=True)
    if drawn is not None:
        yield "Map", map_figure(drawn, layout.name, outcome_of(result))
    yield "Residuals", residual_figure(residuals_of(instance, layout), "whitened residuals")
    yield "Cost and length of steps", history_figure([(p.name, p.history) for p in result.passes])


def svg(figure: Figure) -> str:
    """Return the figure as an SVG element."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]
