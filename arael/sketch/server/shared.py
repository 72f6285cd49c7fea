"""The document of all windows: what one of them changes, every one is sent."""

from __future__ import annotations

import secrets
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.sketch.commands import table
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session, State
from arael.sketch.commands.tokens import Statement, lines
from arael.sketch.document.document import Document
from arael.sketch.editing.editor import Editor
from arael.sketch.server import records
from arael.sketch.server.answers import answer, refusal
from arael.sketch.server.differences import Moment, difference, make
from arael.sketch.server.dragging import OpenDrag
from arael.sketch.server.keeping import Keeper
from arael.sketch.server.permissions import Permissions
from arael.sketch.server.protocol import DragTo, json_message
from arael.sketch.server.requests import HANDLERS
from arael.sketch.server.verdicts import verdict
from arael.sketch.server.windows import Actor, Link, Window
from arael.version import __version__

MAX_WINDOWS = 32
"""Windows on one document."""

MAX_KEPT = 256
"""Changes that are kept for windows that connect again."""

MAX_KEPT_BYTES = 8 * 1024 * 1024
"""Bytes of those changes."""

MAX_TITLES = 200
"""Steps of the history that pages are sent."""

RESTS_AFTER = 0.05
"""Seconds without a new place after which the pointer rests."""

VERDICT_BROKEN_OFF = (
    "broken off: what is free or redundant is shown as it was; it is looked at again at the next "
    "command"
)

MAX_STATES = 64
"""Windows whose variables and selection are kept after they close."""


