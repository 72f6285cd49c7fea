"""Splines."""

from __future__ import annotations

from arael.sketch.commands import creating
from arael.sketch.commands.numbers import place
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.geometry.splines import poles_through


@command(
    "add_spline",
    group="create",
    usage=(
        "add_spline p1 p2 p3 p4 [p5 ...] [bezier] [noconnect] [nocursor] [quiet] [constr]",
        "add_spline p1 p2 p3 [p4 ...] through [noconnect] [nocursor] [quiet] [constr]",
    ),
    summary="A cubic spline by its poles, or through points; it begins in the first.",
    details="""
Four poles make a cubic Bezier curve; more of them a clamped B-spline with uniform knots, which is
smooth to the second derivative. The curve leaves its ends towards the neighbouring poles. Poles
are points: `S0.p1`, `S0.p2` are the ends, `S0.pole2` and so on the others.

`through` makes the B-spline that goes through all points, without curvature at its ends; it has
two poles more than there are points.

```
add_spline 0,0 1,2 3,2 4,0
add_spline 0,0 1,2 3,2 4,0 6,-1 8,0
add_spline 0,0 2,1 4,0 through
```
""",
    keywords=(*creating.COMMON, "bezier", "through"),
    arguments=("*poles",),
)
def add_spline(session: Session, words: Words) -> Reply:
    """A spline."""
    words.refuse_together("bezier", "through")
    through = "through" in words.flags
    places = words.points("a point" if through else "a pole")
    what, least = ("points that it goes through", 3) if through else ("poles", 4)
    if len(places) < least:
        message = f"a spline has at least {least} {what}, found {len(places)}"
        fail("E1251", message, words.span)
    poles = [(one.x, one.y) for one in places]
    if through:
        poles = list(poles_through(poles))
    if "bezier" in words.flags and len(poles) != 4:
        help_ = "leave `bezier` out for a B-spline"
        fail("E1257", f"a Bezier curve has 4 poles, found {len(poles)}", words.span, "", help_)
    kind = "bezier" if len(poles) == 4 else "bspline"
    numbers = [number for pole in poles for number in pole]
    added = creating.add(session, words, kind, numbers)
    creating.leave_cursor(session, words, added.entity, "p2")
    first, last = places[0], places[-1]
    text = (
        f"{added.entity.name}: {place(first.x, first.y)}-{place(last.x, last.y)}, "
        f"{len(poles)} poles{f' through {len(places)} points' if through else ''}"
    )
    return creating.reply(text, [added])
