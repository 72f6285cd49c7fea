"""`arael check`: everything that can be found wrong without solving."""

from __future__ import annotations

import json
from typing import Any

import click


@click.command("check", short_help="Check a model, and data against it, without solving.")
@click.argument("model")
@click.argument("data", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(model: str, data: str | None, as_json: bool) -> None:
    """Check MODEL: syntax, names, shapes, guards, constraints; and DATA against it, if given."""
    from arael.loading import compile_program, find_model

    path = find_model(model)
    layout = compile_program(path, None, None, {})[0].layout
    rows = _rows(model, data) if data is not None else {}
    if as_json:
        found = {
            "status": "ok",
            "model": str(path),
            "warnings": list(layout.warnings),
            "constraints": [group.label for group in layout.groups],
            "rows": rows,
        }
        click.echo(json.dumps(found))
        return
    for warning in layout.warnings:
        click.echo(warning, err=True)
    counts = f"{len(layout.tables)} tables, {len(layout.groups)} constraints"
    click.echo(f"{path}: no errors ({counts})")
    if data is not None:
        held = ", ".join(f"{count} {table}" for table, count in rows.items())
        click.echo(f"{data}: fits the model ({held})")


def _rows(model: str, data: str) -> dict[str, int]:
    """Read `data` into an instance, which checks every value; return the rows of each table."""
    import arael
    from arael.cli.instances import row_counts

    loaded: Any = arael.load(model, interpret=True)
    instance = loaded()
    arael.read(instance, data)
    return row_counts(instance, loaded.layout)
