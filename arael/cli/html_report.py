"""The result of a solve as a self-contained HTML page."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arael.cli.questions import tables_of
from arael.display.measured import measured
from arael.io.files import shown, write_whole
from arael.plot.history import history_figure
from arael.plot.problem import links, map_figure, point_columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.cli.solution import Solution
    from arael.result import Result
    from arael.runtime.layout import Layout

_PAGE = Path(__file__).with_name("report.html")
_SCALARS = ("parameter", "value", "standard deviation", "unit", "")
_COUNTS = ("iterations", "accepted", "seconds")
_PASSES = ("pass", "status", "start cost", "end cost", *_COUNTS, "frozen")


def write_report(
    instance: Any,
    layout: Layout,
    result: Result,
    solution: Solution,
    answers: Sequence[Any],
    model: str,
    data: str,
    path: str,
) -> None:
    """Write solution, passes, cost by constraint, timings and figures of a solve as HTML.

    Raises
    ------
    AraelError
        E0715 if the file cannot be written; an old file is then unchanged.
    """
    # imported here: start-up time
    from jinja2 import Environment, StrictUndefined

    page = Environment(autoescape=True, undefined=StrictUndefined).from_string(
        _PAGE.read_text(encoding="utf-8")
    )
    text = page.render(
        title=f"{shown(model)} on {shown(data)}",
        result=result,
        scalars=[(s.name, *measured(s.value, s.sigma), s.unit, s.note) for s in solution.scalars],
        scalar_head=_SCALARS,
        notes=solution.notes,
        tables=[*_tables(instance, result, solution), *tables_of(answers)],
        figures=[(name, _svg(figure)) for name, figure in _figures(instance, layout, result)],
    )
    write_whole(path, lambda file: file.write(text.encode()))


def _tables(
    instance: Any, result: Result, solution: Solution
) -> Iterator[tuple[str, Sequence[str], Sequence[Sequence[object]]]]:
    """Title, head and rows of each table after that of the solution."""
    for rows in solution.shown:
        values = [(name, *(_number(v) for v in row)) for name, row in rows.rows]
        yield rows.asked, ("", *rows.head), values
    passes = [
        (p.name, p.status, f"{p.start_cost:.6g}", f"{p.end_cost:.6g}", p.iterations,
         p.accepted_iterations, f"{p.seconds:.4f}", ", ".join(p.frozen))
        for p in result.passes
    ]  # fmt: skip
    yield "Passes", _PASSES, passes
    table = instance.cost_table()
    costs = [(label, f"{cost:.6g}", table.instances[label]) for label, cost in table.items()]
    yield "Cost by constraint", ("constraint", "cost", "instances"), costs
    phases = [(name, f"{seconds:.6f}") for name, seconds in result.timing.items()]
    yield "Time", ("phase", "seconds"), phases


def _number(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _figures(instance: Any, layout: Layout, result: Result) -> Iterable[tuple[str, Figure]]:
    """Return the figures of a solved model; none if matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        return

    yield "Cost and length of steps", history_figure([(p.name, p.history) for p in result.passes])
    points = point_columns(instance, layout)
    if points:
        yield "Solution from above", map_figure(points, links(instance, layout))


def _svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]
