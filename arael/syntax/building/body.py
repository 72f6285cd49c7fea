"""The inside of a constraint: lets first, then the one residual."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

from arael.diagnostics.records import Span
from arael.syntax import tree
from arael.syntax.log import ErrorLog


@dataclass(frozen=True)
class Words:
    """What a body is part of, and what its last expression is, in messages."""

    whole: str
    result: str


CONSTRAINT = Words("constraint", "residual")
SUM = Words("sum", "term")
REQUIRE = Words("require", "comparison")


def check_body(parts: list[Any], span: Span, log: ErrorLog, words: Words = CONSTRAINT) -> tree.Body:
    """Body from its opening brace, its statements and its closing brace."""
    opening, *statements, _ = parts
    lets = [s for s in statements if isinstance(s, tree.Let)]
    results = [s for s in statements if not isinstance(s, tree.Let)]
    if not results and not opening.damaged:
        _report_no_residual(lets, span, log, words)
    if results and not opening.damaged:
        continued = _report_continuation(statements, log)
        _report_order(statements, results, continued, log, words)
    zero = tree.Number(span=span, text="0")
    return tree.Body(span=span, lets=tuple(lets), result=results[-1] if results else zero)


def _report_no_residual(lets: list[tree.Let], span: Span, log: ErrorLog, words: Words) -> None:
    if lets:
        last = lets[-1]
        log.error(
            "E0130",
            f"this {words.whole} has no {words.result}",
            span.end - 1,
            span.end,
            "an expression is missing before the end",
            labels=[
                (
                    last.name.span.start,
                    last.name.span.end,
                    f"the last name, never used as {words.result}",
                )
            ],
            help=f"end the body with the {words.result}, for example `{last.name.id}`",
        )
    else:
        log.error(
            "E0130",
            f"this {words.whole} is empty",
            span.start,
            span.end,
            f"no {words.result} in here",
            help=f"write the {words.result} as an expression, such as `(x - y) / sigma`",
        )


def _report_order(
    statements: list[Any], results: list[Any], continued: set[int], log: ErrorLog, words: Words
) -> None:
    last = results[-1]
    for other in results[:-1]:
        if other.span.start in continued:
            continue
        log.error(
            "E0132",
            f"a {words.whole} has one {words.result}",
            other.span.start,
            other.span.end,
            "this value is unused",
            labels=[(last.span.start, last.span.end, f"the {words.result} is the last expression")],
            help=f"put several {words.result}s in a list, `[a, b]`, or name this one with `let`",
        )
    # By identity: two equal expressions are two statements.
    after = itertools.takewhile(lambda s: s is not last, reversed(statements))
    for let in reversed(list(after)):
        log.error(
            "E0131",
            f"`let` after the {words.result}",
            let.span.start,
            let.span.start + 3,
            f"`{let.name.id}` is defined after the {words.result}",
            labels=[(last.span.start, last.span.end, f"the {words.result} ends the body")],
            help=f"move the `let` above the {words.result}",
        )


def _report_continuation(statements: list[Any], log: ErrorLog) -> set[int]:
    """Find a sign at the start of a line that was meant as an operator of the line above.

    ``let d = a`` on one line and ``- b`` on the next, indented further, would otherwise read as a
    finished ``let`` and a residual ``-b``. Returns the starts of such lines.
    """
    found: set[int] = set()
    position = log.source.position
    for above, below in itertools.pairwise(statements):
        if isinstance(below, tree.Let) or not _leading_sign(below, log):
            continue
        line_above, column_above = position(above.span.start)
        line, column = position(below.span.start)
        if line > line_above and column > column_above:
            start = below.span.start
            found.add(start)
            log.error(
                "E0133",
                "an operator at the start of a line does not continue the previous line",
                start,
                start + 1,
                "starts a new statement here",
                labels=[(above.span.end - 1, above.span.end, "the statement ended here")],
                help=(
                    f"put the `{log.source.text[start]}` at the end of the line above, or brackets "
                    "around it all",
                ),
            )
    return found


def _leading_sign(expr: Any, log: ErrorLog) -> bool:
    return log.source.text[expr.span.start] in "+-"
