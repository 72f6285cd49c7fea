"""The mistakes that people make, each with a message of its own.

A mistake is a function of the `Trouble`: where it recognises its pattern it reports, repairs the
tokens so that the parse continues, and returns True. They are tried in turn, specific ones before
general ones; what none of them recognises is reported as "expected ..., found ...".
"""

from __future__ import annotations

from collections.abc import Callable

from arael.syntax.mistakes import brackets, declarations, fields, formulas
from arael.syntax.mistakes.expected import report_expected
from arael.syntax.trouble import Trouble

MISTAKES: tuple[Callable[[Trouble], bool], ...] = (
    brackets.unmatched,
    brackets.wrong_closer,
    brackets.unclosed,
    declarations.reserved_word,
    declarations.missing_name,
    fields.field,
    fields.type_,
    fields.type_parameters,
    fields.element_type,
    fields.collection_of_ref,
    fields.comma,
    formulas.equal,
    declarations.outside,
    declarations.let_among_members,
    declarations.function,
    declarations.clause,
    declarations.missing_braces,
    declarations.import_,
    declarations.setting,
    declarations.missing_equal,
    formulas.word_of_programs,
    formulas.two_statements,
    formulas.quoted,
    formulas.chained_comparison,
    formulas.condition,
    formulas.missing_operand,
    formulas.missing_operator,
)


def explain(trouble: Trouble) -> None:
    """Report the mistake at `trouble` and repair the tokens."""
    trouble.mark_damage()
    before = trouble.before
    if before is not None and trouble.log.has_error_in(before.end, trouble.token.start):
        # The lexer skipped something right here; this is a consequence, not a second mistake.
        trouble.panic()
    elif not any(mistake(trouble) for mistake in MISTAKES):
        report_expected(trouble)
