"""Commands on files, all of which stay below the session's folder."""

from __future__ import annotations

from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from arael.sketch.commands.importing import take_over
from arael.sketch.commands.numbers import listed
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session, State
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.document import Document
from arael.sketch.document.saved import load, save
from arael.sketch.transfer.naming import handle_under

EXPORTS = (".dxf", ".svg", ".pdf", ".png", ".step", ".stp")
IMPORTS = (".dxf", ".svg")


def path_of(session: Session, words: Words, *suffixes: str) -> tuple[Path, Token]:
    """Take the name of a file below the session's folder.

    Raises
    ------
    AraelError
        E1264: it would be elsewhere; E1265: another kind of file.
    """
    token = words.next("a file name")
    given = Path(token.text)
    below = f"files are kept below {session.folder.name or session.folder}"
    if given.is_absolute() or token.text.startswith("~"):
        fail("E1264", "expected a file name, found an absolute path", token.span, "", below)
    if ".." in given.parts:
        fail("E1264", "`..` is not allowed in a file name", token.span, "", below)
    if "\0" in token.text or len(token.text) > 1000:
        fail("E1264", "this is not a name of a file", token.span)
    root = session.folder.resolve()
    try:
        path = (root / given).resolve()
    except (OSError, RuntimeError):  # Python before 3.13 raises RuntimeError
        fail("E1264", f"`{token.text}` is a link that leads in a circle", token.span)
    if not path.is_relative_to(root):
        fail("E1264", f"`{token.text}` leads to another folder", token.span, "", below)
    if suffixes and path.suffix.lower() not in suffixes:
        found = f"`{path.suffix}`" if path.suffix else "none"
        kinds = ", ".join(suffixes)
        fail("E1265", f"expected a file ending in {kinds}, found {found}", token.span)
    if _is_special(path):
        fail("E1265", f"`{token.text}` is a pipe or device, not a file", token.span)
    return path, token


def _is_special(path: Path) -> bool:
    """Whether reading or writing might wait for another program."""
    try:
        return path.exists() and not (path.is_file() or path.is_dir())
    except OSError:
        return False  # said when it is opened


def _unreadable(error: OSError, token: Token, what: str) -> NoReturn:
    reason = (error.strerror or str(error)).lower()
    fail("E1265", f"`{token.text}` cannot be {what}: {reason}", token.span)


@command(
    "save",
    group="file",
    usage=["save path.json"],
    summary="Save the sketch.",
    arguments=("path",),
)
def save_(session: Session, words: Words) -> Reply:
    """Save the sketch."""
    path, token = path_of(session, words, ".json")
    words.end()
    try:
        save(session.document, path)
    except OSError as error:
        _unreadable(error, token, "written")
    return Reply(f"Saved {token.text}", remembered=False, data={"path": token.text})


@command(
    "load",
    group="file",
    usage=["load path.json"],
    summary="Load a sketch in place of this one.",
    details="The history begins anew; variables, selection and cursor are cleared.",
    arguments=("path",),
    outside=True,
)
def load_(session: Session, words: Words) -> Reply:
    """Load a sketch."""
    path, token = path_of(session, words, ".json")
    words.end()
    try:
        document = load(path)
    except OSError as error:
        _unreadable(error, token, "read")
    _replace(session, document)
    count = len(document.entities)
    return Reply(
        f"Loaded {token.text}: {count} entit{'y' if count == 1 else 'ies'}",
        remembered=False,
        data={"path": token.text, "entities": count},
    )


def _replace(session: Session, document: Document) -> None:
    session.editor = session.make_editor(document)
    kept = session.state
    session.state = State(timing=kept.timing, settings=kept.settings)
    session.state.view.version = kept.view.version + 1


