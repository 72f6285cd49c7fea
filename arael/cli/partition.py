"""`arael solve --partition`: one problem in parts on a cluster."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from arael.cli import summary as outcome
from arael.cli.exits import Exit
from arael.diagnostics.records import AraelError, Diagnostic

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class Partition:
    """How a problem is to be solved in parts; see `arael.distributed.solve`."""

    partition: int | None
    partition_by: str | None
    scheduler: str | None
    workers: int | None
    checkpoint: str | None
    resume: bool

    @property
    def wanted(self) -> bool:
        """Whether the problem is to be split at all."""
        return self.partition is not None or self.partition_by is not None

    def options(self) -> dict[str, Any]:
        """As arguments of `arael.distributed.solve`."""
        return {
            "partition": self.partition,
            "partition_by": self.partition_by,
            "scheduler": self.scheduler,
            "workers": self.workers,
            "checkpoint": self.checkpoint,
            "resume": self.resume,
        }


def partition_options(function: F) -> F:
    """Add the options of a solve in parts."""
    for option in reversed(
        (
            click.option(
                "--partition",
                type=click.IntRange(min=1),
                metavar="N",
                help="Solve in N parts on a Dask cluster.",
            ),
            click.option(
                "--partition-by",
                metavar="COLUMN",
                help="Solve in parts by a column of collections with parameters.",
            ),
            click.option(
                "--checkpoint",
                type=click.Path(dir_okay=False),
                help="Write the state here after each accepted step; with --partition.",
            ),
        )
    ):
        function = option(function)
    return function


def check_partition(chosen: Partition, refused: dict[str, Any]) -> None:
    """Check that the options of a solve in parts go together.

    Parameters
    ----------
    refused : options that have no meaning in parts, by name

    Raises
    ------
    AraelError
        E0851 options that exclude each other or need another.
    """
    why = help_ = ""
    if not chosen.wanted and chosen.checkpoint is not None:
        why, help_ = "`--checkpoint` needs `--partition`", "for instance `--partition 4`"
    elif chosen.resume and chosen.checkpoint is None:
        why, help_ = "`--resume` needs `--checkpoint`", "name the file with `--checkpoint FILE`"
    elif chosen.wanted:
        given = [name for name, value in refused.items() if value]
        if given:
            why = f"`{given[0]}` and `--partition` exclude each other"
            help_ = f"leave `{given[0]}` out, or solve on one machine"
    if why:
        raise AraelError(Diagnostic("E0851", why, origin="command line", help=(help_,)))


def solve_columns(
    loaded: Any,
    data: str,
    chosen: Partition,
    settings: dict[str, Any],
    output: str | None,
    names: tuple[str, str],
    as_json: bool,
) -> int:
    """Solve a data set that no process reads whole; the output has the parameters only."""
    # imported here: start-up time
    from arael.distributed import solve

    if output is not None and not output.endswith(".npz"):
        raise AraelError(
            Diagnostic(
                "E0853",
                "parameters of a solve in parts are written as .npz",
                origin=output,
                help=(f"for instance {output.rpartition('.')[0] or output}.npz",),
            )
        )
    found = solve(loaded, data, **chosen.options(), **settings)
    written = []
    if output is not None:
        found.write(output)
        written.append(output)
    if as_json:
        click.echo(
            json.dumps(
                {
                    "model": names[0],
                    "data": names[1],
                    **outcome.as_dict(found.result),
                    "written": written,
                }
            )
        )
    else:
        click.echo(str(found.result))
        for path in written:
            click.echo(f"wrote {path}")
    return Exit.OK if outcome.has_converged(found.result) else Exit.NOT_CONVERGED
