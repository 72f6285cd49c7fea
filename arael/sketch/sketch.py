"""The sketch editor in Python: methods with the names and words of the commands."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsFloat

from arael.diagnostics.arguments import fail
from arael.sketch.commands import table
from arael.sketch.commands.numbers import exact
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.tokens import quoted
from arael.sketch.document.document import Document
from arael.sketch.document.texts import problem_of
from arael.sketch.methods import Argument, Commands
from arael.sketch.things import AnyThing, EntityThing, Point, Thing, thing

if TYPE_CHECKING:
    from arael.sketch.notebook import SketchWidget

_RANGE = re.compile(r"\s*(>=|<=)\s*(\S.*)\Z", re.DOTALL)
_BETWEEN = re.compile(r"(\S.*?)\s+to\s+(\S.*)\Z", re.DOTALL)
_SAFE = re.compile(r"[^\s;#\"]+\Z")


class Sketch(Commands):
    """A parametric sketch.

    Every command is a method: ``sketch.add_line((0, 0), (5, 0))``, ``sketch.length("L0", 12)``.
    Arguments are those of the command: numbers, texts, pairs for coordinates, and the objects that
    other methods returned. Words at the end of a command are keyword arguments: ``noconnect=True``.
    Commands that make something return it (several as a tuple); others a mapping of what they
    found, or the text that they say.

    Parameters
    ----------
    path : of a saved sketch to begin with
    folder : files named in commands of `run` stay below it; the working folder if None

    Raises
    ------
    AraelError
        What a command refuses; the sketch is as it was before.
    """

    def __init__(self, path: str | Path | None = None, *, folder: str | Path | None = None) -> None:
        self.session = Session(folder=folder)
        self._widget: SketchWidget | None = None
        if path is not None:
            self.load(path)

    @property
    def document(self) -> Document:
        """The sketch as data."""
        return self.session.document

    @property
    def editor(self) -> Any:
        """What changes the document: it validates, solves and judges."""
        return self.session.editor

    @property
    def entities(self) -> tuple[EntityThing, ...]:
        """Geometry, in the order it was made."""
        return tuple(EntityThing(self, name) for name in self.document.entities)

    def run(self, text: str, name: str = "command") -> list[Reply]:
        """Run command lines; each is one step of undo."""
        return self.session.run(text, name)

    @contextmanager
    def dragging(self, *points: str | Point) -> Iterator[Any]:
        """A drag frame by frame: ``with sketch.dragging("L3.p2") as drag: drag.to((4, 5))``.

        One step of undo. `to` takes one place per point, `by` a vector for all.
        """
        handles = [self.session.resolve(str(point)) for point in points]
        with self.editor.dragging(handles) as drag:
            yield drag

    def __getitem__(self, name: str) -> AnyThing | Point:
        """What has a name, or the point of a handle; KeyError if there is none."""
        resolved = self.session.resolve(name)
        if "." in resolved:
            self.document.point_at(resolved)
            return Point(self, resolved)
        return thing(self, resolved)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self.document.find(self.session.resolve(name)) is not None

    def __iter__(self) -> Iterator[EntityThing]:
        return iter(self.entities)

    def __len__(self) -> int:
        return len(self.document.entities)

    def __bool__(self) -> bool:
        return True

    def __repr__(self) -> str:
        document = self.document
        counts = {
            "entities": len(document.entities),
            "constraints": len(document.constraints),
            "dimensions": len(document.dimensions),
        }
        return f"<Sketch: {', '.join(f'{count} {what}' for what, count in counts.items())}>"

    def _repr_svg_(self) -> str:
        """The drawing, for notebooks."""
        # imported here: start-up time
        from arael.sketch.drawing import layout, to_svg

        return to_svg(layout(self.document, dict.fromkeys(self.session.selection, "selected")))

    def edit(self) -> SketchWidget:
        """The editor in a notebook: ``sketch.edit()`` at the end of a cell shows it.

        What is drawn there changes this sketch, and what cells change appears there.

        Raises
        ------
        AraelError
            E1412: anywidget is not installed
        """
        try:
            # imported here: start-up time
            from arael.sketch.notebook import SketchWidget
        except ModuleNotFoundError as error:
            if (error.name or "").startswith("arael"):
                raise
            fail(
                "E1412",
                f"the editor in a notebook needs the module `{error.name}`",
                origin="Sketch.edit",
                help=("`pip install 'arael[notebook]'` brings what it needs",),
            )
        if self._widget is None:
            self._widget = SketchWidget(self)
        return self._widget

    # --- files: a program may name any ------------------------------------------------------

    def save(self, path: str | Path) -> Any:
        """Save the sketch as JSON."""
        return self._with_file("save", path)

    def load(self, path: str | Path) -> Any:
        """Load a saved sketch in place of this one."""
        return self._with_file("load", path)

    def export(self, path: str | Path) -> Any:
        """Write the drawing as DXF, SVG, PDF, PNG, STEP or JSON, by the file's ending."""
        return self._with_file("export", path)

    def import_(self, path: str | Path) -> Any:
        """Add the geometry of a DXF or SVG file."""
        return self._with_file("import", path)

    def _with_file(self, word: str, path: str | Path) -> Any:
        folder = self.session.folder
        given = Path(path).expanduser().absolute()
        self.session.folder = given.parent
        try:
            return self._command(word, (given.name,), {})
        finally:
            self.session.folder = folder

    # --- texts: in quotes, whatever they are ------------------------------------------------

    def add_text(
        self,
        at: Argument,
        text: str,
        *,
        height: Argument | None = None,
        angle: Argument | None = None,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A text, lettered along a line that is its frame.

        Parameters
        ----------
        at : left end of the base line
        text : one line of at most 200 characters
        height : of the capitals; 3.5 mm by default
        angle : of the base line, in degrees
        """
        words: list[Argument] = [at, _quoted(text, "add_text")]
        for name, value in (("height", height), ("angle", angle)):
            words += [] if value is None else [name, value]
        flags = dict(noconnect=noconnect, nocursor=nocursor, quiet=quiet, constr=constr)
        return self._command("add_text", words, flags)

    def set_text(self, first: Argument, *others: Argument) -> Any:
        """Change what texts read: the texts, and last what they are to read."""
        *texts, text = first, *others
        return self._command("set_text", [*texts, _quoted(text, "set_text")], {})

    # --- commands ---------------------------------------------------------------------------

    def _command(
        self, word: str, arguments: Sequence[Argument | None], flags: Mapping[str, bool]
    ) -> Any:
        command = table.find(word)
        assert command is not None
        words = [_text(one, word) for one in arguments if one is not None]
        if command.whole:
            words = [str(one).replace("\n", "\\n") for one in arguments]
        line = " ".join([word, *words, *(flag for flag, on in flags.items() if on)])
        (reply,) = self.session.run(line, word)
        if reply.names:
            found = tuple(thing(self, name) for name in reply.names)
            return found if len(found) > 1 else found[0]
        return reply.data or reply.text


class _Quoted(str):
    """A word of a command that is in quotes already."""

    __slots__ = ()


def _quoted(text: object, word: str) -> str:
    """A text in quotes."""
    problem = problem_of(text) if isinstance(text, str) else f"no text: {type(text).__name__}"
    if not isinstance(text, str) or problem:
        fail("E1285", problem, origin=f"Sketch.{word}")
    return _Quoted(quoted(text))


def _text(argument: object, word: str) -> str:
    """An argument as a word of a command."""
    if isinstance(argument, _Quoted):
        return str(argument)
    if isinstance(argument, str):
        return _written(argument, word)
    if isinstance(argument, Thing | Point):
        return str(argument)
    if isinstance(argument, bool):
        return "on" if argument else "off"
    if isinstance(argument, float | int):  # asking a protocol takes a tenth of a small solve
        return exact(float(argument))
    if isinstance(argument, SupportsFloat) and not isinstance(argument, Iterable):
        return exact(float(argument))
    if isinstance(argument, Iterable):
        parts = [*argument]
        if len(parts) == 2:
            return ",".join(_text(one, word) for one in parts)
    fail(
        "E1252",
        f"`{word}` takes texts, numbers, pairs of numbers and things of the sketch, "
        f"found {type(argument).__name__}",
        origin=f"Sketch.{word}",
    )


def _written(text: str, word: str) -> str:
    """A text as one word, or the words of a range."""
    if _SAFE.match(text) and text[0] not in "<>":
        return text
    if '"' in text or "\n" in text:
        fail("E1252", "a word has no quotes and no line ends", origin=f"Sketch.{word}")
    found = _RANGE.match(text)
    if found:
        return f"{found[1]} {_written(found[2], word)}"
    found = _BETWEEN.match(text)
    if found:
        return f"{_written(found[1], word)} to {_written(found[2], word)}"
    return f'"{text}"'
