"""`arael explain`: the page of a diagnostic code."""

from __future__ import annotations

import click

from arael.diagnostics.explain import codes, explain, title


@click.command("explain", short_help="Explain a diagnostic code.")
@click.argument("code", required=False)
def command(code: str | None) -> None:
    """Explain the diagnostic CODE, such as E0203, with a wrong and a right example.

    Without CODE, list every code with its title.
    """
    if code is not None:
        click.echo(explain(code).rstrip("\n"))
        return
    for known in codes():
        click.echo(title(known))
