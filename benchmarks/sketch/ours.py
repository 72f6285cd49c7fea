"""arael's sketch editor in its own process; all that depends on its interface is in this file.

``python -m benchmarks.sketch.ours TASK SKETCH SECONDS``. Sketches are drawn by the commands that
the Rust framework gets. What the editor does not have yet is reported as absent.
"""

from __future__ import annotations

import random
import time
from typing import Any

from benchmarks.sketch.commands import random_commands
from benchmarks.sketch.repeating import AbsentError, main, repeated
from benchmarks.sketch.sketches import Sketch
from benchmarks.sketch.writing import command, handle, operands, script

SETTINGS = "largest residual 1e-10 of the sketch's size"


class Editor:
    """The editor behind the few calls that the tasks make."""

    def __init__(self, drawing: Sketch) -> None:
        try:
            from arael.sketch import Sketch as Session
        except ImportError as error:
            raise AbsentError(f"the editor is not there: {error}") from None
        from arael import AraelError

        self.drawing, self.session, self.refusal = drawing, Session(), AraelError

    def call(self, name: str, *words: Any) -> Any:
        """A method of the editor."""
        method = getattr(self.session, name, None)
        if method is None:
            raise AbsentError(f"arael.sketch.Sketch has no {name} yet")
        return method(*words)

    def run(self, command: str) -> tuple[str, bool]:
        """Run a command: its words, and whether it was refused."""
        try:
            return str(self.call("run", command)), False
        except self.refusal as refused:
            return str(refused), True

    def tried(self, command: str) -> bool:
        """Whether a command was taken; it is undone where it left something to undo."""
        history = self.session.document.history
        before = history.position
        _, refused = self.run(command)
        if history.position > before:
            self.call("undo")
        return not refused

    def draw(self) -> str:
        """Draw the sketch by its script."""
        said, refused = self.run("\n".join(script(self.drawing)))
        if refused:
            raise AbsentError(f"the script was refused: {said.splitlines()[0]}")
        return said

    def dimensions(self) -> list[str]:
        """Names of the dimensions, in the order they were made."""
        return list(self.session.document.dimensions)

    def answer(self) -> dict[str, list[float]]:
        """Numbers of the entities."""
        document = self.session.document
        found: dict[str, list[float]] = {"lines": [], "circles": [], "arcs": []}
        for name, entity in document.entities.items():
            kind = f"{entity.kind}s"
            if kind in found:
                found[kind] += document.numbers_of(name).tolist()
        return found

    def state(self) -> tuple[bytes, bytes]:
        """Everything that an undo must bring back: numbers and records, bit by bit."""
        from arael.sketch.document.saved import to_json

        return self.session.document.values.tobytes(), to_json(self.session.document)

    def found(self, times: list[float], said: str, **more: Any) -> dict[str, Any]:
        """What a task reports."""
        import arael

        return {
            "times": times,
            "answer": self.answer(),
            "said": said,
            "settings": SETTINGS,
            "version": f"arael {arael.__version__}",
            **more,
        }


def resolve(drawing: Sketch, budget: float) -> dict[str, Any]:
    """A dimension's new value, by the method of its name."""
    editor = Editor(drawing)
    editor.draw()
    rule = drawing.rules[drawing.changed]
    names, targets = operands(drawing, rule), drawing.targets
    said: list[str] = []

    def turn(number: int) -> None:
        said[:] = [str(editor.call(rule.kind, *names, targets[number % len(targets)]))]

    times = repeated(budget, turn)
    turn(1)
    return editor.found(times, said[0])


def freedom(drawing: Sketch, budget: float) -> dict[str, Any]:
    """The analysis after a dimension changed, so that no earlier one can be given back."""
    editor = Editor(drawing)
    editor.draw()
    rule = drawing.rules[drawing.changed]
    names, targets = operands(drawing, rule), drawing.targets
    counted: list[Any] = []

    def turn(number: int) -> float:
        editor.call(rule.kind, *names, targets[number % len(targets)])
        began = time.perf_counter()
        counted[:] = [editor.call("dof")]
        return time.perf_counter() - began

    times = repeated(budget, turn)
    editor.call(rule.kind, *names, targets[0])
    free = counted[0]["freedoms"]
    return editor.found(times, f"{free} degrees of freedom", freedoms=free)


