"""Arguments of commands: words to handles, coordinates, numbers and keywords."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NoReturn

from arael.diagnostics.records import AraelError, Span
from arael.diagnostics.suggest import closest
from arael.sketch.commands.numbers import exact
from arael.sketch.commands.tokens import Statement, Token, fail, split
from arael.sketch.document.handles import point_offsets, split_handle, takes
from arael.sketch.document.records import Amount, Entity
from arael.sketch.expressions.evaluation import Value, evaluate, require_quantity
from arael.sketch.expressions.functions import CONSTANTS
from arael.sketch.expressions.reading import literal, moved, read
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.expressions.vectors import Vec

if TYPE_CHECKING:
    from arael.sketch.commands.session import Session
    from arael.sketch.commands.table import Command

#: Words for the classes of operands of `arael.sketch.document.kinds.OPERANDS`.
CLASSES = {
    "line": "a line",
    "arc": "a circle or arc",
    "open_arc": "an arc",
    "ellipse": "an ellipse or elliptic arc",
    "round": "a circle, arc or ellipse",
    "spline": "a spline",
    "curve": "a curve",
    "entity": "an entity",
    "point": "a point (`P0`, `L0.p1`, `A0.center`)",
    "end": "the end of a line, arc or spline (`L0.p2`, `A0.start`)",
}

_NUMBER_PAIR = re.compile(
    r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*,"
    r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z",
    re.ASCII,
)


@dataclass(frozen=True, slots=True)
class Operand:
    """An entity, or a point of one, that a word names.

    Attributes
    ----------
    handle : in canonical form: ``L0``, ``L0.p1``, ``P0``
    entity : the entity
    point : name of the point; empty for the entity itself, and for a point entity
    token : the word
    """

    handle: str
    entity: Entity
    point: str
    token: Token

    def fits(self, operand: str) -> bool:
        """Whether it is of a class of `arael.sketch.document.kinds.OPERANDS`."""
        return takes(operand, self.entity, self.point)


@dataclass(frozen=True, slots=True)
class Place:
    """A coordinate that was read.

    Attributes
    ----------
    at : where
    handle : of the point that the word names, else empty
    token : the word
    """

    at: Vec
    handle: str
    token: Token

    @property
    def x(self) -> float:
        """First coordinate."""
        return self.at.x

    @property
    def y(self) -> float:
        """Second coordinate."""
        return self.at.y


#: Names of points, and none.
_POINT = re.compile(r"(?:|p1|p2|pos|start|end|center|pole\d+)\Z")


class Words:
    """The words behind a command, taken one after the other.

    Readers raise AraelError with the place of the word: E1251 if there is none, otherwise what is
    wrong with it.

    Attributes
    ----------
    session, command : which runs
    span : of the command's word
    statement : the whole command
    items : words that have not been taken
    origin : where relative coordinates start: the coordinate read before, else the cursor
    """

    def __init__(
        self, session: Session, command: Command | None, span: Span, statement: Statement
    ) -> None:
        self.session = session
        self.command = command
        self.span = span
        self.statement = statement
        self.origin: Vec | None = session.state.cursor
        self.flags: set[str] = set()
        self.items: list[Token] = []
        self._last_end = span.end
        if command is None or not command.whole:
            self.items = split(statement, span.end, self._is_name)
        self._keywords(command.keywords if command is not None else ())

    @classmethod
    def of_text(cls, session: Session, statement: Statement, start: int) -> Words:
        """Words from `start` of a statement on, without a command before them."""
        return cls(session, None, Span(statement.source, start, start), statement)

    def _is_name(self, name: str) -> bool:
        return self.session.variable(name) is not None or name in self.session.document.parameters

    # --- taking words -----------------------------------------------------------------------

    def _keywords(self, allowed: Sequence[str]) -> None:
        """Take the command's keywords off the end, in any order, into `flags`."""
        while self.items and self.items[-1].text in allowed and not self.items[-1].quoted:
            token = self.items.pop()
            if token.text in self.flags:
                fail("E1267", f"`{token.text}` is given twice", token.span)
            self.flags.add(token.text)

    def refuse_together(self, *names: str) -> None:
        """E1267 if two of these keywords are given."""
        given = [name for name in names if name in self.flags]
        if len(given) > 1:
            message = f"`{given[0]}` and `{given[1]}` exclude each other"
            fail("E1267", message, self.statement.span, "", "leave one of them out")

    def __bool__(self) -> bool:
        return bool(self.items)

    def __len__(self) -> int:
        return len(self.items)

    def peek(self) -> Token | None:
        """The next word, which stays."""
        return self.items[0] if self.items else None

    def next(self, what: str) -> Token:
        """Take the next word; E1251 if there is none."""
        if not self.items:
            self.missing(what)
        token = self.items.pop(0)
        self._last_end = token.span.end
        return token

    def accept(self, *words: str) -> str:
        """Take the next word if it is one of these; else an empty text."""
        if self.items and self.items[0].text in words and not self.items[0].quoted:
            return self.next("").text
        return ""

    def choice(self, what: str, *words: str) -> str:
        """Take one of these words; E1252 if it is another one."""
        token = self.next(what)
        if token.text not in words:
            near = closest(token.text, words)
            hint = f"did you mean `{near[0]}`?" if near else f"write {_or(words)}"
            fail("E1252", f"expected {what}, found `{token.text[:60]}`", token.span, "", hint)
        return token.text

    def rest(self) -> str:
        """The text that follows the command, as it is written."""
        self.items = []
        return self.statement.source.text[self.span.end : self.statement.end].strip()

    def end(self) -> None:
        """E1252 if there are words left."""
        if not self.items:
            return
        token = self.items[0]
        allowed = self.command.keywords if self.command else ()
        near = closest(token.text, [word for word in allowed if word not in self.flags])
        help_ = [f"did you mean `{near[0]}`?"] if near else self._usage()
        fail("E1252", f"`{token.text[:60]}` is not expected here", token.span, "", *help_)

    def missing(self, what: str) -> NoReturn:
        """E1251: something is missing behind the words taken so far."""
        source = self.statement.source
        end = max(self._last_end, self.span.end)
        name = f"`{self.command.name}`" if self.command else "this"
        fail(
            "E1251",
            f"{name} needs {what}",
            Span(source, max(self.span.start, 0), max(end, self.span.start + 1)),
            f"expected {what} after this",
            *self._usage(),
        )

    def _usage(self) -> list[str]:
        if self.command is None:
            return []
        return [f"usage: `{line}`" for line in self.command.usage[:3]]

    # --- handles ----------------------------------------------------------------------------

    def find(self, token: Token) -> Operand | None:
        """The entity or point that a word names, None if it names none."""
        parts = split_handle(self.session.resolve(token.text))
        entity = self.session.document.entities.get(parts.name) if parts else None
        if parts is None or entity is None:
            return None
        if entity.kind == "point" and parts.point in ("", "pos"):
            return Operand(entity.name, entity, "", token)
        if parts.point and parts.point not in point_offsets(entity):
            return None
        return Operand(f"{parts.name}.{parts.point}".rstrip("."), entity, parts.point, token)

    def operand(self, what: str = "", *classes: str) -> Operand:
        """Take an entity or point.

        Parameters
        ----------
        what : in words; made of `classes` if empty
        classes : it is to be of one of these (`arael.sketch.document.kinds.OPERANDS`)

        Raises
        ------
        AraelError
            E1201: no such entity; E1202: it has no such point; E1256: of another class.
        """
        what = what or " or ".join(CLASSES[one] for one in classes) or "an entity or point"
        token = self.next(what)
        return self.require(token, what, *classes)

    def require(self, token: Token, what: str = "", *classes: str) -> Operand:
        """The operand that a word names; AraelError as of `operand`."""
        what = what or " or ".join(CLASSES[one] for one in classes) or "an entity or point"
        found = self.find(token)
        if found is None:
            self._no_operand(token, what)
        if classes and not any(found.fits(one) for one in classes):
            kind = f"a point of {found.entity.name}" if found.point else _a(found.entity.kind)
            message = f"expected {what}, found `{token.text}`, {kind}"
            fail("E1256", message, token.span)
        return found

    def _no_operand(self, token: Token, what: str) -> NoReturn:
        named = self.session.resolve(token.text)
        parts = split_handle(named)
        document = self.session.document
        if (
            named == token.text
            and parts is not None
            and parts.name.rstrip("0123456789") not in ("C", "d", "M")
        ):
            try:
                document.point_at(named) if parts.point else document.entity(named)
            except AraelError as error:
                raise placed(error, token.span) from None
        name = token.text.partition(".")[0]
        near = closest(name, [*self.session.state.variables, *document.entities])
        hint = f"did you mean `{near[0]}`?" if near else "`list` shows what there is"
        variable = self.session.variable(name)
        if isinstance(variable, str) and document.find(variable) is None:
            hint = f"`{name}` is `{variable}`, which is not in the sketch any more"
        elif isinstance(variable, float | Vec):
            hint = f"`{name}` is a {'number' if isinstance(variable, float) else 'coordinate'}"
        fail("E1256", f"expected {what}, found `{token.text[:60]}`", token.span, "", hint)

    def operands(
        self, what: str = "", *classes: str, least: int = 1, whole: bool = False
    ) -> list[Operand]:
        """Take all words up to the first that names no entity or point; `selection` is spread.

        Parameters
        ----------
        what, classes : as of `operand`
        least : E1251 if there are fewer
        whole : all remaining words are to be operands
        """
        found: list[Operand] = []
        while self.items:
            if self.items[0].text == "selection":
                found += self.selected(*classes)
                continue
            if (
                not whole
                and self.find(self.items[0]) is None
                and (len(found) >= least and not self._looks_like_handle(self.items[0]))
            ):
                break
            found.append(self.operand(what, *classes))
        if len(found) < least:
            self.missing(what or " or ".join(CLASSES[one] for one in classes) or "an entity")
        return found

    def _looks_like_handle(self, token: Token) -> bool:
        parts = split_handle(token.text)
        return (
            parts is not None
            and parts.name.rstrip("0123456789") in ("L", "A", "EA", "P", "S")
            and _POINT.match(parts.point) is not None
        )

    def selected(self, *classes: str) -> list[Operand]:
        """Take the word ``selection``: the selected entities and points of these classes."""
        token = self.next("`selection`")
        found = []
        for handle in self.session.selection:
            one = self.find(replace(token, text=handle))
            if one is not None and (not classes or any(one.fits(c) for c in classes)):
                found.append(one)
        if not found:
            fail("E1259", "nothing is selected", token.span, "", "`select L0` selects a line")
        return found

    # --- numbers ----------------------------------------------------------------------------

    def number(
        self,
        what: str,
        quantity: str = "",
        *,
        above: float | None = None,
        least: float | None = None,
        most: float | None = None,
    ) -> float:
        """Take a number: a literal, with a unit, or an expression.

        Parameters
        ----------
        quantity : ``length`` or ``angle`` (in degrees), to check units
        above, least, most : bounds; E1257 outside
        """
        token = self.next(what)
        value = self.number_of(token, what, quantity)
        self.require_bounds(value, token, what, above=above, least=least, most=most)
        return value

    def require_bounds(
        self,
        value: float,
        token: Token,
        what: str,
        *,
        above: float | None = None,
        least: float | None = None,
        most: float | None = None,
    ) -> None:
        """E1257 if a number that a word gave is out of bounds."""
        bound = ""
        if above is not None and not value > above:
            bound = f"more than {exact(above)}"
        elif least is not None and not value >= least:
            bound = f"at least {exact(least)}"
        elif most is not None and not value <= most:
            bound = f"at most {exact(most)}"
        if bound:
            fail("E1257", f"{what} is {bound}, found {exact(value)}", token.span)

    def number_of(self, token: Token, what: str = "a number", quantity: str = "") -> float:
        """The number that a word means."""
        plain = literal(token.text)
        if plain is not None:
            return self._finite(plain, token)
        value = self._value(token, quantity)
        if isinstance(value, Vec):
            fail(
                "E1254", f"expected {what}, found a coordinate", token.span, "", "take `.x` or `.y`"
            )
        return value

    def _finite(self, value: float, token: Token) -> float:
        if value in (float("inf"), float("-inf")):
            help_ = "the largest number is about 1.8e308"
            fail("E1263", f"`{token.text[:40]}` is too large for a number", token.span, "", help_)
        return value

    def _value(self, token: Token, quantity: str = "") -> Value:
        text = _without_at(token.text)
        if quantity:
            try:
                require_quantity(text, quantity)
            except AraelError as error:
                raise moved(error, token.span.source, token.span.start) from None
        return self.session.evaluate(text, token.span)

    def whole(self, what: str, least: int = 0, most: int = 1_000_000) -> int:
        """Take a whole number."""
        token = self.next(what)
        value = self.number_of(token, what)
        if value != int(value):
            fail("E1257", f"{what} is a whole number, found {exact(value)}", token.span)
        self.require_bounds(value, token, what, least=least, most=most)
        return int(value)

    def amount(self, what: str, quantity: str = "", token: Token | None = None) -> Amount:
        """Take a value that a dimension or parameter keeps: literal, live, or ``=`` snapshot.

        Raises
        ------
        AraelError
            As of reading numbers; E1254: something that only a session knows and that cannot be
            kept.
        """
        token = token or self.next(what)
        text = token.text
        if text.startswith("="):
            cut = len(text) - len(text[1:].lstrip())
            rest = replace(token, text=text[cut:], span=_shifted(token.span, cut))
            if not rest.text:
                fail("E1251", "nothing follows `=`", token.span, "", "write `=2*width`")
            value = self.number_of(rest, what, quantity)
            return Amount(exact(value), value)
        plain = literal(text)
        if plain is not None:
            return Amount(text, self._finite(plain, token))
        kept = self.canonical(token)
        value = self.number_of(token, what, quantity)
        # what is kept is to mean the same without the session
        scope = DocumentScope(self.session.document, self.session.scope.measure)
        try:
            evaluate(kept, scope)
        except AraelError as error:
            raise placed(error, token.span) from None
        return Amount(kept, value)

    def canonical(self, token: Token) -> str:
        """An expression as the document keeps it: variables are put in place."""
        try:
            expression = read(_without_at(token.text))
        except AraelError as error:
            raise moved(error, token.span.source, token.span.start) from None
        pieces: list[str] = []
        at = 0
        for path, start, end in expression.references:
            new = self._kept(path, Span(token.span.source, token.span.start + start,
                                        token.span.start + end))  # fmt: skip
            pieces += [token.text[at:start], new]
            at = end
        return "".join([*pieces, token.text[at:]])

    def _kept(self, path: str, span: Span) -> str:
        name, dot, rest = path.partition(".")
        if name in ("cursor", "_cursor", "_tangent"):
            hint = "put `=` before the value to take what it is now"
            fail("E1254", "a dimension cannot follow the cursor", span, "", hint)
        own = self.session.variable(name)
        if own is None or path in CONSTANTS:
            return path
        if isinstance(own, str):
            return f"{own}{dot}{rest}"
        value = own
        if isinstance(own, Vec):
            if rest not in ("x", "y"):
                fail("E1254", f"`{path}` is a coordinate", span, "", "take `.x` or `.y`")
            value = own.x if rest == "x" else own.y
        elif dot:
            fail("E1262", f"`{name}` is a number", span)
        assert isinstance(value, float)
        return exact(value) if value >= 0 else f"({exact(value)})"

    # --- coordinates ------------------------------------------------------------------------

    def point(self, what: str = "a coordinate") -> Place:
        """Take a coordinate: ``x,y``, ``@dx,dy``, a point, ``cursor``, a variable, an expression.

        ``@dx,dy`` starts from the coordinate read before by this command, else from the cursor.
        """
        token = self.next(what)
        found = self.place_of(token, what)
        self.origin = found.at
        return found

    def points(self, what: str = "a coordinate", least: int = 1) -> list[Place]:
        """Take all remaining words as coordinates."""
        found = []
        while self.items:
            found.append(self.point(what))
        if len(found) < least:
            self.missing(what)
        return found

    def direction(self, what: str = "a direction") -> Vec:
        """Take a vector; `@tangent` is the direction at the cursor."""
        token = self.next(what)
        found = self.place_of(token, what)
        if found.at.x == 0.0 and found.at.y == 0.0:
            fail("E1257", f"{what} is not zero, found 0,0", token.span)
        return found.at

    def is_place(self, token: Token | None = None) -> bool:
        """Whether a word (the next one) can be read as a coordinate, not a number or a name."""
        token = token or self.peek()
        if token is None or token.quoted:
            return False
        try:
            self.place_of(token)
        except AraelError:
            return "," in _top_level(token.text) or token.text.startswith("@")
        return True

    def place_of(self, token: Token, what: str = "a coordinate") -> Place:
        """The coordinate that a word means; E1253 if it means none."""
        text = token.text
        operand = self.find(token)
        if operand is not None and operand.fits("point"):
            at = self.session.document.point_at(operand.handle)
            values = self.session.document.values
            return Place(Vec(float(values[at]), float(values[at + 1])), operand.handle, token)
        if text.startswith("@") and text not in ("@cursor", "@tangent") and "," in text:
            if self.origin is None:
                help_ = "set it: `cursor 0,0`"
                fail(
                    "E1259",
                    "`@` is relative to the cursor, which is not set",
                    token.span,
                    "",
                    help_,
                )
            moved_by = self._pair(replace(token, text=text[1:], span=_shifted(token.span, 1)))
            return Place(self.origin + moved_by, "", token)
        if "," in _top_level(text):
            return Place(self._pair(token), "", token)
        if operand is not None:
            have = ", ".join(f"`{operand.handle}.{p}`" for p in point_offsets(operand.entity))
            message = f"expected {what}, found `{text}`, {_a(operand.entity.kind)}"
            fail("E1253", message, token.span, "", f"its points are {have[:80]}")
        try:
            value = self._value(token)
        except AraelError as error:
            self._perhaps_keyword(token, error)
            inner = text[1:-1]
            if text[0] == "(" and text[-1] == ")" and len(_split_top(inner)) == 2:
                hint = f"write `{inner[:60]}`, without parentheses"
                fail("E1253", f"expected {what}, found `{text[:60]}`", token.span, "", hint)
            raise
        if not isinstance(value, Vec):
            hint = "write `x,y`, a point (`L0.p1`), `cursor` or a coordinate variable"
            fail("E1253", f"expected {what}, found a number", token.span, "", hint)
        return Place(value, "", token)

    def _perhaps_keyword(self, token: Token, error: AraelError) -> None:
        """E1252 if a word that means nothing is close to a keyword of the command."""
        allowed = self.command.keywords if self.command else ()
        near = closest(token.text, [word for word in allowed if word not in self.flags])
        if near and error.diagnostics[0].code == "E1262":
            hint = f"did you mean `{near[0]}`?"
            fail("E1252", f"`{token.text[:60]}` is not expected here", token.span, "", hint)

    def _pair(self, token: Token) -> Vec:
        if _NUMBER_PAIR.match(token.text):
            a, _, b = token.text.partition(",")
            return Vec(self._finite(float(a), token), self._finite(float(b), token))
        parts = _split_top(token.text)
        if len(parts) != 2:
            hint = "write `x,y`"
            message = f"a coordinate has two parts, found {len(parts)}"
            fail("E1253", message, token.span, "", hint)
        found = []
        for (start, end), name in zip(parts, ("x", "y"), strict=True):
            piece = token.text[start:end]
            lead = len(piece) - len(piece.lstrip())
            text = piece.strip()
            if not text:
                message = f"the {name} of this coordinate is missing"
                fail("E1253", message, token.span, "", "write `x,y`")
            at = token.span.start + start + lead
            span = Span(token.span.source, at, at + len(text))
            found.append(self.number_of(replace(token, text=text, span=span), f"{name}", "length"))
        return Vec(*found)

    def coordinate_or_number(self, token: Token) -> float | Vec:
        """The value of a word that may be either."""
        text = token.text
        if "," in _top_level(text) or (text.startswith("@") and len(text) > 1):
            return self.place_of(token).at
        plain = literal(text)
        if plain is not None:
            return self._finite(plain, token)
        return self._value(token)


def placed(error: AraelError, span: Span) -> AraelError:
    """The same error at a place of the command line."""
    return AraelError(
        [replace(d, span=span, labels=(), label="", origin="") for d in error.diagnostics]
    )


def _without_at(text: str) -> str:
    """``@cursor`` and ``@tangent`` as names of the same length."""
    return re.sub(r"@(?=(?:cursor|tangent)\b)", "_", text) if "@" in text else text


def _shifted(span: Span, by: int) -> Span:
    return Span(span.source, min(span.start + by, span.end), span.end)


def _top_level(text: str) -> str:
    """The text without what is in brackets."""
    if "(" not in text:
        return text
    depth = 0
    kept = []
    for char in text:
        depth += (char == "(") - (char == ")")
        if depth == 0:
            kept.append(char)
    return "".join(kept)


def _split_top(text: str) -> list[tuple[int, int]]:
    """Stretches between commas outside of brackets."""
    found = []
    depth = start = 0
    for at, char in enumerate(text):
        depth += (char in "([") - (char in ")]")
        if char == "," and depth == 0:
            found.append((start, at))
            start = at + 1
    return [*found, (start, len(text))]


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"


def _or(words: Iterable[Any]) -> str:
    names = [f"`{word}`" for word in words]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
