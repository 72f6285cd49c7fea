"""Options that several commands share."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])

SOLVERS = ("auto", "dense", "band", "sparse", "schur", "schur_pcg", "cholmod", "lapack_band")

STRATEGIES = ("auto", "dogleg", "damped")
"""As `arael.LmConfig.strategy`."""

INITS = ("auto", "file", "tree", "chordal")
"""Copy of `arael.starts.WAYS`, whose import would load NumPy for ``--help``."""


def solver_option(function: F) -> F:
    """Add ``--solver``."""
    return click.option(
        "--solver",
        type=click.Choice(SOLVERS),
        default="auto",
        show_default=True,
        help="Linear solver.",
    )(function)


def precision_option(function: F) -> F:
    """Add ``--precision``."""
    return click.option(
        "--precision", type=click.Choice(["f32", "f64"]), help="Overrides the root's declaration."
    )(function)


def init_option(function: F) -> F:
    """Add ``--init``."""
    return click.option(
        "--init",
        "init",
        type=click.Choice(INITS),
        default="auto",
        show_default=True,
        help="Start values of a pose graph: auto takes those of least cost.",
    )(function)


def strategy_option(function: F) -> F:
    """Add ``--strategy``."""
    return click.option(
        "--strategy",
        type=click.Choice(STRATEGIES),
        help="How steps are chosen, in place of what the model's passes ask for.",
    )(function)


def threads_option(function: F) -> F:
    """Add ``--threads``."""
    return click.option(
        "--threads",
        type=click.IntRange(min=0),
        default=1,
        show_default=True,
        help="Threads of the solve; 0: one per core.",
    )(function)


def json_option(function: F) -> F:
    """Add ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")(function)


VIEWS = ("auto", "xy", "xz", "yz", "3d")
"""Copy of `arael.plot.map.View`, whose import would load NumPy for ``--help``."""

HERE = "(data)"
"""Value of ``--plot`` without a file; no picture has this ending."""


def plot_option(function: F) -> F:
    """Add ``--plot``, whose value may be left out at the end of the command."""
    return click.option(
        "--plot",
        "plot",
        type=click.Path(dir_okay=False),
        is_flag=False,
        flag_value=HERE,
        help="Draw figures into files named after this one (.png, .pdf, .svg); without a name, "
        "after the data.",
    )(function)


def plot_target(plot: str | None, data: str) -> str | None:
    """The file of ``--plot``; without a name it is that of the data, in the current folder."""
    if plot != HERE:
        return plot
    stem = os.path.basename(data.rpartition("=")[2].rstrip("/").removesuffix(".gz"))
    return f"{os.path.splitext(stem)[0]}.png"


def view_option(function: F) -> F:
    """Add ``--view``."""
    return click.option(
        "--view",
        type=click.Choice(VIEWS),
        default="auto",
        show_default=True,
        help="Axes of a map; auto shows most, in space where depth matters.",
    )(function)
