"""How cost and damping went over a solve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, GREY, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def history_figure(passes: Sequence[tuple[str, NDArray[Any]]]) -> Figure:
    """Draw cost and lambda over the attempts of each pass, one after the other.

    Parameters
    ----------
    passes : name and history of each pass: structured arrays with `cost`, `trial_cost`, `damping`
        and `accepted` (see `arael.result.Result`)
    """
    figure, (costs, damping) = new_figure(11.0, 4.4, columns=2)
    start = 0
    for name, records in passes:
        at = start + np.arange(len(records))
        accepted = records["accepted"].astype(bool)
        cost = np.where(accepted, records["trial_cost"], records["cost"])
        if start:
            for axes in (costs, damping):
                axes.axvline(start - 0.5, color=FAINT, linewidth=1)
        costs.plot(at, cost, "-", color=BLUE, linewidth=1)
        costs.plot(at[accepted], cost[accepted], "o", color=BLUE, markersize=4)
        costs.plot(at[~accepted], cost[~accepted], "x", color=ORANGE, markersize=6)
        damping.plot(at, records["damping"], ".-", color=BLUE, linewidth=1)
        costs.annotate(
            name, (start, 1), xycoords=("data", "axes fraction"), va="top", color=GREY, fontsize=9
        )
        start += len(records)
    costs.set_title("cost", color=INK)
    damping.set_title("damping", color=INK)
    for axes in (costs, damping):
        axes.set_yscale("log")
        axes.set_xlabel("attempt")
        axes.grid(True)
    return figure
