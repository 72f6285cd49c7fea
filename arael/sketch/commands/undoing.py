"""Commands on the history."""

from __future__ import annotations

from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail


def _steps(session: Session, words: Words, what: str) -> Reply:
    count = words.whole("how many steps", least=1) if words else 1
    words.end()
    document = session.document
    labels: list[str] = []
    for _ in range(count):
        label = document.undo() if what == "undo" else document.redo()
        if label is None:
            break
        labels.append(label)
    if not labels:
        fail("E1266", f"nothing to {what}", words.span, "", "`history` shows the steps")
    said = "Undid" if what == "undo" else "Redid"
    lines = [f"{said}: {label}" for label in labels]
    if len(labels) < count:
        were = "was 1 step" if len(labels) == 1 else f"were {len(labels)} steps"
        lines.append(f"there {were} to {what}, not {count}")
    data = {"steps": len(labels), "position": document.history.position}
    return Reply("\n".join(lines), remembered=False, data=data)


@command(
    "undo",
    group="history",
    usage=["undo", "undo 5"],
    summary="Take the last command line back, or several.",
    arguments=("steps=",),
    outside=True,
)
def undo(session: Session, words: Words) -> Reply:
    """Undo."""
    return _steps(session, words, "undo")


@command(
    "redo",
    group="history",
    usage=["redo", "redo 3"],
    summary="Make what was undone again.",
    arguments=("steps=",),
    outside=True,
)
def redo(session: Session, words: Words) -> Reply:
    """Redo."""
    return _steps(session, words, "redo")


@command(
    "history",
    group="history",
    usage=["history", "history 10"],
    summary="List the steps; `>` marks the last one that is done.",
    arguments=("count=",),
)
def history(session: Session, words: Words) -> Reply:
    """List the steps."""
    count = words.whole("how many steps", least=1) if words else 0
    words.end()
    labels = session.document.history.labels
    position = session.document.history.position
    numbered = list(enumerate(["(start)", *labels]))
    first = max(0, position - count) if count else 0
    last = position + 1 if count else len(numbered)
    lines = [
        f"{'>' if number == position else ' '} {number}: {label}"
        for number, label in numbered[first:last]
    ]
    return Reply(
        "\n".join(lines), remembered=False, data={"position": position, "labels": list(labels)}
    )


@command(
    "goto",
    group="history",
    usage=["goto 5", "goto 0"],
    summary="Go to a step of the history; 0 is the start.",
    arguments=("step",),
    outside=True,
)
def goto(session: Session, words: Words) -> Reply:
    """Go to a step of the history."""
    document = session.document
    most = len(document.history.labels)
    token = words.peek()
    step = words.whole("a step", least=0, most=10**9)
    words.end()
    if step > most and token is not None:
        hint = "`history` shows the steps"
        steps = "1 step" if most == 1 else f"{most} steps"
        fail("E1266", f"the history has {steps}, found {step}", token.span, "", hint)
    while document.history.position > step:
        document.undo()
    while document.history.position < step:
        document.redo()
    return Reply(f"At step {step} of {most}", remembered=False, data={"position": step})
