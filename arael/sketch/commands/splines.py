"""Splines."""

from __future__ import annotations

from arael.sketch.commands import creating
from arael.sketch.commands.numbers import place
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail


@command(
    "add_spline",
    group="create",
    usage=("add_spline p1 p2 p3 p4 [p5 ...] [bezier] [noconnect] [nocursor] [quiet] [constr]",),
    summary="A cubic spline by its poles; it begins in the first and ends in the last.",
    details="""
Four poles make a cubic Bezier curve; more of them a clamped B-spline with uniform knots, which is
smooth to the second derivative. The curve leaves its ends towards the neighbouring poles. Poles
are points: `S0.p1`, `S0.p2` are the ends, `S0.pole2` and so on the others.

```
add_spline 0,0 1,2 3,2 4,0
add_spline 0,0 1,2 3,2 4,0 6,-1 8,0
```
""",
    keywords=(*creating.COMMON, "bezier"),
    arguments=("*poles",),
)
def add_spline(session: Session, words: Words) -> Reply:
    """A spline."""
    poles = words.points("a pole")
    if len(poles) < 4:
        fail("E1251", f"a spline has at least 4 poles, found {len(poles)}", words.span)
    if "bezier" in words.flags and len(poles) != 4:
        help_ = "leave `bezier` out for a B-spline"
        fail("E1257", f"a Bezier curve has 4 poles, found {len(poles)}", words.span, "", help_)
    kind = "bezier" if len(poles) == 4 else "bspline"
    numbers = [number for pole in poles for number in (pole.x, pole.y)]
    added = creating.add(session, words, kind, numbers)
    creating.leave_cursor(session, words, added.entity, "p2")
    first, last = poles[0], poles[-1]
    text = (
        f"{added.entity.name}: {place(first.x, first.y)}-{place(last.x, last.y)}, "
        f"{len(poles)} poles"
    )
    return creating.reply(text, [added])
