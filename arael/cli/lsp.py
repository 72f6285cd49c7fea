"""`arael lsp`: the language server."""

from __future__ import annotations

import importlib.util

import click

from arael.diagnostics.records import AraelError, Diagnostic


@click.command("lsp", short_help="Serve an editor: the language server of models.")
@click.option("--stdio", is_flag=True, help="By standard input and output, as without the option.")
def command(stdio: bool) -> None:
    """Serve an editor by the Language Server Protocol, over standard input and output.

    An editor starts it: see the page "Editors" of the documents.
    """
    if importlib.util.find_spec("pygls") is None:
        raise AraelError(
            Diagnostic(
                "E0869",
                "the language server needs pygls, which is not installed",
                origin="arael lsp",
                help=("pip install 'arael[lsp]'",),
            )
        )
    # imported here: start-up time, and the extra may be absent
    from arael.lsp.server import serve

    serve()
