"""Import and export by a page: files come and go as bytes, none is read from the disk."""

from __future__ import annotations

import base64
import binascii
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.commands.files import suggested
from arael.sketch.commands.importing import take_over
from arael.sketch.document.document import Document

if TYPE_CHECKING:
    from arael.sketch.server.shared import SharedSketch
    from arael.sketch.server.windows import Window

Message = dict[str, Any]


def done(shared: SharedSketch, window: Window, what: str, message: Message) -> Message:
    """Save, import or export.

    Raises
    ------
    AraelError
        E1401: neither of them; E1301 to E1307: what the formats refuse
    """
    if what == "save":
        return _save(shared)
    # imported here: start-up time
    from arael.sketch.exchange.files import READERS, WRITERS

    known = {"export": WRITERS, "import": READERS}.get(what)
    ending = f".{str(message.get('format') or '').lower().lstrip('.')}"
    if known is None or ending not in known:
        kinds = ", ".join(one[1:] for one in known or ())
        expected = f"expected one of {kinds}" if known else "expected import, export or save"
        raise AraelError(Diagnostic("E1401", f"message `file`: {expected}"))
    name = Path(str(message.get("name") or "sketch")).name[:100] or "sketch"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"sketch{ending}"
        if what == "export":
            return _export(shared, path, f"{Path(name).stem or 'sketch'}{ending}", message)
        path.write_bytes(_bytes(message))
        return _import(shared, window, path, name)


def _answer(text: str, **data: Any) -> Message:
    return {"ok": True, "text": text, "names": [], "created": [], "notes": [], "data": data}


def _save(shared: SharedSketch) -> Message:
    if shared.keeper is None:
        raise AraelError(
            Diagnostic("E1406", "this sketch has no file", help=("`save name.json` writes one",))
        )
    problem = shared.save()
    if problem:
        raise AraelError(Diagnostic("E1407", problem))
    return _answer(f"Saved {shared.keeper.path.name}")


def _bytes(message: Message) -> bytes:
    try:
        return base64.b64decode(message.get("data") or "", validate=True)
    except (binascii.Error, ValueError, TypeError):
        raise AraelError(Diagnostic("E1401", "message `file`: expected base64 as `data`")) from None


def _export(shared: SharedSketch, path: Path, name: str, message: Message) -> Message:
    # imported here: start-up time
    from arael.sketch.exchange.files import write
    from arael.sketch.exchange.sheet import SHEETS

    sheet, date = message.get("sheet"), str(message.get("date") or "")[:40]
    if sheet is not None and sheet not in SHEETS:
        expected = f"expected one of {', '.join(SHEETS)} as `sheet`"
        raise AraelError(Diagnostic("E1401", f"message `file`: {expected}"))
    write(shared.session.document, path, sheet=sheet, title=Path(name).stem, date=date)
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return {**_answer(f"Exported {name}", name=name), "file": {"name": name, "data": data}}


def _import(shared: SharedSketch, window: Window, path: Path, name: str) -> Message:
    # imported here: start-up time
    from arael.sketch.exchange.files import read

    found = read(path)
    document = found if isinstance(found, Document) else found.document
    session = shared.session
    with session.document.transaction(f"import {name}"):
        names = take_over(session, document)
    shared.publish(window.name, f"import {name}")
    entities = [names[one] for one in document.entities]
    suggestions = [] if isinstance(found, Document) else list(found.suggestions)
    count = len(entities)
    reply = _answer(
        f"Imported {name}: {count} entit{'y' if count == 1 else 'ies'}",
        suggestions=[suggested(one, names) for one in suggestions],
    )
    reply["names"] = reply["created"] = entities
    reply["notes"] = [str(note) for note in getattr(found, "notes", ())]
    return reply