@command(
    "export",
    group="file",
    usage=[
        "export drawing.dxf",
        'export drawing.pdf [A4|A3|A2|A1] [title "Bracket"] [date 2026-01-31]',
    ],
    summary="Write the drawing as DXF, SVG, PDF, PNG, STEP or JSON, by the file's ending.",
    details="""
As JSON it is all of the sketch, as `save` writes it. A PDF or PNG has neither badges nor points. On
a sheet it is at the largest standard scale that fits, with a frame and a title block of title (by
default the file's name), unit, scale and date.
""",
    arguments=("path", "*words"),
)
def export(session: Session, words: Words) -> Reply:
    """Write the drawing."""
    path, token = path_of(session, words, *EXPORTS, ".json")
    given = _sheet(words) if path.suffix.lower() in (".pdf", ".png") else {}
    words.end()
    try:
        if path.suffix.lower() == ".json":
            save(session.document, path)
        else:
            _exchange(token).write(session.document, path, **given)
    except OSError as error:
        _unreadable(error, token, "written")
    return Reply(f"Exported {token.text}", remembered=False, data={"path": token.text})


def _sheet(words: Words) -> dict[str, str]:
    """Size of the sheet, and what its title block says."""
    given: dict[str, str] = {}
    if not words:
        return given
    # imported here: start-up time
    from arael.sketch.exchange.sheet import SHEETS

    given["sheet"] = words.choice("the size of a sheet", *SHEETS, *map(str.lower, SHEETS)).upper()
    while words:
        token = words.peek()
        word = words.choice("`title` or `date`", "title", "date")
        if word in given:
            assert token is not None
            fail("E1267", f"`{word}` is given twice", token.span)
        given[word] = words.next(f"the {word} of the drawing").text
    return given


@command(
    "import",
    group="file",
    usage=["import drawing.dxf"],
    summary="Add the geometry of a DXF or SVG file.",
    details="""
Files that arael wrote bring their constraints, dimensions and parameters too. Of others, relations
that were found in the geometry are listed as commands; they are not applied.
""",
    arguments=("path",),
)
def import_(session: Session, words: Words) -> Reply:
    """Add the geometry of a file."""
    path, token = path_of(session, words, *IMPORTS)
    words.end()
    exchange = _exchange(token)
    try:
        found = exchange.read(path)
    except OSError as error:
        _unreadable(error, token, "read")
    document = found if isinstance(found, Document) else found.document
    names = take_over(session, document)
    entities = [names[name] for name in document.entities]
    lines = [f"Imported {token.text}: {listed(entities, 12) or 'nothing'}"]
    lines += [f"  note: {note}" for note in getattr(found, "notes", ())]
    suggestions = [] if isinstance(found, Document) else list(found.suggestions)
    if suggestions:
        kinds = Counter(one.kind for one in suggestions)
        counts = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
        lines.append(f"  found relations, which are not applied: {counts}")
        lines += [f"    {suggested(one, names)}" for one in suggestions[:50]]
    data = {"entities": entities, "suggestions": [suggested(one, names) for one in suggestions]}
    return Reply("\n".join(lines), tuple(entities), data=data)


def suggested(one: Any, names: dict[str, str]) -> str:
    """A relation that was found, as a command with the names that the sketch has now."""
    kind, args = getattr(one, "kind", None), getattr(one, "args", None)
    if kind is None or args is None:
        return str(one)
    return " ".join([kind, *(handle_under(names, arg) for arg in args)])


def _exchange(token: Token) -> Any:
    try:
        return import_module("arael.sketch.exchange")
    except ModuleNotFoundError as error:
        help_ = "`pip install arael[sketch]` brings what it needs"
        message = f"other formats need the module `{error.name}`"
        fail("E1270", message, token.span, "", help_)


@command(
    "clear",
    group="file",
    usage=["clear"],
    summary="Delete everything; names begin anew. `undo` brings it back.",
    arguments=(),
)
def clear(session: Session, words: Words) -> Reply:
    """Delete everything."""
    words.end()
    document = session.document
    with document.transaction("clear"):
        for table in ("groups", "dimensions", "constraints", "parameters", "entities"):
            for name in reversed(list(getattr(document, table))):
                document.remove(table, name)
        for key in [key for key in document.settings if key.startswith("counter:")]:
            document.set_setting(key, None)
    state = session.state
    session.state = State(timing=state.timing, settings=state.settings)
    session.state.view.version = state.view.version + 1
    return Reply("Cleared", remembered=False)
