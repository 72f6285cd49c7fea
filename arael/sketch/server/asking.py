"""Questions of pages, which change nothing."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.sketch.commands import table
from arael.sketch.commands.completion import completions, value_words
from arael.sketch.commands.describing import record_line
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.session import described
from arael.sketch.server.answers import mentioned

if TYPE_CHECKING:
    from arael.sketch.server.shared import SharedSketch
    from arael.sketch.server.windows import Window

Message = dict[str, Any]

MAX_COMPLETIONS = 50
"""Words that are offered."""

_WORD = re.compile(r"[\w.]*\Z")


_SENTENCES = {
    "impossible": "{} is impossible together with {}",
    "redundant": "{} follows from {}",
    "here": "{} follows from {} in this position",
}


def asked(shared: SharedSketch, window: Window, what: str, message: Message) -> Message:
    """The answer to a question.

    Raises
    ------
    AraelError
        E1401: no such question; whatever the command refuses
    """
    found = _QUESTIONS.get(what)
    if found is None:
        raise AraelError(Diagnostic("E1401", f"no question `{what[:40]}`"))
    with shared.acting(window):
        return found(shared, window, message)


def _command(word: str, argument: str = "") -> Callable[..., Message]:
    """A question that is a command."""

    def ask(shared: SharedSketch, window: Window, message: Message) -> Message:
        given = str(message.get(argument) or "") if argument else ""
        if "\n" in given or ";" in given:
            raise AraelError(Diagnostic("E1401", f"`{argument}` is not a command"))
        return shared.query(window, f"{word} {given}".strip())

    return ask


def _answer(text: str, data: Any = None, names: list[str] | None = None) -> Message:
    return {
        "ok": True,
        "text": text,
        "names": names or [],
        "created": [],
        "notes": [],
        "data": data,
    }


def _conflicts(shared: SharedSketch, window: Window, message: Message) -> Message:
    """Constraints that contradict or hold nothing new, each with what it depends on."""
    session = shared.session
    judge, document = session.editor.judge, session.document
    standing = judge.standing(judge.freedoms().redundant)
    impossible = [one for one in standing if one.kind == "impossible"]
    spare = [one.name for one in standing if one.kind != "impossible"]
    verdicts = [*impossible, *(judge.verdicts(spare) if spare else ())]
    found: list[dict[str, Any]] = []
    for verdict in verdicts:
        others = [name for name in verdict.members if name != verdict.name]
        record = document.find(verdict.name)
        line = record_line(session, record) if record is not None else verdict.name
        sentence = _SENTENCES.get(verdict.kind, _SENTENCES["redundant"])
        text = sentence.format(line, ", ".join(others) or "others")
        found.append({"name": verdict.name, "members": others, "sentence": text})
    for one in document.dimensions.values():
        if one.broken:
            sentence = f"{record_line(session, one)}: {one.broken}"
            found.append({"name": one.name, "members": [], "sentence": sentence})
    for param in document.parameters.values():
        if param.broken:
            sentence = f"{param.name}: {param.broken}"
            found.append({"name": param.name, "members": [], "sentence": sentence})
    text = "\n".join(one["sentence"] for one in found) or "Nothing conflicts"
    return _answer(text, {"conflicts": found}, mentioned([text], document))


def _complete(shared: SharedSketch, window: Window, message: Message) -> Message:
    """Words that may stand at a place of a command line, or of a `value`."""
    text = str(message.get("text") or "")[:10_000]
    given = message.get("at")
    at = given if isinstance(given, int) and 0 <= given <= len(text) else len(text)
    before = text[:at]
    part = _WORD.search(before)
    word = part[0] if part else ""
    command = before[before.rfind(";") + 1 :].lstrip()
    value = message.get("value") is True
    first = not value and command == word
    if value:
        words = value_words(shared.session)
    else:
        words = table.words() if first else completions(shared.session)
    found = [one for one in words if one.startswith(word) and one != word]
    if not first and not value:
        known = table.find(command.split(None, 1)[0])
        own = frozenset(known.keywords if known is not None else ())
        found.sort(key=lambda one: (one not in own, one))
    return _answer("", {"from": at - len(word), "to": at, "words": found[:MAX_COMPLETIONS]})


def _table(shared: SharedSketch, window: Window, message: Message) -> Message:
    """All commands with their usage."""
    found = []
    for one in table.commands().values():
        found.append(
            {
                key: value
                for key, value in asdict(one).items()
                if key in ("name", "group", "usage", "summary", "details", "aliases", "keywords")
            }
        )
    return _answer("", {"groups": dict(table.GROUPS), "commands": found})


def _evaluate(shared: SharedSketch, window: Window, message: Message) -> Message:
    """The value of an expression."""
    text = str(message.get("text") or "")[:10_000]
    source = Source("expression", text)
    value = shared.session.evaluate(text, Span(source, 0, len(text)))
    number = value if isinstance(value, float) else getattr(value, "number", None)
    said = shown(number) if isinstance(number, float) else described(value)
    return _answer(said, {"value": number})


_QUESTIONS: dict[str, Callable[..., Message]] = {
    "free": _command("free"),
    "why": _command("why", "name"),
    "help": _command("help", "word"),
    "info": _command("info", "name"),
    "measure": _command("measure", "names"),
    "history": _command("history"),
    "conflicts": _conflicts,
    "complete": _complete,
    "table": _table,
    "evaluate": _evaluate,
}
