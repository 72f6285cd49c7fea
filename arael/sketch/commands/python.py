"""Source of `arael.sketch.methods`, made from the table of commands."""

from __future__ import annotations

import keyword
import textwrap

from arael.sketch.commands import table
from arael.sketch.commands.table import Command

_HEAD = '''"""Commands as methods; made from their table by `arael.sketch.commands.python`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from arael.sketch.things import Point, Thing

Argument: TypeAlias = Thing | Point | str | float | Sequence[float]
"""A word of a command: a thing or its name, a number, an expression, a pair of coordinates."""


class Commands:
    """Every command as a method."""

    def _command(
        self, word: str, arguments: Sequence[Argument | None], flags: Mapping[str, bool]
    ) -> Any:
        raise NotImplementedError
'''

#: Commands that make no sense as methods, or that `Sketch` writes itself.
_LEFT_OUT = frozenset({"exit", "save", "load", "export", "import", "add_text", "set_text"})


def source() -> str:
    """The text of the module."""
    found = [one for one in table.commands().values() if one.name not in _LEFT_OUT]
    return "\n".join([_HEAD, *map(_method, found)])


def method_name(command: str) -> str:
    """Name of the method of a command."""
    return f"{command}_" if keyword.iskeyword(command) else command


def _method(command: Command) -> str:
    flags = [word for word in command.keywords if word.isidentifier()]
    parameters = ["self"]
    given: list[str] = []
    rest = ""
    for argument in command.arguments:
        if argument.startswith("*"):
            rest = argument[1:]
            parameters.append(f"*{rest}: Argument")
        elif argument.endswith("="):
            parameters.append(f"{argument[:-1]}: Argument | None = None")
            given.append(argument[:-1])
        else:
            parameters.append(f"{argument}: Argument")
            given.append(argument)
    if flags and not rest:
        parameters.append("*")
    parameters += [f"{method_name(flag)}: bool = False" for flag in flags]
    arguments = _tuple([*given, f"*{rest}"] if rest else given)
    words = ", ".join(f'"{flag}": {method_name(flag)}' for flag in flags)
    call = f'self._command("{command.name}", {arguments}, {{{words}}})'
    head = f"def {method_name(command.name)}({', '.join(parameters)}) -> Any:"
    if len(head) + 4 > 100:
        head = "def {}(\n{}\n) -> Any:".format(
            method_name(command.name), "\n".join(f"    {one}," for one in parameters)
        )
    if len(call) + 15 > 100:
        call = "self._command(\n{}\n)".format(
            "\n".join(
                f"    {one},"
                for one in (f'"{command.name}"', arguments, _mapping(flags, len(words)))
            )
        )
    body = f"{_docstring(command)}\nreturn {call}\n"
    return textwrap.indent(f"{head}\n{textwrap.indent(body, '    ')}", "    ")


def _tuple(names: list[str]) -> str:
    return f"({names[0]},)" if len(names) == 1 else f"({', '.join(names)})"


def _mapping(flags: list[str], length: int) -> str:
    pairs = [f'"{flag}": {method_name(flag)}' for flag in flags]
    if length + 15 <= 100:
        return f"{{{', '.join(pairs)}}}"
    lines = "\n".join(f"        {one}," for one in pairs)
    return f"{{\n{lines}\n    }}"


def _docstring(command: Command) -> str:
    prefix = 'r"""' if "\\" in command.summary + "".join(command.usage) else '"""'
    summary = command.summary
    if len(summary) > 84:
        wrapped = textwrap.fill(summary, 88)
        summary = f"The command ``{command.name}``.\n\n{wrapped}"
    lines = [f"{prefix}{summary}", "", "As a command::", ""]
    for line in command.usage:
        pieces = textwrap.wrap(line, 84, subsequent_indent="    ", break_on_hyphens=False)
        lines += [f"    {one}" for one in pieces]
    lines.append('"""')
    return "\n".join(lines)