def edit(drawing: Sketch, budget: float) -> dict[str, Any]:
    """The dimension that changes deleted and added, in turns."""
    editor = Editor(drawing)
    editor.draw()
    made = command(drawing, drawing.rules[drawing.changed])
    before = drawing.rules[: drawing.changed]
    first = sum(bool(rule.values) and rule.kind != "lock" for rule in before)
    whole = len(editor.dimensions())
    name, said = editor.dimensions()[first], ""

    def turn(_: int) -> float:
        nonlocal name, said
        words = f"delete {name}" if len(editor.dimensions()) == whole else made
        began = time.perf_counter()
        said = editor.run(words)[0]
        took = time.perf_counter() - began
        name = editor.dimensions()[-1]
        return took

    times = repeated(budget, turn)
    if len(editor.dimensions()) < whole:
        turn(0)
    return editor.found(times, said)


def verdict(name: str) -> Any:
    """The task of adding a candidate that is refused."""

    def task(drawing: Sketch, budget: float) -> dict[str, Any]:
        editor = Editor(drawing)
        editor.draw()
        asked = command(drawing, drawing.candidates[name])
        before, said = editor.state(), ("", False)

        def turn(_: int) -> None:
            nonlocal said
            said = editor.run(asked)

        times = repeated(budget, turn)
        words = said[0] if said[1] else f"taken: {said[0]}"
        return editor.found(times, words + ("" if editor.state() == before else "; it changed"))

    return task


def drawn_by_script(drawing: Sketch, budget: float) -> dict[str, Any]:
    """The script in a new editor; once, after a run that does not count."""
    Editor(drawing).draw()
    editor = Editor(drawing)
    began = time.perf_counter()
    editor.draw()
    times = [time.perf_counter() - began]
    free = editor.call("dof")["freedoms"]
    return editor.found(times, f"{len(script(drawing))} commands, {free} degrees of freedom")


def drag(drawing: Sketch, budget: float) -> dict[str, Any]:
    """The end dragged frame by frame as one gesture, as far as the editor has gestures."""
    editor = Editor(drawing)
    editor.draw()
    name = handle(drawing, drawing.grabbed)
    gesture = getattr(editor.session, "dragging", None)
    times = []
    if gesture is not None:
        with gesture(name) as held:
            for x, y in drawing.path.tolist():
                began = time.perf_counter()
                held.to(x, y)
                times.append(time.perf_counter() - began)
        return editor.found(times, "one gesture")
    for x, y in drawing.path.tolist():
        began = time.perf_counter()
        editor.run(f"drag {name} {x!r},{y!r}")
        times.append(time.perf_counter() - began)
    return editor.found(times, "a command a frame")


def undo(drawing: Sketch, budget: float) -> dict[str, Any]:
    """Random commands, each undone: everything must be as it was, bit by bit.

    What leaves nothing to undo, such as a drag of what is held, must have changed nothing itself.
    """
    editor = Editor(drawing)
    editor.draw()
    words = random_commands(drawing, random.Random(0))
    before = editor.state()
    times: list[float] = []
    refused = wrong = broken = 0
    first = ""
    began = time.perf_counter()
    while time.perf_counter() - began < 10 * budget:
        asked = next(words)
        start = time.perf_counter()
        try:
            refused += not editor.tried(asked)
        except AbsentError:
            raise
        except Exception as error:  # the very thing that is counted
            broken += 1
            first = first or f"{asked}: {type(error).__name__}: {error}"
        times.append(time.perf_counter() - start)
        if editor.state() != before:
            wrong += 1
            first = first or f"{asked}: not as before"
            before = editor.state()
    said = f"{len(times)} commands, {refused} refused, {wrong} not undone, {broken} exceptions"
    return editor.found(times, f"{said}{'; ' + first if first else ''}")


TASKS = {
    "resolve": resolve,
    "freedom": freedom,
    "edit": edit,
    "redundant": verdict("redundant"),
    "contradicting": verdict("contradicting"),
    "script": drawn_by_script,
    "drag": drag,
    "undo": undo,
}

if __name__ == "__main__":
    main(TASKS, "arael")
