"""`arael calc`: a calculator similar to bc, with derivatives."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator
from typing import Any

import click

from arael.calculator.calculator import Calculator
from arael.cli.exits import Exit
from arael.cli.failures import print_text
from arael.cli.line_editing import line_editing
from arael.diagnostics.as_json import as_json
from arael.diagnostics.records import AraelError, Diagnostic
from arael.syntax.limits import MAX_BYTES

_HELP = """\
  1 + 2 * sin(pi / 6)     numbers, and the functions of models
  x = 3                   a variable; without a value it stays a symbol
  f(a, b) = a^2 + b       a function; it may shadow a built-in one
  diff(x^2 * y, x)        derivative; diff(f, x, 2) for the second
  expand(f)  collect(f, x)  simplify(f)  subs(f, x, 1 + y)  jacobian([f, g], [x, y])
  latex(f)  python(f)  c(f)
  ans                     the last result
  vars  functions         what is defined
  quit                    leave, as end of input does
"""


@click.command(
    "calc",
    short_help="Calculate, differentiate and rearrange formulas.",
    context_settings={"ignore_unknown_options": True, "help_option_names": ["--help"]},
)
@click.argument("formulas", nargs=-1, type=click.UNPROCESSED)
@click.option(
    "--digits",
    type=click.IntRange(1, 17),
    default=15,
    show_default=True,
    help="Significant digits of numbers.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object per result.")
@click.option("--interactive", is_flag=True, help="Open the prompt after FORMULAS.")
def command(formulas: tuple[str, ...], digits: int, as_json: bool, interactive: bool) -> int:
    """Evaluate FORMULAS, or the lines of standard input, or open a prompt on a terminal.

    Formulas are those of models: `arael calc "diff(x^2, x)"`. `name = formula` and
    `f(x) = formula` define variables and functions; `;` separates statements, `#` begins a comment.
    """
    session = _Session(Calculator(digits), as_json)
    if formulas:
        session.run((f"formula {i}" if len(formulas) > 1 else "formula", 1, text)
                    for i, text in enumerate(formulas, 1))  # fmt: skip
    closed = sys.stdin is None  # closed, as after `<&-`
    if not closed and (interactive or (not formulas and sys.stdin.isatty())):
        session.ask()
    elif not closed and not formulas:
        session.run(_lines())
    return Exit.BAD_INPUT if session.failed and not interactive else Exit.OK


def _lines() -> Iterator[tuple[str, int, str]]:
    """Read the lines of standard input, each with the name of where it is from and its number."""
    number = 0
    while line := sys.stdin.readline(MAX_BYTES + 2):
        number += 1
        yield "<stdin>", number, line.rstrip("\n")


class _Session:
    """A calculator and the output of its results."""

    def __init__(self, calculator: Calculator, as_json: bool) -> None:
        self.calculator = calculator
        self.as_json = as_json
        self.failed = False

    def run(self, lines: Iterable[tuple[str, int, str]]) -> None:
        """Evaluate lines up to `quit`."""
        for name, number, line in lines:
            if not self.line(line, name, number):
                break

    def ask(self) -> None:
        """Read lines from the terminal until its end."""
        click.echo("arael calc: `help` lists functions and commands, `quit` leaves", err=True)
        with line_editing(self.calculator.names):
            while True:
                try:
                    line = input("> ")
                except KeyboardInterrupt:
                    click.echo()
                    continue
                except EOFError:
                    click.echo()
                    break
                if not self.line(line, "input"):
                    break
        self.failed = False

    def line(self, line: str, name: str, number: int = 1) -> bool:
        """Evaluate one line and show its result; False for `quit`."""
        word = line.strip()
        if word in ("quit", "exit"):
            return False
        if word in ("help", "vars", "functions") and word not in self.calculator.variables:
            click.echo(self._info(word).rstrip("\n"))
            return True
        try:
            for answer in self.calculator.run(line, name, number):
                if answer.text:
                    self._show(answer.text)
        except AraelError as error:
            self.failed = True
            self._show_errors(error.diagnostics)
        except KeyboardInterrupt:
            self.failed = True
            click.echo("interrupted", err=True)
        return True

    def _info(self, word: str) -> str:
        if word == "help":
            return _HELP
        if word == "functions":
            return "\n".join(f.node.span.text for f in self.calculator.functions.values())
        return "\n".join(
            f"{name} = {self.calculator.text(value)}"
            for name, value in self.calculator.variables.items()
        )

    def _show(self, text: str) -> None:
        click.echo(json.dumps({"status": "ok", "result": text}) if self.as_json else text)

    def _show_errors(self, diagnostics: tuple[Diagnostic, ...]) -> None:
        if not self.as_json:
            sys.stdout.flush()
            print_text(diagnostics)
            return

        plain: Any = as_json(diagnostics)
        click.echo(json.dumps({"status": "error", "diagnostics": plain}))
