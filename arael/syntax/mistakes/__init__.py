"""What people get wrong, and what to tell them.

A recogniser looks at a `Trouble`; where it knows the mistake it reports it, mends the tokens so
that the parse can go on, and returns True. They are asked in turn, the particular before the
general.
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
    """Report what is wrong at `trouble` and mend it."""
    trouble.mark_damage()
    before = trouble.before
    if before is not None and trouble.log.has_error_in(before.end, trouble.token.start):
        # The lexer left something out right here; what follows from that is no second mistake.
        trouble.panic()
        return
    if not any(recognise(trouble) for recognise in _RECOGNISERS):
        say_expected(trouble)
