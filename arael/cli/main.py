"""Entry point of the `arael` command."""

from __future__ import annotations

import gc
import os
import sys
import warnings
from collections.abc import Sequence
from typing import TextIO

import click

from arael.cli import streams
from arael.cli.compiling import CompilingLine
from arael.cli.exits import Exit
from arael.cli.failures import report
from arael.cli.lazy import LazyGroup
from arael.compiler import progress
from arael.version import __version__

EPILOG = (
    "Exit codes: 0 solved, 1 not converged, 2 bad input, 3 internal error. "
    "MODEL is the name of a standard model (slam, localization, linear, pose_graph_2d, "
    "pose_graph_3d, bundle_adjustment, plane_slam, sketch) or an .arael file."
)


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="arael %(version)s")
def command() -> None:
    """Nonlinear least squares from readable model files."""


def run(args: Sequence[str]) -> int:
    """Run the command line `args` (without the program's name); return the exit code."""
    before, progress.listener = progress.listener, CompilingLine()
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            return _run(args)
    finally:
        progress.listener = before


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning without a place in arael's source."""
    # imported here: start-up time
    from arael.diagnostics.model_warnings import DataWarning, ModelWarning

    # Those of a model and of data are rendered, with code and place.
    rendered = issubclass(category, (ModelWarning, DataWarning))
    text = str(message) if rendered else f"warning: {message}"
    click.echo(text, err=True)


def _run(args: Sequence[str]) -> int:
    try:
        outcome = command.main(list(args), prog_name="arael", standalone_mode=False)
        sys.stdout.flush()
    except click.UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError" and error.ctx:  # since click 8.2
            try:
                click.echo(error.ctx.get_help())
            except OSError as failure:
                return _reported(failure, False)
            return Exit.BAD_INPUT
        return _reported(error, "--json" in args)
    except click.exceptions.Exit as done:
        return done.exit_code
    except BrokenPipeError:  # the reader of the output has closed it, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return Exit.OK
    except SystemExit:  # click raises this in the same case, and after shell completion
        if "PacifyFlush" in type(sys.stdout).__name__:
            return Exit.OK
        raise
    except BaseException as error:
        return _reported(error, "--json" in args)
    if streams.output_was_lost():
        click.echo("error: cannot write the output: standard output is closed", err=True)
        return Exit.BAD_INPUT
    return outcome if isinstance(outcome, int) else Exit.OK


def _reported(error: BaseException, as_json: bool) -> int:
    """Report an error if possible; return the exit code."""
    try:
        if not streams.is_unwritable(error):
            return report(error, as_json)
    except OSError as failure:
        error = failure
    assert isinstance(error, OSError)
    streams.give_up(error)
    return Exit.BAD_INPUT


def main() -> None:
    """Run the `arael` command and exit the process with its exit code."""
    # A command imports hundreds of modules and reads many rows, none of which is garbage. At the
    # usual threshold of 700 objects the collector takes an eighth of a short solve.
    gc.set_threshold(100_000, 50)
    streams.prepare()
    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
