"""Figures of any solved model: its map, residuals and Hessian, and the history of the solve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from arael.diagnostics.arguments import wrong_argument
from arael.plot.figure import beside, save
from arael.plot.history import history_figure
from arael.plot.map import View, check_view, map_figure, map_of
from arael.plot.residuals import residual_figure, residuals_of
from arael.plot.sparsity import hessian_pattern, sparsity_figure
from arael.runtime.layout import Layout

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.result import Result

What = Literal["auto", "map", "residuals", "hessian"]


def plot_solution(
    instance: Any, layout: Layout, result: Result, path: Path, title: str, view: View = "auto"
) -> list[str]:
    """Draw a solved model into `path` and related files; return their names.

    `path` shows the map, or the residuals of a model without places. Files beside it have the
    residuals, the history of the solve and the pattern of the Hessian.

    Parameters
    ----------
    title : what was solved
    view : of the map
    """
    written = []
    drawn = map_of(instance, layout, uncertain=True)
    outcome = outcome_of(result)
    residuals = residual_figure(residuals_of(instance, layout), f"{title}: {outcome}")
    if drawn is not None:
        written.append(save(map_figure(drawn, title, outcome, view), path))
        written.append(save(residuals, beside(path, "residuals")))
    else:
        written.append(save(residuals, path))
    history = history_figure([(one.name, one.history) for one in result.passes])
    written.append(save(history, beside(path, "cost")))
    jacobian = instance.jacobian()
    pattern = sparsity_figure(*hessian_pattern(jacobian), len(jacobian.names))
    written.append(save(pattern, beside(path, "hessian")))
    return written


def outcome_of(result: Result) -> str:
    """How a solve ended, for a title."""
    ended = result.status.replace("_", " ")
    return f"{ended} after {result.iterations} iterations, cost {result.end_cost:.6g}"


def model_figure(
    instance: Any,
    layout: Layout,
    what: What = "auto",
    view: View = "auto",
    title: str = "",
    uncertain: bool = True,
) -> Figure:
    """The map of a model, its residuals, or the pattern of J'J.

    ``auto`` is the map; of a model without places, or with all of them in one, the residuals, and
    without these the pattern.

    Parameters
    ----------
    uncertain : whether the map has ellipses

    Raises
    ------
    AraelError
        E0828: an unknown `what` or `view`, or a map of a model without places.
    """
    if what not in get_args(What):
        raise wrong_argument("plot", "what", f"one of {', '.join(get_args(What))}", what)
    check_view(view)
    drawn = map_of(instance, layout, uncertain) if what in ("auto", "map") else None
    if drawn is not None and (what == "map" or not drawn.is_a_point):
        return map_figure(drawn, title, view=view)
    if what == "map":
        advice = "residuals or hessian: no row of the model has a place of two or three numbers"
        raise wrong_argument("plot", "what", advice, what)
    if what in ("auto", "residuals"):
        found = residuals_of(instance, layout)
        if found or what == "residuals":
            return residual_figure(found, title)
    jacobian = instance.jacobian()
    return sparsity_figure(*hessian_pattern(jacobian), len(jacobian.names))
