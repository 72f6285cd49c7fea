"""Verdicts and failed solves as messages."""

from __future__ import annotations

from collections.abc import Sequence

from arael.diagnostics.records import AraelError, Diagnostic


def redundant(label: str, others: Sequence[str], drop: str) -> AraelError:
    """E1230: follows from others."""
    return AraelError(
        Diagnostic(
            "E1230",
            f"`{label}` is redundant: it follows from {listed(others)}",
            notes=("without any one of them it would take a degree of freedom",) if others else (),
            help=(
                f"`delete {drop}` would give it something to hold; `force` lets it in as it is"
                if drop
                else "`force` lets it in as it is",
            ),
        )
    )


def impossible(
    label: str, others: Sequence[str], drop: str, why: str = "", collapse: bool = False
) -> AraelError:
    """E1231: contradicts others, or itself for a reason.

    `collapse`: all holds where nothing is left of a line or circle. Without `drop` that is so from
    where the drawing is now, too, if a line would have to turn by a right angle.
    """
    way = "would make it possible" + (", with its lines dragged near to it" if collapse else "")
    alone = f"`{label}` is impossible" + (f": {why}" if why else "")
    return AraelError(
        Diagnostic(
            "E1231",
            f"`{label}` is impossible together with {listed(others)}" if others else alone,
            help=(f"`delete {drop}` {way}",) if drop else (),
        )
    )


#: What was tried where no solution was found.
_TRIED = (
    "tried: steps of least change, steps that keep all sides and lengths, and ways out of "
    "positions in which equations depend on each other"
)


def not_found(label: str, others: Sequence[str], drop: str) -> AraelError:
    """E1234: no common solution was found, and none is proven not to exist."""
    together = f" together with {listed(others)}" if others else ""
    near = "drag the geometry nearer to what is wanted, or go in smaller steps"
    return AraelError(
        Diagnostic(
            "E1234",
            f"no solution of `{label}`{together} was found from here",
            notes=(_TRIED, "the sketch is left as it was"),
            help=(near, *((f"`delete {drop}` would make it possible",) if drop else ())),
        )
    )


def other_side(name: str, guard: str) -> AraelError:
    """E1233: a solution was found on the other side only."""
    return AraelError(
        Diagnostic(
            "E1233",
            f"no solution of `{name}` was found on this side: {guard} would turn over",
            notes=(_TRIED,),
            help=("drag the geometry to the other side first, or choose another value",),
        )
    )


def not_converged(open_rows: Sequence[str], residual: float) -> AraelError:
    """E1234: the solver ended without a solution."""
    return AraelError(
        Diagnostic(
            "E1234",
            f"no solution found: {listed(open_rows)} stay{'s' if len(open_rows) == 1 else ''} "
            f"open by {residual:.3g}",
            notes=(
                _TRIED,
                "the sketch is left as it was",
            ),
            help=("go in smaller steps, or look at `list constraints` for what contradicts it",),
        )
    )


def runs_away() -> AraelError:
    """E1234: the equations hold the better the larger the drawing becomes, and never."""
    return AraelError(
        Diagnostic(
            "E1234",
            "no solution found: the geometry would grow without end",
            notes=("the sketch is left as it was",),
            help=("go in smaller steps, or look at `list constraints` for what contradicts it",),
        )
    )


def unsettled(names: Sequence[str]) -> AraelError:
    """E1234: values that read geometry which moves with them."""
    return AraelError(
        Diagnostic(
            "E1234",
            f"no solution found: {listed(names)} never settle{'s' if len(names) == 1 else ''}",
            notes=("they read geometry that moves with them", "the sketch is left as it was"),
            help=("put `=` before a value to take what it is now",),
        )
    )


def listed(names: Sequence[str], most: int = 12) -> str:
    """Names in a sentence: ``C1, C2 and C3``."""
    shown = [f"`{name}`" for name in names[:most]]
    if len(names) > most:
        shown.append(f"{len(names) - most} more")
    if len(shown) < 2:
        return shown[0] if shown else "what is there"
    return ", ".join(shown[:-1]) + " and " + shown[-1]
