"""The result of a solve as a self-contained HTML page."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from html import escape
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from arael.io.files import shown, write_whole
from arael.plot.history import history_figure
from arael.plot.problem import links, map_figure, point_columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.cli.solution import Solution
    from arael.result import Result
    from arael.runtime.layout import Layout

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; color: #22262b;
       padding: 0 1em; }
table { border-collapse: collapse; margin: 0 0 1.5em; }
th, td { padding: .2em 1.2em .2em 0; text-align: right; border-bottom: 1px solid #d5d9df; }
th:first-child, td:first-child { text-align: left; }
h2 { font-size: 1.1em; margin-top: 2em; }
svg { max-width: 100%; height: auto; }
"""


def write_report(
    instance: Any,
    layout: Layout,
    result: Result,
    solution: Solution,
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
    text = "\n".join(_page(instance, layout, result, solution, model, data))
    write_whole(path, lambda file: file.write(text.encode()))


def _page(
    instance: Any, layout: Layout, result: Result, solution: Solution, model: str, data: str
) -> Iterable[str]:
    title = escape(f"{shown(model)} on {shown(data)}")
    yield f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{title}</title>'
    yield f"<style>{_STYLE}</style>\n<h1>{title}</h1>"
    yield (
        f"<p><b>{escape(result.status)}</b>: cost {result.start_cost:.6g} &rarr; "
        f"{result.end_cost:.6g} in {result.iterations} iterations, {result.seconds:.3f} s. "
        f"Linear solver: {escape(str(result.plan))}.</p>"
    )
    yield from _solution(solution)
    rows = [
        (p.name, p.status, f"{p.start_cost:.6g}", f"{p.end_cost:.6g}", p.iterations,
         p.accepted_iterations, f"{p.seconds:.4f}")
        for p in result.passes
    ]  # fmt: skip
    head = ("pass", "status", "start cost", "end cost", "iterations", "accepted", "seconds")
    yield from _table("Passes", head, rows)
    table = instance.cost_table()
    costs = [(label, f"{cost:.6g}", table.instances[label]) for label, cost in table.items()]
    yield from _table("Cost by constraint", ("constraint", "cost", "instances"), costs)
    phases = [(name, f"{seconds:.6f}") for name, seconds in result.timing.items()]
    yield from _table("Time", ("phase", "seconds"), phases)
    for name, figure in _figures(instance, layout, result):
        yield f"<h2>{escape(name)}</h2>\n{_svg(figure)}"


def _solution(solution: Solution) -> Iterable[str]:
    if solution.scalars:
        head = ("parameter", "value", "standard deviation", "unit", "")
        cells = [
            (s.name, _number(s.value, 6), _number(s.sigma, 2), s.unit, s.note)
            for s in solution.scalars
        ]
        yield from _table("Solution", head, cells)
    yield from (f"<p>{escape(note)}</p>" for note in solution.notes)
    for rows in solution.shown:
        values = [(name, *(_number(v, 6) for v in row)) for name, row in rows.rows]
        yield from _table(rows.asked, ("", *rows.head), values)


def _number(value: object, digits: int) -> str:
    if value is None:
        return ""
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def _table(title: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterable[str]:
    yield f"<h2>{escape(title)}</h2>\n<table>"
    yield "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"
    for row in rows:
        yield "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>"
    yield "</table>"


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
