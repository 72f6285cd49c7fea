"""The list of commands; a command's module is imported when it runs, not before."""

from __future__ import annotations

from importlib import import_module

import click

COMMANDS = {
    "solve": "Solve a model on a data file.",
    "show": "Draw what a data file holds.",
    "replay": "Solve a recorded problem row by row.",
    "check": "Check a model, and data against it, without solving.",
    "diagnose": "Explain why a problem does not converge.",
    "convert": "Convert a data file to another format.",
    "metrics": "Errors of a trajectory: ATE and RPE.",
    "fmt": "Format model files.",
    "info": "Show the content of a model: structs, parameters, constraints.",
    "emit": "Print a stage of the compiler.",
    "export": "Write a model as C, to run without Python.",
    "explain": "Explain a diagnostic code.",
    "demo": "Run a demonstration on synthetic data.",
    "cache": "Show or clear the cache of compiled models.",
    "fit": "Fit a formula to the columns of a CSV file.",
    "calc": "Calculate, differentiate and rearrange formulas.",
    "sketch": "Draw and edit parametric sketches.",
    "doctor": "Report on the installation, with advice.",
    "lsp": "Serve an editor: the language server of models.",
    "new": "Write a small model and data to start from.",
}


class LazyGroup(click.Group):
    """Finds commands in `COMMANDS`, each in the module of its name."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, in the order of the help page."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the command of that name; None if there is none."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"arael.cli.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that `args` begin with, or fail with a suggestion."""
        name = args[0]
        if name not in COMMANDS and not name.startswith("-"):
            # imported here: start-up time
            from arael.diagnostics.suggest import closest

            near = closest(name, COMMANDS)
            hint = f", did you mean '{near[0]}'?" if near else ", see `arael --help`"
            raise click.UsageError(f"no command '{name}'{hint}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))
