"""Lines of generated source, indented, and tapes as numbered statements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from arael.compiler.emit.operators import expression, literal
from arael.runtime.layout import Place
from arael.runtime.machine.tape import Tape


class Writer:
    """Collects lines at the current depth of indentation."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.depth = 0

    def line(self, text: str = "") -> None:
        """Add one line."""
        self.lines.append("    " * self.depth + text if text else "")

    def lines_of(self, texts: Iterable[str]) -> None:
        """Add some lines."""
        for text in texts:
            self.line(text)

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Add `head` and indent what follows."""
        self.line(head)
        self.depth += 1
        yield
        self.depth -= 1

    def text(self) -> str:
        """Everything written."""
        return "\n".join(self.lines) + "\n"


class Statements:
    """A tape written as ``t0 = ...`` in order of use, all at once or section by section.

    A negation is written where it is read.

    Parameters
    ----------
    inputs : text of each input
    outputs : names to which each output is stored; none if another output stores it
    places : of the model, which the tape refers to: a comment above the statements from there
    notes : of each name that is stored to, a comment beside the statement

    Attributes
    ----------
    temporaries : number of those written so far
    """

    def __init__(
        self,
        w: Writer,
        tape: Tape,
        inputs: Sequence[str],
        outputs: Callable[[int], Sequence[str]],
        places: Sequence[Place] = (),
        notes: Mapping[str, str] | None = None,
    ) -> None:
        self.temporaries = 0
        self._w, self._tape, self._inputs, self._outputs = w, tape, inputs, outputs
        self._places, self._notes = places, notes or {}
        self._names: dict[int, str] = {}

    def write(self, nodes: Iterable[int], outputs: Iterable[int]) -> None:
        """Write some nodes, in order, and store outputs, each as soon as it is there."""
        stores: dict[int, list[str]] = {}
        for number in outputs:
            stores.setdefault(self._tape.outputs[number], []).extend(self._outputs(number))
        for node in [node for node in stores if node in self._names]:
            self._store(node, stores.pop(node))
        shown = -1
        for node in nodes:
            op, args = self._tape.ops[node], self._tape.args[node]
            if op == "input":
                text = self._inputs[args[0]]
            elif op == "const":
                text = literal(self._tape.constants[args[0]])
            elif op == "neg":
                text = f"(-{self._names[args[0]]})"
            else:
                place = self._tape.places[node] if self._tape.places else -1
                if self._places and place >= 0 and place != shown:
                    self._w.line(f"# {described(self._places[place])}")
                    shown = place
                text = f"t{self.temporaries}"
                value = expression(op, [self._names[a] for a in args])
                self._w.line(f"{text} = {value}")
                self.temporaries += 1
            self._names[node] = text
            self._store(node, stores.get(node, ()))

    def _store(self, node: int, targets: Iterable[str]) -> None:
        for target in targets:
            note = self._notes.get(target)
            beside = f"  # {comment(note)}" if note else ""
            self._w.line(f"{target} = {self._names[node]}{beside}")


def statements(
    w: Writer,
    tape: Tape,
    inputs: Sequence[str],
    outputs: Callable[[int], Sequence[str]],
    places: Sequence[Place] = (),
) -> int:
    """Write a whole tape; return the number of temporaries."""
    whole = Statements(w, tape, inputs, outputs, places)
    whole.write(range(len(tape.ops)), range(len(tape.outputs)))
    return whole.temporaries


def described(place: Place) -> str:
    """File, line and text of a place, for a comment: generated source names no folder."""
    return f"{comment(place.where.rpartition('/')[2])}: {comment(place.text)}"


def comment(text: str, limit: int = 80) -> str:
    """User's text made safe inside a comment: one line, printable ASCII, cut at `limit`."""
    clean = "".join(c if " " <= c <= "~" and c != "\\" else "?" for c in text)
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."