class SharedSketch:
    """A sketch that several windows show and change.

    All methods but `interrupt` are called by one thread at a time (`Worker`).

    Parameters
    ----------
    session : of the sketch
    keeper : of the file, None for a sketch without one

    Attributes
    ----------
    revision : grows with every change
    is_running : whether a command of a window or agent runs
    windows : that are open, by name
    permissions : what a person allows agents
    """

    def __init__(self, session: Session, keeper: Keeper | None = None) -> None:
        self.session = session
        self.keeper = keeper
        self.windows: dict[str, Window] = {}
        self.revision = secrets.randbelow(1 << 30) + 1  # unlike that of an earlier server
        self.agents = 0
        self.permissions = Permissions(self.send)
        self.is_running = False
        self._moment = Moment.of(session.document)
        self._kept: deque[tuple[int, bytes]] = deque()
        self._kept_bytes = 0
        self._states: dict[str, State] = {}
        self._drag: OpenDrag | None = None
        self._rests_at = 0.0
        self._judged = -1
        self._unjudged = False  # the last verdict was broken off
        self._titles: tuple[tuple[str, ...], tuple[str, ...]] | None = None
        self._break = False
        session.make_editor = self._take

    # --- windows ----------------------------------------------------------------------------

    def open(self, name: str, link: Link, since: int = -1) -> Window:
        """A page connects.

        Parameters
        ----------
        name : made by the page; the same after it was disconnected
        since : the revision that it has, -1 for none: it is sent what changed since, or everything

        Raises
        ------
        AraelError
            E1403: too many windows
        """
        name = name[:64]
        known = self.windows.pop(name, None)
        if known is not None:
            self._end_drag_of(known)
        elif len(self.windows) >= MAX_WINDOWS:
            raise AraelError(
                Diagnostic(
                    "E1403",
                    f"more than {MAX_WINDOWS} windows on one sketch",
                    help=("close one of them",),
                )
            )
        window = Window(name, link, known.state if known else self._states.pop(name, State()))
        self.windows[name] = window
        window.send(
            {
                "type": "hello",
                "revision": self.revision,
                "unit": self.session.document.unit,
                "file": self.keeper.path.name if self.keeper else "",
                "readonly": self.keeper.read_only if self.keeper else "",
                "version": __version__,
            },
            self.revision,
        )
        missed = self._missed(since)
        if missed is None:
            self.send_snapshot(window)
        else:
            for message in missed:
                window.link.send(message)
            window.shown = self._moment.values
        window.send(self._history())
        for content in self.permissions.messages():
            window.send(content)
        self._judged = -1
        self.send_presence()
        return window

    def close(self, window: Window) -> None:
        """A page is gone; a drag of it is taken back."""
        if self.windows.get(window.name) is not window:
            return
        self._end_drag_of(window)
        del self.windows[window.name]
        self._states[window.name] = window.state
        while len(self._states) > MAX_STATES:
            del self._states[next(iter(self._states))]
        self.send_presence()

    def send_snapshot(self, window: Window) -> None:
        """Send the whole document."""
        message = records.snapshot(
            self.session.document, self.revision, self.session.document.settings
        )
        window.send(message, self.revision)
        window.shown = self.session.document.values.copy()

    def send_presence(self) -> None:
        """Tell every page how many there are."""
        self.send({"type": "presence", "windows": len(self.windows), "agents": self.agents})

    def send(self, content: dict[str, Any]) -> None:
        """Send a message to every window."""
        data = json_message(content, self.revision)
        for window in self.windows.values():
            window.link.send(data)

    def _missed(self, since: int) -> list[bytes] | None:
        """Changes after a revision; None if they are not known any more."""
        if since == self.revision:
            return []
        found = [message for before, message in self._kept if before >= since]
        return found if any(before == since for before, _ in self._kept) else None

    # --- messages of pages --------------------------------------------------------------------

    def receive(self, window: Window, message: DragTo | dict[str, Any]) -> None:
        """Answer a message of a page."""
        if isinstance(message, DragTo):
            self._drag_to(window, message)
            return
        number = message.get("id")
        handler = HANDLERS.get(message["type"])
        try:
            if handler is None:
                kind = str(message["type"])[:40]
                raise AraelError(Diagnostic("E1401", f"no message of type `{kind}`"))
            found = handler(self, window, message)
        except AraelError as error:
            found = refusal(error, self.session.document)
        except Exception as error:  # a mistake of arael: the document is as it was before
            traceback.print_exc(file=sys.stderr)
            found = refusal(internal(error), self.session.document)
        if found is None:
            return
        try:
            window.send({"type": "reply", "id": number, **found}, self.revision)
        except (TypeError, ValueError, NotImplementedError) as error:  # not JSON
            traceback.print_exc(file=sys.stderr)
            found = refusal(internal(error), self.session.document)
            window.send({"type": "reply", "id": number, **found}, self.revision)

    # --- commands -----------------------------------------------------------------------------

    def run(
        self,
        actor: Actor,
        by: str,
        text: str,
        extras: Sequence[str] = (),
        step: str = "",
    ) -> dict[str, Any]:
        """Run command lines, and send what changed to every window.

        Parameters
        ----------
        actor : whose variables, cursor and selection the commands use
        by : a window's name, ``agent`` or ``script``
        extras : commands that are tried after `text`, and left out if they are refused
        step : title of one step of undo for everything; empty: one per line

        Returns
        -------
        The reply, as `answer` or `refusal`.
        """
        self._finish_drag()
        if self._unjudged:
            self._unjudged, self._judged = False, -1
        names = self._names()
        session = self.session
        state = actor.state
        view, selection = state.view.version, list(state.selection)
        ran: list[Reply] = []
        left_out: list[str] = []
        failed: AraelError | None = None
        with self.acting(actor):
            try:
                self._check_break()
                self._run(text, extras, step, ran, left_out)
            except AraelError as error:
                failed = error
            except Exception as error:  # a mistake of arael: the line is taken back
                traceback.print_exc(file=sys.stderr)
                failed = internal(error)
        found = answer(ran) if failed is None else refusal(failed, session.document)
        found["created"] = [name for name in self._names() if name not in names]
        found["notes"] = [*found["notes"], *left_out]
        self.publish(by, step or _title(text))
        self._follow(by, actor.state, view, selection)
        for one in ran:
            if "message" in one.data:
                self.send({"type": "message", "level": "info", "text": str(one.data["message"])})
        return found

    def query(self, actor: Actor, text: str) -> dict[str, Any]:
        """Run a command that changes nothing; a drag goes on meanwhile."""
        with self.acting(actor):
            return answer(self.session.run(text))

    @contextmanager
    def acting(self, actor: Actor) -> Iterator[None]:
        """Put the state of an actor into the session, and the session's own back.

        What is done meanwhile can be broken off, questions too.
        """
        session = self.session
        own, session.state = session.state, actor.state
        self.is_running = True
        try:
            with session.editor.solver.question():
                yield
        finally:
            self.is_running = False
            # A command that fails puts another state in place.
            actor.state, session.state = session.state, own

    def _run(
        self, text: str, extras: Sequence[str], step: str, ran: list[Reply], left_out: list[str]
    ) -> None:
        session = self.session
        found = list(lines(Source("command", text)))
        if not step and not extras:
            for line in found:
                self._check_break()
                ran += session.run_line(line)
            return
        outside = next((one for line in found for one in line if _is_outside(one)), None)
        if outside is not None:
            word = outside.text.split(None, 1)[0]
            raise AraelError(
                Diagnostic(
                    "E1404",
                    f"`{word}` cannot be a part of one step of undo",
                    outside.span,
                    help=("run it by itself",),
                )
            )
        kept = session.state.copy()
        try:
            with session.document.transaction(step or _title(text)):
                for line in found:
                    self._check_break()
                    ran += session.run_line(line)
                for extra in extras:
                    self._try(extra, left_out)
        except BaseException:
            session.state = kept
            raise

    def _try(self, extra: str, left_out: list[str]) -> None:
        """Run a command that may be refused; what `_` stands for stays."""
        session = self.session
        last, main = session.state.last, session.state.main
        try:
            for line in lines(Source("command", extra)):
                if not any(_is_outside(one) for one in line):
                    session.run_line(line)
        except AraelError as error:
            left_out.append(f"left out: {extra}: {error.diagnostics[0].message}")
        session.state.last, session.state.main = last, main

    def _check_break(self) -> None:
        if self._break:
            raise broken_off()

    def interrupt(self) -> None:
        """Break off what runs, and commands until `resume`; by any thread."""
        self._break = True
        self.session.editor.solver.interrupt()

    def resume(self) -> None:
        """Commands run again."""
        self._break = False

    def _follow(self, by: str, state: State, view: int, selection: list[str]) -> None:
        """Send the view and selection that commands set to the window that ran them."""
        window = self.windows.get(by)
        if window is None:
            return
        message: dict[str, Any] = {}
        if state.view.version != view:
            message |= {
                "center": state.view.center,
                "zoom": state.view.zoom,
                "fit": state.view.center is None and state.view.zoom == 1.0,
            }
        if list(state.selection) != selection:
            message["selection"] = list(state.selection)
        if message:
            cursor = state.cursor
            message["cursor"] = [cursor.x, cursor.y] if cursor and state.cursor_shown else None
            window.send({"type": "view", **message})

    def _names(self) -> dict[str, None]:
        document = self.session.document
        return dict.fromkeys(
            [*document.entities, *document.constraints, *document.dimensions, *document.groups]
        )

    def _take(self, document: Document) -> Editor:
        """Put a document that was loaded in the place of this one, as one step of undo."""
        editor = self.session.editor
        mine = editor.document
        empty = Moment({name: {} for name in self._moment.tables}, mine.values[:0], {})
        with mine.transaction("load"):
            for kind in ("groups", "dimensions", "constraints", "parameters", "entities"):
                for name in reversed(list(getattr(mine, kind))):
                    mine.remove(kind, name)
            for key in list(mine.settings):
                if key not in document.settings and key != "unit":
                    mine.set_setting(key, None)
            make(mine, difference(empty, Moment.of(document)), "load")
        return editor

    # --- changes ------------------------------------------------------------------------------

    def publish(self, by: str, title: str) -> None:
        """Keep what changed in the journal, then send it to every window."""
        document = self.session.document
        moment = Moment.of(document)
        found = difference(self._moment, moment)
        if found:
            before = self.revision
            self.revision += 1
            self._moment = moment
            if self.keeper is not None:
                problem = self.keeper.note(title, found)
                if problem:
                    self.send({"type": "message", "level": "error", "text": problem})
            message = records.change(
                found, moment.values, revision=self.revision, since=before, by=by, title=title
            )
            data = json_message(message, self.revision)
            self._keep(before, data)
            for window in self.windows.values():
                window.link.send(data)
                window.shown = moment.values
        self._send_history()

    def _keep(self, before: int, data: bytes) -> None:
        self._kept.append((before, data))
        self._kept_bytes += len(data)
        while len(self._kept) > MAX_KEPT or self._kept_bytes > MAX_KEPT_BYTES:
            self._kept_bytes -= len(self._kept.popleft()[1])

    def _history(self) -> dict[str, Any]:
        history = self.session.document.history
        done = [one.label for one in history.done[-MAX_TITLES:]]
        undone = [one.label for one in history.undone[: -MAX_TITLES - 1 : -1]]
        return {
            "type": "history",
            "done": done,
            "undone": undone,
            "position": history.position,
        }

    def _send_history(self) -> None:
        message = self._history()
        now = (tuple(message["done"]), tuple(message["undone"]))
        if now != self._titles:
            self._titles = now
            self.send(message)

    # --- drags --------------------------------------------------------------------------------

    def begin_drag(self, window: Window, handles: Sequence[str], at: tuple[float, float]) -> None:
        """The pointer of a window takes hold of something."""
        self._finish_drag()
        window.sequence = 0
        self._drag = OpenDrag(self.session.editor, window, handles, at)

    def _drag_to(self, window: Window, place: DragTo) -> None:
        drag = self._drag
        window.sequence = place.sequence
        if drag is None or drag.window is not window:
            # Another change ended the drag: the page is answered, so that it goes on.
            window.send_frame(self._moment.values, self.revision)
            return
        self._frame(drag, lambda: drag.to(place.x, place.y))

    def _frame(self, drag: OpenDrag, move: Callable[[], NDArray[np.float64]]) -> None:
        """Make a frame of a drag and send it."""
        window = drag.window
        self._rests_at = time.monotonic() + RESTS_AFTER
        try:
            values = move()
        except AraelError:  # broken off: everything stays where it is
            values = self.session.document.values.copy()
        except Exception as error:  # a mistake of arael: the drag is taken back
            traceback.print_exc(file=sys.stderr)
            self._finish_drag(cancel=True)
            text = internal(error).diagnostics[0].message
            window.send({"type": "message", "level": "error", "text": text})
            values = self.session.document.values.copy()
        window.send_frame(values, self.revision)
        for other in self.windows.values():
            if other is not window and not other.link.is_behind:
                other.send_frame(values, self.revision)

    def end_drag(self, window: Window, cancel: bool) -> None:
        """The pointer of a window lets its drag end, as one step of undo or as nothing."""
        if self._drag is not None and self._drag.window is window:
            self._finish_drag(cancel)

    def _end_drag_of(self, window: Window) -> None:
        if self._drag is not None and self._drag.window is window:
            self._finish_drag(cancel=True)

    def _finish_drag(self, cancel: bool = False) -> None:
        """End the drag that is open, if there is one; every window shows the same afterwards."""
        drag, self._drag = self._drag, None
        if drag is None:
            return
        try:
            drag.end(cancel)
        finally:
            values = self.session.document.values.copy()
            for window in self.windows.values():
                window.send_frame(values, self.revision)
            self.publish(drag.window.name, _last_title(self.session.document))

    @property
    def is_dragging(self) -> bool:
        """Whether a drag is open."""
        return self._drag is not None

    @property
    def is_unfinished(self) -> bool:
        """Whether a drag is open whose last frame was cut short."""
        return self._drag is not None and self._drag.unfinished

    # --- when nothing else is to do -----------------------------------------------------------

    def idle(self) -> float | None:
        """Work for the time between messages; seconds until there is more, None for never."""
        if self._drag is not None:
            return self._go_on(self._drag)
        if self._judged != self.revision and self.windows:
            self._judged = self.revision
            try:
                with self.session.editor.solver.question():
                    found = verdict(self.session.editor, self.revision)
                self.send(found)
            except Exception as error:  # the page keeps its colours
                self._not_judged(error)
            return 0.0
        return self._save_when_due()

    def _not_judged(self, error: Exception) -> None:
        """There is no verdict: a person broke it off, or there is a mistake in arael."""
        self.send({"type": "unjudged", "revision": self.revision})
        if isinstance(error, AraelError) and error.diagnostics[0].code == "E1235":
            self._unjudged = True
            self.send({"type": "message", "level": "info", "text": VERDICT_BROKEN_OFF})
        else:
            traceback.print_exception(error, file=sys.stderr)

    def _go_on(self, drag: OpenDrag) -> float | None:
        """The pointer rests: frames that were cut short approach its place."""
        if not drag.unfinished:
            return None
        wait = self._rests_at - time.monotonic()
        if wait > 0.0:
            return wait
        rests_at = self._rests_at
        self._frame(drag, drag.go_on)
        self._rests_at = rests_at
        return 0.0

    def _save_when_due(self) -> float | None:
        keeper = self.keeper
        if keeper is None or not keeper.is_due:
            return None
        wait = keeper.due - time.monotonic()
        if wait > 0.0:
            return wait
        self.save()
        return None

    def save(self) -> str:
        """Write the file, if there is one; why it cannot be, empty if it was written."""
        keeper = self.keeper
        if keeper is None:
            return ""
        problem = keeper.save(self.session.document)
        if problem:
            self.send({"type": "message", "level": "error", "text": problem})
        else:
            self.send({"type": "saved", "revision": self.revision, "file": keeper.path.name})
        return problem

    def finish(self) -> None:
        """End: a drag is taken back, the file is written."""
        self._finish_drag(cancel=True)
        if self.keeper is not None:
            self.keeper.close(self.session.document)

    @property
    def folder(self) -> Path:
        """Files of commands stay below it."""
        return self.session.folder


def internal(error: Exception) -> AraelError:
    """E1409: a mistake of arael itself."""
    return AraelError(
        Diagnostic(
            "E1409",
            f"a mistake in arael: {type(error).__name__}: {str(error)[:200]}",
            notes=("the sketch is as it was before",),
            help=("save the sketch and report it, with the command",),
        )
    )


def broken_off() -> AraelError:
    """E1405: broken off by a person."""
    return AraelError(Diagnostic("E1405", "broken off", notes=("the line that ran is undone",)))


def _is_outside(statement: Statement) -> bool:
    found = table.find((statement.text.split(None, 1) or [""])[0])
    return found is not None and found.outside


def _title(text: str) -> str:
    """A title of a step from its commands."""
    first, _, rest = text.strip().partition("\n")
    return f"{first[:200]} ..." if rest.strip() else first[:200]


def _last_title(document: Document) -> str:
    done = document.history.done
    return done[-1].label if done else ""
