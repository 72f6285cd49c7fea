"""Output of failures: text on stderr, or one JSON object on stdout."""

from __future__ import annotations

import json
import os
import shutil
import sys
import traceback
from collections.abc import Sequence
from typing import Any

import click

from arael.cli.exits import Exit
from arael.diagnostics.records import AraelError, Diagnostic

WRONG_SETTINGS = {"E1010", "E1011", "E1012"}
"""Codes about the settings of a solve, not its outcome."""


def report(error: BaseException, as_json: bool) -> int:
    """Print `error`; return its exit code."""
    if isinstance(error, AraelError):
        show(error.diagnostics, as_json)
        unsolved = all(d.code.startswith("E10") for d in error.diagnostics) and not any(
            d.code in WRONG_SETTINGS for d in error.diagnostics
        )
        return Exit.NOT_CONVERGED if unsolved else Exit.BAD_INPUT
    if isinstance(error, click.ClickException):
        _usage(error, as_json)
        return Exit.BAD_INPUT
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        _plain("interrupted", as_json)
        return Exit.NOT_CONVERGED
    if isinstance(error, MemoryError):
        _plain("out of memory: the problem needs more than this machine has", as_json)
        return Exit.BAD_INPUT
    if isinstance(error, FileNotFoundError) and _current_folder_is_gone():
        _plain("the current folder was removed: change to another (`cd`)", as_json)
        return Exit.BAD_INPUT
    _internal(error, as_json)
    return Exit.INTERNAL


def _current_folder_is_gone() -> bool:
    try:
        os.getcwd()
    except FileNotFoundError:
        return True
    return False


def show(diagnostics: Sequence[Diagnostic], as_json: bool) -> None:
    """Print diagnostics: text on stderr, or one JSON object on stdout."""
    if as_json:
        # imported here: start-up time
        from arael.diagnostics.as_json import as_json as plain

        _print_json(plain(diagnostics))
        return
    print_text(diagnostics)


def print_text(diagnostics: Sequence[Diagnostic]) -> None:
    """Print diagnostics as text on stderr."""
    # imported here: start-up time
    from arael.diagnostics.render import render
    from arael.diagnostics.style import use_color

    width = shutil.get_terminal_size((100, 24)).columns
    text = render(diagnostics, color=use_color(sys.stderr), width=width)
    click.echo(text.rstrip("\n"), err=True, color=True)


def _usage(error: click.ClickException, as_json: bool) -> None:
    if as_json:
        _print_json([_bare("error", error.format_message())])
        return
    context = getattr(error, "ctx", None)
    click.echo(f"error: {_lowered(error.format_message())}", err=True)
    if context is not None:
        click.echo(f"help: `{context.command_path} --help` lists commands and options", err=True)


def _lowered(message: str) -> str:
    message = message.rstrip(".")
    return message[:1].lower() + message[1:]


def _plain(message: str, as_json: bool) -> None:
    if as_json:
        _print_json([_bare("error", message)])
    else:
        click.echo(f"error: {message}", err=True)


def _internal(error: BaseException, as_json: bool) -> None:
    what = f"{type(error).__name__}: {error}"
    if as_json:
        _print_json([_bare("internal error", what)])
    else:
        click.echo(f"internal error: {what}", err=True)
        click.echo(
            "help: this is a defect in arael; please report it with the command, the model and the "
            "output of `arael doctor`",
            err=True,
        )
        if not os.environ.get("ARAEL_DEBUG"):
            click.echo("note: ARAEL_DEBUG=1 shows where it happened", err=True)
    if os.environ.get("ARAEL_DEBUG"):
        traceback.print_exception(error)


def _bare(severity: str, message: str) -> dict[str, Any]:
    return {"severity": severity, "code": "", "message": message}


def _print_json(diagnostics: list[dict[str, Any]]) -> None:
    click.echo(json.dumps({"status": "error", "diagnostics": diagnostics}))
