"""`arael fmt`: format model files."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from difflib import unified_diff
from pathlib import Path

import click

from arael.cli.exits import Exit
from arael.diagnostics.records import AraelError, Diagnostic
from arael.syntax.files import read_source, source_of
from arael.syntax.fmt import format_source


@click.command("fmt", short_help="Format model files.")
@click.argument("files", nargs=-1, required=True)
@click.option("--check", is_flag=True, help="Write nothing; exit 1 if a file would change.")
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
def command(files: tuple[str, ...], check: bool, diff: bool) -> int:
    """Format model FILES in place; `-` formats standard input to standard output.

    For a folder, all .arael files in and below it are formatted.
    """
    problems: list[Diagnostic] = []
    changed = 0
    for name in _expanded(files):
        try:
            changed += _format(name, check, diff)
        except AraelError as error:
            problems.extend(error.diagnostics)
    if problems:
        raise AraelError(problems)
    return Exit.NOT_CONVERGED if changed and (check or diff) else Exit.OK


def _expanded(files: tuple[str, ...]) -> list[str]:
    out: list[str] = []
    for name in files:
        folder = Path(name)
        if name != "-" and folder.is_dir():
            out.extend(str(p) for p in sorted(folder.rglob("*.arael")))
        else:
            out.append(name)
    return out


def _format(name: str, check: bool, diff: bool) -> bool:
    """Format one file; True if it was, or would be, changed."""
    source = source_of(sys.stdin.buffer.read(), "<stdin>") if name == "-" else read_source(name)
    text, new = source.text, format_source(source)
    if name == "-" and not (check or diff):
        click.echo(new, nl=False)
        return False
    if new == text:
        return False
    if diff:
        _print_diff(name, text, new)
    elif check:
        click.echo(f"would format {name}")
    else:
        _replace(Path(name), new)
        click.echo(f"formatted {name}")
    return True


def _print_diff(name: str, old: str, new: str) -> None:

    lines = unified_diff(
        old.splitlines(keepends=True), new.splitlines(keepends=True), name, f"{name} (formatted)"
    )
    click.echo("".join(lines), nl=False)


def _replace(path: Path, text: str) -> None:
    """Replace a file atomically: after an error the old text is intact."""
    target = path.resolve()
    temporary = None
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", newline="", dir=target.parent, delete=False
        ) as file:
            temporary = file.name
            file.write(text)
        os.chmod(temporary, target.stat().st_mode & 0o7777)
        os.replace(temporary, target)
        temporary = None
    except OSError as error:
        raise AraelError(
            Diagnostic(
                "E0850",
                f"the formatted file cannot be written: {error.strerror}",
                origin=str(path),
                help=("`arael fmt - < FILE` prints the formatted text instead",),
            )
        ) from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
