"""A session: an editor, and what only the command language knows: variables, cursor, selection."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from arael.diagnostics.records import AraelError, Source, Span
from arael.diagnostics.suggest import closest
from arael.sketch.commands import table
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.tokens import Statement, fail, lines
from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.document.kinds import PREFIXES
from arael.sketch.expressions.evaluation import NoValueError, Value, evaluate
from arael.sketch.expressions.functions import CONSTANTS
from arael.sketch.expressions.reading import moved
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.expressions.vectors import Vec

if TYPE_CHECKING:
    from arael.sketch.editing.editor import Editor

Variable = str | float | Vec
"""A name that stands for another one, a number, or a coordinate."""

MAX_VARIABLES = 10_000
"""Variables of a session."""

MAX_DEPTH = 8
"""Commands within commands: ``explain what_if explain ...``."""

_ASSIGNMENT = re.compile(
    r"(?P<let>let\s+)?(?P<names>[A-Za-z_]\w*(?:\s*,\s*[A-Za-z_]\w*)*)\s*=(?![=])\s*"
)
_RESERVED = frozenset({"cursor", "selection", "all", "let", "_cursor", "_tangent"})


@dataclass
class View:
    """What faces show.

    Attributes
    ----------
    center : of the view; None for the middle of everything
    zoom : relative to the size at which everything fits
    version : grows with every command on the view, so that a face knows when to follow
    """

    center: tuple[float, float] | None = None
    zoom: float = 1.0
    version: int = 0


_T = TypeVar("_T")


@dataclass
class State:
    """What a failed command line puts back besides the document.

    Attributes
    ----------
    variables : by name
    last : what the last command created: ``_0``, ``_1``, ...
    main : ``_``
    cursor : where the next relative coordinate starts; None before it is set
    cursor_shown : whether faces draw it
    tangent : unit vector at the cursor, of the entity that ends there
    chain : end of the last line or arc, from which ``add_line`` with one point goes on
    selection : handles and names, in the order of selection
    view : what faces show
    timing : whether the time of every line is printed
    settings : switches, by name
    """

    variables: dict[str, Variable] = field(default_factory=dict)
    last: tuple[str, ...] = ()
    main: str = ""
    cursor: Vec | None = None
    cursor_shown: bool = False
    tangent: Vec | None = None
    chain: Vec | None = None
    selection: dict[str, None] = field(default_factory=dict)
    view: View = field(default_factory=View)
    timing: bool = False
    settings: dict[str, bool] = field(default_factory=lambda: {"structural_dof": True})

    def copy(self) -> State:
        """The same, independent of later changes."""
        return replace(
            self,
            variables=dict(self.variables),
            selection=dict(self.selection),
            view=replace(self.view),
            settings=dict(self.settings),
        )


class Session:
    """Runs command lines on an editor.

    Parameters
    ----------
    editor : what the commands change; a new sketch if None
    folder : files of commands stay below it; the working folder if None
    make_editor : how an editor is made for another document (``load``, ``clear``)

    Attributes
    ----------
    state : `State`
    statement : the command that runs now
    after_line : called after every command line, for faces that show the sketch
    """

    def __init__(
        self,
        editor: Editor | None = None,
        folder: str | Path | None = None,
        make_editor: Callable[[Document], Editor] | None = None,
    ) -> None:
        self.make_editor = make_editor or _make_editor
        self.editor = editor if editor is not None else self.make_editor(Document())
        self.folder = Path(folder) if folder is not None else Path.cwd()
        self.state = State()
        self.statement: Statement | None = None
        self.after_line: Callable[[], None] | None = None
        self._depth = 0

    @property
    def document(self) -> Document:
        """The sketch."""
        found: Document = self.editor.document
        return found

    @property
    def scope(self) -> SessionScope:
        """What names mean now: variables, then those of the document."""
        return SessionScope(self)

    # --- running ----------------------------------------------------------------------------

    def run(self, text: str, name: str = "command") -> list[Reply]:
        """Run command lines; each is one step of undo, made whole or not at all.

        Parameters
        ----------
        name : of the text, in messages

        Raises
        ------
        AraelError
            At the first line that fails, with its place; lines before it stay.
        """
        return [reply for line in lines(Source(name, text)) for reply in self.run_line(line)]

    def run_line(self, line: list[Statement]) -> list[Reply]:
        """Run the commands of one line, all or none."""
        kept = self.state.copy()
        try:
            if any(self._is_outside(one) for one in line):
                return [self._alone(one) for one in line]
            label = "; ".join(one.text for one in line)
            with self.document.transaction(label):
                return [self._run(one) for one in line]
        except BaseException:
            self.state = kept
            raise
        finally:
            if self.after_line is not None:
                self.after_line()

    def _alone(self, statement: Statement) -> Reply:
        if self._is_outside(statement):
            return self._run(statement)
        with self.document.transaction(statement.text):
            return self._run(statement)

    def _is_outside(self, statement: Statement) -> bool:
        found = table.find(_first_word(statement.text))
        return found is not None and found.outside

    def _run(self, statement: Statement) -> Reply:
        self.statement = statement
        start, names = statement.start, ()
        found = _ASSIGNMENT.match(statement.source.text, statement.start, statement.end)
        if found is not None:
            return self._assign(statement, found)
        if _first_word(statement.text) == "let":
            fail("E1251", "`let` without a value", statement.span, "", "write `let name = value`")
        reply = self.call(statement, start)
        self._remember(reply, names)
        return reply

    def call(self, statement: Statement, start: int) -> Reply:
        """Run the command that begins at `start` of a statement.

        Raises
        ------
        AraelError
            E1250: there is no such command; whatever the command refuses.
        """
        text = statement.source.text
        word = _first_word(text[start : statement.end])
        span = Span(statement.source, start, start + len(word))
        found = table.find(word)
        if found is None:
            self._no_command(word, span)
        if self._depth >= MAX_DEPTH:
            fail("E1260", f"commands within commands, more than {MAX_DEPTH} deep", span)
        self._depth += 1
        try:
            words = Words(self, found, span, statement)
            reply = found.function(self, words)
            words.end()
            return reply
        except (AraelError, ValueError) as error:
            self._refuse(error, statement, start, found.name, span)
        finally:
            self._depth -= 1

    @staticmethod
    def _refuse(
        error: AraelError | ValueError, statement: Statement, start: int, command: str, span: Span
    ) -> NoReturn:
        if isinstance(error, AraelError):
            raise _with_place(error, statement, start) from None
        # imported here: start-up time
        from arael.sketch.geometry.vectors import DegenerateError

        if not isinstance(error, DegenerateError):
            raise error
        fail("E1220", f"`{command}` needs geometry with an extent: {error}", span)

    def _no_command(self, word: str, span: Span) -> NoReturn:
        near = closest(word, table.words())
        hint = f"did you mean `{near[0]}`?" if near else "`help` lists the commands"
        if self.document.find(self.resolve(word).partition(".")[0]) is not None:
            hint = f"`info {word}` shows what it is"
        fail("E1250", f"no command `{word[:60]}`", span, "", hint)

    # --- variables --------------------------------------------------------------------------

    def _assign(self, statement: Statement, found: re.Match[str]) -> Reply:
        source = statement.source
        at = found.start("names")
        names: list[tuple[str, Span]] = []
        for part in re.finditer(r"[A-Za-z_]\w*", found["names"]):
            span = Span(source, at + part.start(), at + part.end())
            self._require_free(part[0], span)
            names.append((part[0], span))
        start = found.end()
        rest = source.text[start : statement.end]
        if not rest:
            fail("E1251", "nothing follows `=`", statement.span, "", "write `name = value`")
        if table.find(_first_word(rest)) is not None:
            reply = self.call(statement, start)
            self._remember(reply, names)
            return reply
        if len(names) > 1:
            fail(
                "E1269",
                f"{len(names)} names for one value",
                names[1][1],
                "",
                "several names take what a command creates: `a, b = split L0 by L1`",
            )
        words = Words.of_text(self, statement, start)
        if len(words) > 1 and re.fullmatch(r"[a-z]\w*", words.items[0].text):
            self._no_command(words.items[0].text, words.items[0].span)
        value = self.value(words)
        self._set(names[0][0], value, names[0][1])
        return Reply(f"{names[0][0]} = {described(value)}", remembered=False)

    def value(self, words: Words) -> Variable:
        """Value of the only word: a name of something, a number or a coordinate."""
        token = words.next("a value")
        words.end()
        named = self.resolve(token.text)
        if self.document.find(named) is not None and named not in self.document.parameters:
            return named
        return words.coordinate_or_number(token)

    def _require_free(self, name: str, span: Span) -> None:
        reason = ""
        parts = split_handle(name)
        if parts is not None and name.rstrip("0123456789") in PREFIXES:
            reason = "it is a name of entities, constraints and dimensions"
        elif name in _RESERVED or name in CONSTANTS or re.fullmatch(r"_\d*", name):
            reason = "it has a meaning of its own"
        elif name in self.document.parameters:
            reason = "there is a parameter of this name"
        elif self.document.find(name) is not None:
            reason = "something in the sketch has this name"
        if reason:
            fail("E1255", f"`{name}` cannot be a variable: {reason}", span, "", "choose another")

    def _set(self, name: str, value: Variable, span: Span) -> None:
        if name not in self.state.variables and len(self.state.variables) >= MAX_VARIABLES:
            fail("E1260", f"more than {MAX_VARIABLES:,} variables", span)
        self.state.variables[name] = value

    def _remember(self, reply: Reply, names: Any) -> None:
        if reply.remembered and reply.names:
            self.state.last = reply.names
            self.state.main = reply.main or reply.names[0]
        if not names:
            return
        given = reply.names if len(names) > 1 else ((reply.main or "", *reply.names)[:2])
        given = tuple(filter(None, given)) if len(names) == 1 else given
        if len(given) < len(names):
            word = "nothing" if not given else f"{len(given)}"
            message = f"{len(names)} names, but the command made {word}"
            fail("E1269", message, names[len(given)][1])
        for (name, span), value in zip(names, given, strict=False):
            self._set(name, value, span)

    def resolve(self, text: str) -> str:
        """A handle or name with the variable at its beginning put in place; `_` and `_0` too."""
        name, dot, rest = text.partition(".")
        found = self.variable(name)
        return f"{found}{dot}{rest}" if isinstance(found, str) else text

    def variable(self, name: str) -> Variable | None:
        """Value of a variable, None if there is none of this name, or something is called so."""
        state, document = self.state, self.document
        if name in document.entities or name in document.dimensions:
            return None
        if name == "_":
            return state.main or None
        if name.startswith("_") and name[1:].isdigit() and name not in state.variables:
            number = int(name[1:]) if len(name) < 8 else len(state.last)
            return state.last[number] if number < len(state.last) else None
        return state.variables.get(name)

    def evaluate(self, text: str, span: Span) -> Value:
        """Value of an expression at a place of the command line; AraelError with that place."""
        try:
            return evaluate(text, self.scope)
        except AraelError as error:
            raise moved(error, span.source, span.start) from None

    # --- cursor and selection -----------------------------------------------------------------

    def move_cursor(self, at: Vec, tangent: Vec | None = None, chain: bool = True) -> None:
        """Set the cursor behind something that was created; `chain`: lines go on from there."""
        self.state.cursor = at
        self.state.tangent = tangent
        if chain:
            self.state.chain = at

    @property
    def selection(self) -> list[str]:
        """What is selected and still there."""
        gone = [one for one in self.state.selection if not self._exists(one)]
        for one in gone:
            del self.state.selection[one]
        return list(self.state.selection)

    def _exists(self, name: str) -> bool:
        return self.document.find(name.partition(".")[0]) is not None

    @contextmanager
    def dry_run(self) -> Iterator[None]:
        """Take everything back at the end: document and session."""
        kept = self.state.copy()
        try:
            yield
        finally:
            self.state = kept


class SessionScope(DocumentScope):
    """Names in commands: variables, the cursor, and those of the document."""

    def __init__(self, session: Session) -> None:
        super().__init__(session.document, measure_of(session.editor))
        self.session = session

    def value(self, path: str) -> Value:
        """Value of a name; raises `NoValueError`."""
        name, dot, rest = path.partition(".")
        own: Variable | None
        if name in ("cursor", "_cursor", "_tangent"):
            own = self._cursor(name)
        else:
            own = self.session.variable(name)
        if own is None:
            return super().value(path)
        if isinstance(own, str):
            return super().value(f"{own}{dot}{rest}")
        if not dot:
            return own
        if isinstance(own, Vec) and rest in ("x", "y"):
            return own.x if rest == "x" else own.y
        what = "a coordinate: it has `x` and `y`" if isinstance(own, Vec) else "a number"
        raise NoValueError(f"`{name}` is {what}")

    def operand(self, path: str) -> Any:
        """What a geometric function reads by a name."""
        found = self.session.resolve(path)
        if found == path and (
            self.session.variable(path.partition(".")[0]) is not None or path in ("cursor",)
        ):
            return self.value(path)
        return super().operand(found) if not path.startswith("_c") else self.value(path)

    def quantity(self, path: str) -> str:
        """Whether a name is an angle in degrees."""
        return super().quantity(self.session.resolve(path))

    def names(self) -> list[str]:
        """Names that something has, for suggestions."""
        return [*self.session.state.variables, *super().names()]

    def unknown(self, name: str) -> NoValueError:
        """The error of a name that nothing has."""
        if name == "_" or (name.startswith("_") and name[1:].isdigit()):
            return NoValueError(f"`{name}` stands for nothing: the last command made no such thing")
        near = closest(name, self.names())
        help_ = f"did you mean `{near[0]}`?" if near else f"set it first: `{name} = 5`"
        return NoValueError(f"no variable, parameter, dimension or entity `{name[:60]}`", help_)

    def _cursor(self, name: str) -> Vec:
        state = self.session.state
        found = state.tangent if name == "_tangent" else state.cursor
        if found is None and name == "_tangent":
            raise NoValueError(
                "there is no tangent: nothing ends at the cursor", "add a line or an arc", "E1259"
            )
        if found is None:
            raise NoValueError("the cursor is not set", "set it: `cursor 0,0`", "E1259")
        return found


def measure_of(editor: Any) -> Callable[[Any], float]:
    """How an editor measures a dimension."""
    return lambda d: float(editor.measure(d.kind, d.args, d.mode))


def described(value: Variable) -> str:
    """A value of a variable for people."""
    if isinstance(value, Vec):
        return place(value.x, value.y)
    return shown(value) if isinstance(value, float) else str(value)


def _with_place(error: AraelError, statement: Statement, start: int) -> AraelError:
    """The same error; what has no place in a text is put at the command."""
    span = Span(statement.source, start, statement.end)
    return AraelError(
        [d if d.span or d.origin else replace(d, span=span) for d in error.diagnostics]
    )


def _first_word(text: str) -> str:
    return (text.split(None, 1) or [""])[0]


def _make_editor(document: Document) -> Editor:
    # imported here: start-up time
    from arael.sketch.editing.editor import Editor
    from arael.sketch.groups.patterns import follow

    editor = Editor(document)
    editor.followers.append(follow)
    return editor
