"""Recognisers of common mistakes, with specific messages.

A recogniser examines a `Trouble`; if it recognises the mistake it reports it, repairs the tokens so
that the parse can continue, and returns True. Recognisers are tried in turn, specific ones before
general ones.
"""

from __future__ import annotations

from collections.abc import Callable

from arael.syntax.mistakes import (
    blocks,
    brackets,
    expressions,
    fields,
    names,
    rust,
    schedule,
    statements,
)
from arael.syntax.mistakes.fallback import say_expected
from arael.syntax.trouble import Trouble

Recogniser = Callable[[Trouble], bool]

_RECOGNISERS: tuple[Recogniser, ...] = (
    *brackets.RECOGNISERS,
    *rust.RECOGNISERS,
    *names.RECOGNISERS,
    *fields.RECOGNISERS,
    *blocks.RECOGNISERS,
    *schedule.RECOGNISERS,
    *statements.RECOGNISERS,
    *expressions.RECOGNISERS,
)


def explain(trouble: Trouble) -> None:
    """Report the mistake at `trouble` and repair the tokens."""
    trouble.mark_damage()
    before = trouble.before
    if before is not None and trouble.log.has_error_in(before.end, trouble.token.start):
        # The lexer skipped something right here; this is a consequence, not a second mistake.
        trouble.panic()
        return
    if not any(recognise(trouble) for recognise in _RECOGNISERS):
        say_expected(trouble)
