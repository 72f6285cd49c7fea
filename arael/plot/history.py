"""Cost and step control over a solve."""

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
    """Draw cost, and trust region or lambda, over the attempts of each pass and its start.

    Parameters
    ----------
    passes : name and history of each pass: structured arrays with `cost`, `trial_cost`, `damping`
        and `accepted`, and `radius` for trust-region steps (see
        `arael.result.Result`)
    """
    # imported here: start-up time
    from matplotlib.ticker import MaxNLocator

    figure, (costs, damping) = new_figure(11.0, 4.4, columns=2)
    start, names = 0, set()
    for name, records in passes:
        at = start + 1 + np.arange(len(records))
        accepted = records["accepted"].astype(bool)
        cost = np.where(accepted, records["trial_cost"], records["cost"])
        if start:
            for axes in (costs, damping):
                axes.axvline(start - 0.5, color=FAINT, linewidth=1)
        if len(records):  # the cost at the start of the pass, before its first attempt
            whole = np.concatenate((records["cost"][:1], cost))
            costs.plot(start + np.arange(len(whole)), whole, "-", color=BLUE, linewidth=1)
        costs.plot(at[accepted], cost[accepted], "o", color=BLUE, markersize=4)
        costs.plot(at[~accepted], cost[~accepted], "x", color=ORANGE, markersize=6)
        if len(records):
            costs.plot(start, whole[0], "s", color=GREY, markersize=4)
        region = "radius" in (records.dtype.names or ()) and np.isfinite(records["radius"]).any()
        names.add("trust region" if region else "damping")
        limit = records["radius" if region else "damping"]
        damping.plot(at, limit, ".-", color=BLUE, linewidth=1)
        costs.annotate(
            name, (start, 1), xycoords=("data", "axes fraction"), va="top", color=GREY, fontsize=9
        )
        start += len(records) + bool(len(records))
    costs.set_title("cost", color=INK)
    damping.set_title(", ".join(sorted(names)) or "damping", color=INK)
    for axes in (costs, damping):
        axes.set_yscale("log")
        axes.set_xlabel("attempt")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(True)
    return figure
