"""`arael solve` with ``--workers`` or ``--scheduler``: one problem per data file."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from arael.cli.exits import Exit

F = TypeVar("F", bound=Callable[..., Any])

NAMES = ("workers", "scheduler", "time_limit", "resume", "group", "tls_ca", "tls_cert", "tls_key")


def many_options(function: F) -> F:
    """Add the options of many problems, beside those of the cluster."""
    for option in (
        click.option("--group", type=click.IntRange(min=1), help="Problems per task; 1."),
        click.option(
            "--time-limit",
            type=click.FloatRange(min=0, min_open=True),
            help="Seconds of one problem among many.",
        ),
    ):
        function = option(function)
    return function


def is_many(given: dict[str, Any], partitioned: bool) -> bool:
    """Whether the options ask for many problems; a usage error for options that need them."""
    asked = given["workers"] is not None or given["scheduler"] is not None
    own = NAMES if not asked and not partitioned else ("time_limit", "group")
    if asked and not partitioned:
        if given["workers"] == 0:
            raise click.UsageError("--workers 0 is for one problem in parts; add --partition")
        return True
    wrong = [name for name in own if given[name]]
    if wrong:
        option = "--" + wrong[0].replace("_", "-")
        raise click.UsageError(f"{option} is for many problems; add --workers or --scheduler")
    return False


def solve_many(
    kind: Any,
    data: tuple[str, ...],
    settings: dict[str, Any],
    output: str | None,
    as_json: bool,
    given: dict[str, Any],
) -> int:
    """Solve each data file on a cluster; write results and the table of outcomes."""
    # imported here: start-up time, and the extra may be absent
    from arael.display.progress import place_for
    from arael.distributed.cluster import connect, dashboard, require_dask
    from arael.distributed.many import files_of, solve_files
    from arael.distributed.table import write_table
    from arael.distributed.work import Row, Settings

    if given["resume"] and output is None:
        raise click.UsageError("--resume needs the folder of the run: add -o FOLDER")
    require_dask()
    paths = files_of(data)
    rows: list[Row] = []
    interrupted = False
    if output is not None:
        Path(output).mkdir(parents=True, exist_ok=True)
    how = Settings(**settings, time_limit=given["time_limit"])
    tls = {name: given[name] for name in ("tls_ca", "tls_cert", "tls_key")}
    try:
        with connect(given["workers"], given["scheduler"], **tls) as client:
            link = dashboard(client)
            if link and not as_json:
                click.echo(f"dashboard: {link}", err=True)
            show = place_for(not as_json)
            resume, group = given["resume"], given["group"] or 1
            for future in solve_files(kind, paths, how, client, None, output, resume, group, show):
                rows.append(future.result())
    except KeyboardInterrupt:
        interrupted = True
    table = write_table(rows, Path(output)) if output is not None else None
    _print(rows, len(paths), table, interrupted, as_json)
    solved = len(rows) == len(paths) and all(row.converged for row in rows)
    return Exit.OK if solved else Exit.NOT_CONVERGED


def _print(rows: list[Any], count: int, table: Path | None, stopped: bool, as_json: bool) -> None:
    # imported here: start-up time
    import msgspec

    wrong = [row for row in rows if not row.converged]
    if as_json:
        found = {
            "problems": count,
            "converged": len(rows) - len(wrong),
            "interrupted": stopped,
            "rows": [msgspec.to_builtins(row) for row in rows],
            "table": None if table is None else str(table),
        }
        click.echo(json.dumps(msgspec.json.decode(msgspec.json.encode(found))))
        return
    click.echo(f"{len(rows) - len(wrong)} of {count} problems converged")
    for row in sorted(wrong, key=lambda one: str(one.name)):
        said = row.message.splitlines()
        tries = f" (tried {row.attempts} times)" if row.attempts > 1 else ""
        click.echo(f"  {row.name}: {row.status}{tries}" + (f": {said[0]}" if said else ""))
    slow = Counter(row.interpreted for row in rows if row.kernels == "interpreted")
    for why, count in slow.most_common():
        text = f"note: {count} were solved on the expression machine, without kernels: {why}"
        click.echo(text, err=True)
    together = sum(row.together > 1 for row in rows)
    if together:
        click.echo(f"{together} were solved in groups, as components of one problem", err=True)
    for why, count in Counter(row.apart for row in rows if row.apart).most_common():
        click.echo(f"note: {count} of groups were solved one after another: {why}", err=True)
    if stopped:
        click.echo("interrupted: what had ended is kept; --resume solves the rest", err=True)
    if table is not None:
        click.echo(f"wrote {table}")
