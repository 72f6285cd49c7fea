"""Options of `arael solve` that say which processes work, for many problems and for parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def cluster_options(function: F) -> F:
    """Add the options of a cluster."""
    path = click.Path(dir_okay=False)
    for option in (
        click.option("--tls-key", type=path, help="Key of this side."),
        click.option("--tls-cert", type=path, help="Certificate of this side."),
        click.option("--tls-ca", type=path, help="Certificate authority of the cluster."),
        click.option(
            "--resume",
            is_flag=True,
            help="Solve only what OUTPUT lacks; with --partition, go on from the checkpoint.",
        ),
        click.option(
            "--scheduler", metavar="ADDRESS", help="Work on this Dask cluster, started before."
        ),
        click.option(
            "--workers",
            type=click.IntRange(min=0),
            metavar="N",
            help="Solve each DATA, or the parts of one, on N processes of this machine.",
        ),
    ):
        function = option(function)
    return function
