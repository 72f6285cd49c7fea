"""The table of common mistakes, with specific messages.

Rows are tried in turn, specific ones before general ones. The first that matches is reported, and
the tokens are repaired so that the parse can continue.
"""

from __future__ import annotations

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
from arael.syntax.mistakes.table import Mistake
from arael.syntax.trouble import Trouble

TABLE: tuple[Mistake, ...] = (
    *brackets.ROWS,
    *rust.ROWS,
    *names.ROWS,
    *fields.ROWS,
    *blocks.ROWS,
    *schedule.ROWS,
    *statements.ROWS,
    *expressions.ROWS,
)


def explain(trouble: Trouble) -> None:
    """Report the mistake at `trouble` and repair the tokens."""
    trouble.mark_damage()
    before = trouble.before
    if before is not None and trouble.log.has_error_in(before.end, trouble.token.start):
        # The lexer skipped something right here; this is a consequence, not a second mistake.
        trouble.panic()
        return
    for row in TABLE:
        names_ = row.names_at(trouble)
        if names_ is not None:
            row.report(trouble, names_)
            row.mend(trouble, names_)
            return
    say_expected(trouble)
