"""Lines of generated source, indented, and tapes as numbered statements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from arael.compiler.emit.operators import expression, literal
from arael.runtime.layout import Place
from arael.runtime.tape import Tape


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


def statements(
    w: Writer,
    tape: Tape,
    inputs: Sequence[str],
    outputs: Callable[[int], Sequence[str]],
    places: Sequence[Place] = (),
) -> int:
    """Write a tape as ``t0 = ...`` in order of use; return the number of temporaries.

    `outputs(i)` are the names to which output `i` is stored. A negation is written where it is
    read.
    """
    names: list[str] = []
    temporaries = 0
    stores: dict[int, list[str]] = {}
    for number, node in enumerate(tape.outputs):
        stores.setdefault(node, []).extend(outputs(number))
    said = -1
    for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op == "input":
            names.append(inputs[args[0]])
        elif op == "const":
            names.append(literal(tape.constants[args[0]]))
        elif op == "neg":
            names.append(f"(-{names[args[0]]})")
        else:
            place = tape.places[node] if tape.places else -1
            if places and place >= 0 and place != said:
                where = comment(places[place].where.rpartition("/")[2])
                w.line(f"# {where}: {comment(places[place].text)}")
                said = place
            w.line(f"t{temporaries} = {expression(op, [names[a] for a in args])}")
            names.append(f"t{temporaries}")
            temporaries += 1
        for target in stores.get(node, ()):
            w.line(f"{target} = {names[node]}")
    return temporaries


def comment(text: str, limit: int = 80) -> str:
    """User's text made safe inside a comment: one line, printable ASCII, cut at `limit`."""
    clean = "".join(c if " " <= c <= "~" and c != "\\" else "?" for c in text)
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."
