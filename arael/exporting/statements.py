"""Straight-line programs as C statements, one operation each, in order of evaluation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from arael.compiler.emit.writer import comment
from arael.exporting.identifiers import identifier
from arael.runtime.layout import Place
from arael.runtime.machine.tape import NATIVE, Tape
from arael.symbolic.c import c_literal, c_operation

_TEMPORARY = 100  # a name binds more strongly than any operation
_NEGATIVE = 7


def c_comment(text: str, limit: int = 80) -> str:
    """User's text made safe inside ``/* */``, cut at `limit`."""
    safe = comment(text, limit)
    for pair, instead in (("*/", "* /"), ("/*", "/ *"), ("??", "? ?")):
        while pair in safe:
            safe = safe.replace(pair, instead)
    return safe


class Statements:
    """Writes the nodes of a tape as ``const double t0 = ...;`` section by section.

    Parameters
    ----------
    tape : the program
    inputs : C expression of each input
    names : C name of each input that is read, for a constant of its own; "" reads it in place
    real : C type
    places : places of the model that the tape refers to
    prefix : before the names of native functions
    """

    def __init__(
        self,
        tape: Tape,
        inputs: Sequence[str],
        names: Sequence[str] = (),
        real: str = "double",
        places: Sequence[Place] = (),
        prefix: str = "",
    ) -> None:
        self.lines: list[str] = []
        self._tape, self._inputs, self._names = tape, inputs, names
        self._real, self._places, self._prefix = real, places, prefix
        self._texts: dict[int, tuple[str, int]] = {}
        self._temporaries = 0
        self._place = -1

    def write(self, nodes: Iterable[int]) -> None:
        """Write some nodes, in order; what was written before is left out."""
        for node in nodes:
            if node not in self._texts:
                self._texts[node] = self._write(node)

    def value(self, node: int, least: int = 0) -> str:
        """C expression of a node that was written, in parentheses if it binds less than `least`."""
        text, binding = self._texts[node]
        return text if binding >= least else f"({text})"

    def _write(self, node: int) -> tuple[str, int]:
        op, args = self._tape.ops[node], self._tape.args[node]
        if op == "const":
            text = c_literal(self._tape.constants[args[0]], self._real)
            return text, _NEGATIVE if text.startswith("-") else _TEMPORARY
        if op == "input":
            return self._constant(self._names[args[0]] if self._names else "", args[0])
        if op == "neg":
            return f"-{self.value(args[0], 8)}", _NEGATIVE
        if op.startswith(NATIVE):
            name = f"{self._prefix}{identifier(op.removeprefix(NATIVE))}"
            value = f"{name}({', '.join(self.value(a) for a in args)})"
        else:
            value, _ = c_operation(op, [self._texts[a] for a in args], self._real)
        self._show_place(node)
        name = f"t{self._temporaries}"
        self._temporaries += 1
        self.lines.append(f"const {self._real} {name} = {value};")
        return name, _TEMPORARY

    def _constant(self, name: str, number: int) -> tuple[str, int]:
        if name:
            self.lines.append(f"const {self._real} {name} = {self._inputs[number]};")
        return name or self._inputs[number], _TEMPORARY

    def _show_place(self, node: int) -> None:
        place = self._tape.places[node] if self._tape.places else -1
        if self._places and 0 <= place != self._place:
            shown = self._places[place]
            where = shown.where.rpartition("/")[2]
            self.lines.append(f"/* {c_comment(f'{where}: {shown.text}')} */")
            self._place = place
