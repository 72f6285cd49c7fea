"""A token that the parser cannot accept, and the operations for recovery."""

from __future__ import annotations

from arael.syntax import tables
from arael.syntax.automaton import Automaton
from arael.syntax.log import ErrorLog
from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS, Token

# Words that begin an item, a member or a statement, and nothing else.
ITEM_WORDS = frozenset({"STRUCT", "COMPONENT", "IMPORT", "CONST", "FN", "EXTERN"})
MEMBER_WORDS = frozenset({"PARAM", "CONSTRAINT"})
STARTERS = ITEM_WORDS | MEMBER_WORDS | {"LET"}

# Words that can also be names in the right place.
SOFT_WORDS = frozenset({
    "LIST", "DEQUE", "ARENA", "BLOCK", "TRIPLETS", "KEY", "LOSS", "INTO", "FIT", "PASS", "SOLVE",
    "MARGINALIZE", "SKIP", "SKIP_SELF_BLOCK", "FREEZE", "FREE", "SYMBOLIC", "COMPUTE", "UPDATE",
    "DERIVS", "REQUIRE",
})  # fmt: skip
NAMES = SOFT_WORDS | {"NAME"}

# Words whose tokens stay on the stack while their construct is read.
_CONSTRUCTS = frozenset({
    "STRUCT", "ROOT", "COMPONENT", "CONSTRAINT", "REQUIRE", "FIT", "SOLVE", "PASS", "UPDATE",
    "FN", "CONST", "IMPORT", "LET", "WHEN", "LOSS", "INTO", "KEY", "PARAM", "SKIP", "MARGINALIZE",
    "FREEZE", "FREE", "SYMBOLIC", "COMPUTE", "DERIVS", "REF", "BLOCK", "IF",
})  # fmt: skip
_BLOCK_HEADS = frozenset({
    "STRUCT", "ROOT", "COMPONENT", "CONSTRAINT", "REQUIRE", "FIT", "SOLVE", "PASS", "UPDATE",
})  # fmt: skip


