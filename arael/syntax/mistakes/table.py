"""Rows of the table of mistakes, and the matcher that reads them.

A row is a pattern around the token that the parser cannot accept, the message, and the repair. In a
pattern, kinds are types of tokens, or one of the classes below, separated by blanks. Texts may
contain the names in braces that `Mistake.names_at` lists.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from arael.diagnostics.suggest import closest
from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS, Token
from arael.syntax.trouble import ITEM_WORDS, MEMBER_WORDS, STARTERS, Trouble

Names = dict[str, str]
Condition = Callable[[Trouble], Names | bool]
Repair = Callable[[Trouble], None]

_COMPARISONS = frozenset(("EQ", "NE", "LT", "LE", "GT", "GE"))
_OPERATORS = _COMPARISONS | {"PLUS", "MINUS", "STAR", "SLASH", "DOTSTAR", "DOTSLASH", "CARET"}
CLASSES: dict[str, frozenset[str]] = {
    "end": frozenset((NEWLINE, END, "SEMICOLON", "RBRACE")),
    "newline": frozenset((NEWLINE,)),
    "eof": frozenset((END,)),
    "opener": frozenset(OPENERS),
    "closer": frozenset(CLOSERS),
    "item": ITEM_WORDS,
    "member": MEMBER_WORDS,
    "starter": STARTERS,
    "comparison": _COMPARISONS,
    "operator": _OPERATORS | {"AND", "OR", "NOT", "EQUAL", "COMMA"},
    "operand": frozenset(("NAME", "NUMBER", "STRING", "TRUE", "FALSE", "SELF", "PARENT", "ROOT"))
    | {"LPAR", "IF", "NOT"},
}
"""Classes of types; further ones are ``name`` and ``word``, which a reserved word can be too."""


def is_kind(t: Trouble, token: Token | None, kinds: str) -> bool:
    """Whether `token` is of one of `kinds`."""
    if token is None:
        return False
    return any(
        token.type == kind
        or token.type in CLASSES.get(kind, ())
        or (kind == "name" and t.is_name(token))
        or (kind == "word" and t.is_word(token))
        for kind in kinds.split()
    )


@dataclass(frozen=True, eq=False)
class Mistake:
    """One mistake. A pattern matches if all its parts do; a part that is not given always does.

    Attributes
    ----------
    code, message, label, help, note : the diagnostic
    place : where it is: ``token``, ``before``, ``top``, or the first and the last of a range,
        ``before..token``; ``after`` the token before; or ``span``, which `when` gives
    related : a second place, the text there, and its kinds for ``within``
    token, before, ahead, second : kinds of the token that does not fit, of the one before, and of
        the next two
    text, before_text : spellings of the token and of the one before
    meant : other spellings of the token, with their meanings `{meant}`
    near : words that the token may be a misspelling of: `{meant}`
    last : whether the token before is on top of the stack
    opener : kinds of the innermost open bracket, ``none`` if there must be none
    within, outside : words that began a construct, within the innermost braces
    construct, block : kinds of the word of the construct, and of the braces
    part : ``members`` of a struct or the ``body`` of a constraint
    expected, accepted : types that would fit here, or after what can be completed
    operand, begins : whether an expression should begin here; whether the line begins here
    when : a further condition; True, or names for the texts
    repair : operations of `Trouble` with their arguments, separated by semicolons, or a function
    """

    code: str
    message: str
    label: str = ""
    help: str = ""
    note: str = ""
    place: str = "token"
    related: tuple[str, str] | None = None
    token: str = ""
    before: str = ""
    ahead: str = ""
    second: str = ""
    text: str = ""
    before_text: str = ""
    meant: Mapping[str, str] = field(default_factory=dict)
    near: tuple[str, ...] = ()
    last: bool | None = None
    opener: str = ""
    within: str = ""
    outside: str = ""
    construct: str = ""
    block: str = ""
    part: str = ""
    expected: str = ""
    accepted: str = ""
    operand: bool | None = None
    begins: bool | None = None
    when: Condition | None = None
    repair: str | Repair = "panic"

    def names_at(self, t: Trouble) -> Names | None:
        """Names for the texts if the pattern matches: of tokens around, ``meant``, of `when`."""
        if not (self._tokens_match(t) and self._surroundings_match(t)):
            return None
        construct, opener = t.construct(), t.opener()
        names = {
            "token": t.token.text,
            "before": t.before.text if t.before else "",
            "ahead": t.ahead().text,
            "construct": construct.text if construct else "",
            "opener": opener.text if opener else "",
        }
        if self.meant or self.near:
            word = t.token.text
            meant = self.meant.get(word) or next(iter(closest(word, self.near)), None)
            if meant is None:
                return None
            names["meant"] = meant
        if self.when is None:
            return names
        found = self.when(t)
        return None if found is False else {**names, **({} if found is True else found)}

    def _tokens_match(self, t: Trouble) -> bool:
        return (
            all(
                not kinds or is_kind(t, token, kinds)
                for kinds, token in (
                    (self.token, t.token),
                    (self.before, t.before),
                    (self.ahead, t.ahead()),
                    (self.second, t.ahead(2)),
                )
            )
            and (not self.text or t.token.text in self.text.split())
            and (
                not self.before_text
                or (t.before is not None and t.before.text in self.before_text.split())
            )
            and self.last in (None, t.before is not None and t.top is t.before)
        )

    def _surroundings_match(self, t: Trouble) -> bool:
        opener = t.opener()
        return (
            self.operand in (None, t.wants_operand)
            and self.begins in (None, t.begins_line)
            and (not self.opener or (opener is None) == (self.opener == "none"))
            and (self.opener in ("", "none") or is_kind(t, opener, self.opener))
            and (not self.within or t.within(*self.within.split()) is not None)
            and (not self.outside or t.within(*self.outside.split()) is None)
            and (not self.construct or is_kind(t, t.construct() or _NOTHING, self.construct))
            and (not self.block or is_kind(t, t.block(), self.block))
            and (self.part != "members" or t.in_members)
            and (self.part != "body" or t.in_body)
            and set(self.expected.split()) <= set(t.expected)
            and all(t.automaton.accepts(type) for type in self.accepted.split())
        )

    def report(self, t: Trouble, names: Names) -> None:
        """Report the mistake at `t`."""
        start, end = span_of(t, self.place, names)
        related = []
        if self.related is not None:
            related = [(*span_of(t, self.related[0], names), self.related[1].format(**names))]
        note, help_ = self.note.format(**names), self.help.format(**names)
        t.log.error(
            self.code,
            self.message.format(**names),
            start,
            end,
            self.label.format(**names),
            labels=related,
            notes=(note,) if note else (),
            help=help_ or (),
        )

    def mend(self, t: Trouble, names: Names) -> None:
        """Repair the tokens so that the parse can continue."""
        if not isinstance(self.repair, str):
            self.repair(t)
            return
        for step in self.repair.format(**names).split("; "):
            operation, *arguments = step.split()
            if operation == "swap":
                t.swap(arguments[0].upper())
            elif operation == "pop":
                t.automaton.pop(1)
            elif operation == "skip":
                t.skip(int(arguments[0]) if arguments else 1)
            else:
                getattr(t, operation)(*arguments)


_NOTHING = Token("none", "", 0, 0)


def span_of(t: Trouble, place: str, names: Names) -> tuple[int, int]:
    """Start and end of a place, see `Mistake.place`."""
    if "span" in names and place == "span":
        start, _, end = names["span"].partition(" ")
        return int(start), int(end)
    if place == "after":
        final = t.before or t.opener()
        assert final is not None
        return final.end, final.end
    first, _, last = place.partition("..")
    return _token(t, first).start, _token(t, last or first).end


def _token(t: Trouble, name: str) -> Token:
    found: Token | None
    match name:
        case "token":
            found = t.token
        case "before":
            found = t.before
        case "ahead":
            found = t.ahead()
        case "second":
            found = t.ahead(2)
        case "opener":
            found = t.opener()
        case _:
            found = t.within(name)
    assert found is not None, name
    return found


def span(start: int, end: int) -> Names:
    """The place of a mistake, as `when` gives it for the place ``span``."""
    return {"span": f"{start} {end}"}
