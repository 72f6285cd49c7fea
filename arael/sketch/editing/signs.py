"""Signs of values: a dimension keeps them as its side, its numbers are without one."""

from __future__ import annotations

from typing import NamedTuple

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount
from arael.sketch.expressions.reading import literal


class Sided(NamedTuple):
    """A value or range on one side.

    Attributes
    ----------
    value, low, high : without a sign
    side : 1 or -1 where the signs say on which; 0: as it is drawn
    """

    value: Amount | None
    low: Amount | None
    high: Amount | None
    side: int


def sided(
    document: Document,
    kind: str,
    args: tuple[str, ...],
    mode: str,
    value: Amount | None,
    low: Amount | None,
    high: Amount | None,
    known: tuple[str, ...] = (),
) -> Sided:
    """Numbers of a dimension without their signs, and the side that these mean.

    A negative value is on the other side of the operands in their order: see
    `arael.sketch.document.measures.signed`. A range of negative numbers runs the other way there.

    Parameters
    ----------
    known : operands of the dimension that gets them, in its order

    Raises
    ------
    AraelError
        E1220: a range from one side to the other, or a negative distance that has no sides
    """
    given = [one for one in (value, low, high) if one is not None]
    if not DIMENSIONS[kind].signed or all(one.number >= 0.0 for one in given):
        return Sided(value, low, high, 0)
    if kind == "distance" and not _has_sides(document, args, mode):
        found = next(one.text for one in given if one.number < 0.0)
        what = "circles" if mode else "points"
        message = f"`distance` of {what} has no sign, found {found}"
        raise AraelError(Diagnostic("E1220", message, help=("leave the minus sign out",)))
    side = -_order(document, kind, args, known or args)
    if value is not None:
        text = value.text if side < 0 else _unsigned(value.text)
        return Sided(Amount(text, -value.number), None, None, side)
    if high is None or high.number > 0.0:
        shown = f">= {low.text}" if high is None and low is not None else f"{_text(low)} to "
        shown += high.text if high is not None else ""
        message = f"a range of `{kind}` is on one side of 0, found {shown}"
        help_ = "begin it at 0, or give both bounds one sign"
        raise AraelError(Diagnostic("E1220", message, help=(help_,)))
    return Sided(None, _positive(high), _positive(low), side)


def _order(document: Document, kind: str, args: tuple[str, ...], known: tuple[str, ...]) -> int:
    """1 if a quantity has the same sign for its operands in two orders, else -1."""
    if args == known:
        return 1
    entities = [document.entities.get(one) for one in args]
    if kind == "distance" and all(one is not None and one.kind == "line" for one in entities):
        (a, b, c, d), (p, q, r, s) = (document.numbers_of(one).tolist() for one in args)
        # Each of two lines that run against each other is on the same side of the other.
        return 1 if (c - a) * (r - p) + (d - b) * (s - q) < 0.0 else -1
    return -1


def _has_sides(document: Document, args: tuple[str, ...], mode: str) -> bool:
    """Whether a distance has a sign: not that of points, or of circles around different centres."""
    second = document.entities.get(args[1])
    return second is not None and second.kind != "point" and not mode


def _text(amount: Amount | None) -> str:
    return amount.text if amount is not None else ""


def _positive(amount: Amount | None) -> Amount | None:
    if amount is None or amount.number >= 0.0:
        return amount
    return Amount(_unsigned(amount.text), -amount.number)


def _unsigned(text: str) -> str:
    return text.removeprefix("-") if literal(text) is not None else text