class Trouble:
    """Token number `index` is not acceptable.

    Recognisers examine the tokens and the stack, report, and repair: they replace, insert or skip
    tokens so that the parse continues at `index`.
    """

    def __init__(
        self, automaton: Automaton, tokens: list[Token], index: int, log: ErrorLog
    ) -> None:
        self.automaton = automaton
        self.tokens = tokens
        self.index = index
        self.log = log
        self.expected = automaton.expected()

    # --- looking around ---

    @property
    def token(self) -> Token:
        """The token that does not fit."""
        return self.tokens[self.index]

    def ahead(self, count: int = 1) -> Token:
        """Return the token `count` further on, or the end of the text."""
        return self.tokens[min(self.index + count, len(self.tokens) - 1)]

    @property
    def before(self) -> Token | None:
        """The last token before this one that is not a line end."""
        i = self.index - 1
        while i >= 0 and self.tokens[i].type == NEWLINE:
            i -= 1
        return self.tokens[i] if i >= 0 else None

    @property
    def begins_line(self) -> bool:
        """Return whether the token is the first on its line."""
        return self.index == 0 or self.tokens[self.index - 1].type == NEWLINE

    def is_name(self, token: Token) -> bool:
        """Return whether `token` can be a name."""
        return token.type in NAMES

    def is_word(self, token: Token) -> bool:
        """Return whether `token` is a name or a reserved word."""
        return token.type in NAMES or token.text.isidentifier()

    @property
    def top(self) -> Token | None:
        """The token on top of the stack, if nothing was built from it yet."""
        if not self.automaton.entries:
            return None
        value = self.automaton.entries[-1][0]
        return value if isinstance(value, Token) else None

    @property
    def last(self) -> Token | None:
        """The token before, if it is on top of the stack: nothing was built from it yet."""
        before = self.before
        return before if before is not None and self.top is before else None

    @property
    def ends_statement(self) -> bool:
        """Return whether the token ends a statement."""
        return self.token.type in (NEWLINE, END, "SEMICOLON", "RBRACE")

    @property
    def begins_field(self) -> bool:
        """Return whether a field begins here: ``name:``."""
        return self.is_name(self.token) and self.ahead().type == "COLON"

    @property
    def begins_member(self) -> bool:
        """Return whether an item, a member or a field begins here."""
        root = self.token.type == "ROOT" and self.is_name(self.ahead())
        return root or self.begins_field or self.token.type in ITEM_WORDS | MEMBER_WORDS

    def held(self) -> list[tuple[int, Token]]:
        """Tokens on the stack with their positions there, innermost first.

        Closed brackets and the tokens between them are omitted.
        """
        entries = self.automaton.entries
        found: list[tuple[int, Token]] = []
        closed = 0
        for i in range(len(entries) - 1, -1, -1):
            token = entries[i][0]
            if not isinstance(token, Token):
                continue
            if token.type in CLOSERS:
                closed += 1
            elif closed and token.type in OPENERS:
                closed -= 1
            elif not closed:
                found.append((i, token))
        return found

    def opener(self) -> Token | None:
        """Return the innermost bracket that is open."""
        return next((t for _, t in self.held() if t.type in OPENERS), None)

    def construct(self) -> Token | None:
        """Return the word that began the current construct, within the innermost braces."""
        for _, token in self.held():
            if token.type == "LBRACE":
                return None
            if token.type in _CONSTRUCTS:
                return token
        return None

    def within(self, *types: str) -> Token | None:
        """Return the innermost token of `types` on the stack within the innermost braces."""
        for _, token in self.held():
            if token.type in types:
                return token
            if token.type == "LBRACE":
                return None
        return None

    def block(self) -> Token | None:
        """Return the word of the enclosing braces: ``struct``, ``constraint``, ``pass``, ..."""
        inside = False
        for _, token in self.held():
            if token.type == "LBRACE":
                if inside:
                    return None
                inside = True
            elif inside and token.type in _BLOCK_HEADS:
                return token
        return None

    @property
    def in_members(self) -> bool:
        """Return whether the innermost braces are those of a struct, root or component."""
        block = self.block()
        return block is not None and block.type in ("STRUCT", "ROOT", "COMPONENT")

    @property
    def in_body(self) -> bool:
        """Return whether the innermost braces are those of a constraint."""
        block = self.block()
        return block is not None and block.type in ("CONSTRAINT", "REQUIRE", "FIT")

    @property
    def wants_operand(self) -> bool:
        """Return whether an expression should begin here."""
        return "NUMBER" in self.expected and "LPAR" in self.expected

    def line_tokens(self) -> list[Token]:
        """Return the tokens from this one to the end of its line."""
        end = self.index
        while self.tokens[end].type not in (NEWLINE, END):
            end += 1
        return self.tokens[self.index : end]

    # --- reporting and mending ---

    def report(
        self,
        code: str,
        message: str,
        label: str = "",
        *,
        at: Token | tuple[int, int] | None = None,
        note: str = "",
        help: str = "",
        related: tuple[Token, str] | None = None,
    ) -> None:
        """Report an error at the token, or `at`; `related` is a second place with its text."""
        at = at or self.token
        start, end = (at.start, at.end) if isinstance(at, Token) else at
        other = [(related[0].start, related[0].end, related[1])] if related is not None else []
        notes = (note,) if note else ()
        self.log.error(code, message, start, end, label, labels=other, notes=notes, help=help or ())

    def swap(self, type: str) -> None:
        """Read the token as one of `type`."""
        t = self.token
        text = tables.load().spelling(type) or t.text
        self.tokens[self.index] = Token(type, text, t.start, t.end)

    def insert(self, *types: str) -> None:
        """Insert tokens of `types` before this one."""
        at = self.before.end if self.before else self.token.start
        texts = {"NAME": "_", "NUMBER": "1"}
        new = [
            Token(t, texts.get(t) or tables.load().spelling(t) or "\n", at, at, damaged=True)
            for t in types
        ]
        self.tokens[self.index : self.index] = new

    def skip(self, count: int = 1) -> None:
        """Skip the next `count` tokens, but never the end of the text."""
        self.index = min(self.index + count, len(self.tokens) - 1)

    def skip_past(self, *types: str) -> None:
        """Skip tokens up to and including the first of `types` on this line."""
        line = self.line_tokens()
        for n, token in enumerate(line):
            if token.type in types:
                self.skip(n + 1)
                return
        self.skip(len(line))

    def skip_to(self, *types: str) -> None:
        """Skip tokens up to the first of `types` on this line."""
        line = self.line_tokens()
        self.skip(next((n for n, t in enumerate(line) if t.type in types), len(line)))

    def panic(self) -> None:
        """Discard the statement and continue after it.

        If a block with a faulty header follows, the block is still read.
        """
        if self._enter_block():
            return
        round_open = sum(1 for _, t in self._in_braces() if t.type in ("LPAR", "LSQB"))
        braces = 0
        while self.token.type != END:
            kind = self.token.type
            if kind == "LBRACE":
                braces += 1
            elif kind == "RBRACE":
                if braces == 0:
                    break
                braces -= 1
            elif braces == 0 and kind in ("LPAR", "LSQB"):
                round_open += 1
            elif braces == 0 and kind in CLOSERS:
                round_open = max(0, round_open - 1)
            elif (braces == 0 and kind in (NEWLINE, "SEMICOLON")) and (
                round_open == 0 or self._starts_statement(self.index + 1)
            ):
                break
            self.skip()
        self._forget_statement()

    def _in_braces(self) -> list[tuple[int, Token]]:
        held = self.held()
        for n, (_, token) in enumerate(held):
            if token.type == "LBRACE":
                return held[:n]
        return held

    def _starts_statement(self, index: int) -> bool:
        token = self.tokens[min(index, len(self.tokens) - 1)]
        after = self.tokens[min(index + 1, len(self.tokens) - 1)]
        return token.type in STARTERS or (self.is_name(token) and after.type == "COLON")

    def _forget_statement(self) -> None:
        entries = self.automaton.entries
        depth = len(entries)
        while depth and not _is_open_brace(entries[depth - 1][0]):
            depth -= 1
        self.automaton.pop(len(entries) - depth)
        if depth:
            entries[-1][0].damaged = True

    def mark_damage(self) -> None:
        """Mark the innermost braces as damaged, so that missing parts are not reported."""
        for _, token in self.held():
            if token.type == "LBRACE":
                token.damaged = True
                return

    def _enter_block(self) -> bool:
        """Try to read the block that begins further on this line, after a faulty header."""
        head = next((i for i, t in self._in_braces() if t.type in _BLOCK_HEADS), None)
        if head is None:
            return False
        line = self.line_tokens()
        brace = next((n for n, t in enumerate(line) if t.type == "LBRACE"), None)
        if brace is None:
            return False
        entries = self.automaton.entries
        while len(entries) > head + 1 and not self.automaton.accepts("LBRACE"):
            self.automaton.pop(1)
        if not self.automaton.accepts("LBRACE"):
            name = Token("NAME", "_", self.token.start, self.token.start)
            if not (self.automaton.feed(name) and self.automaton.accepts("LBRACE")):
                return False
        self.skip(brace)
        return True


def _is_open_brace(value: object) -> bool:
    return isinstance(value, Token) and value.type == "LBRACE"
