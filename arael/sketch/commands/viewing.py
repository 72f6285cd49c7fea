"""Commands on the view and the cursor, which faces follow."""

from __future__ import annotations

from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.expressions.shapes import curve_of
from arael.sketch.expressions.vectors import Vec

MIN_ZOOM, MAX_ZOOM = 1e-9, 1e9
_STEP = 1.25


@command(
    "center",
    group="view",
    usage=["center", "center L0", "center 5,3"],
    summary="Show everything, or put an entity or a place into the middle of the view.",
    arguments=("what=",),
)
def center(session: Session, words: Words) -> Reply:
    """Centre the view."""
    view = session.state.view
    view.version += 1
    if not words:
        view.center, view.zoom = None, 1.0
        return Reply("View: everything", remembered=False, data={"center": None, "zoom": 1.0})
    operand = words.find(words.items[0])
    if operand is not None and not operand.fits("point"):
        words.next("")
        bounds = curve_of(session.document, operand.entity).bounds()
        x, y = 0.5 * (bounds.x_min + bounds.x_max), 0.5 * (bounds.y_min + bounds.y_max)
    else:
        at = words.point()
        x, y = at.x, at.y
    words.end()
    view.center = (x, y)
    return Reply(f"View: centre {place(x, y)}", remembered=False, data={"center": [x, y]})


@command(
    "zoom",
    group="view",
    usage=["zoom +", "zoom -", "zoom 2.0"],
    summary="Zoom in, out, or to a factor; 1 shows everything.",
    arguments=("factor",),
)
def zoom(session: Session, words: Words) -> Reply:
    """Zoom."""
    view = session.state.view
    sign = words.accept("+", "-")
    if sign:
        wanted = view.zoom * (_STEP if sign == "+" else 1.0 / _STEP)
        wanted = min(max(wanted, MIN_ZOOM), MAX_ZOOM)
    else:
        token = words.next("`+`, `-` or a factor")
        wanted = words.number_of(token, "a factor")
        words.require_bounds(wanted, token, "a factor", least=MIN_ZOOM, most=MAX_ZOOM)
    words.end()
    view.zoom = wanted
    view.version += 1
    return Reply(f"Zoom: {shown(wanted)}", remembered=False, data={"zoom": wanted})


@command(
    "cursor",
    group="view",
    usage=[
        "cursor",
        "cursor 5,3",
        "cursor L0.p2",
        "cursor @dx,dy",
        "cursor on",
        "cursor off",
    ],
    summary="Show or set the cursor, from which `@dx,dy` starts.",
    details="""
Commands that create geometry put it at the end of what they made, unless `nocursor` is given. As a
coordinate it is written `cursor` or `@cursor`; `@tangent` is the direction at it.
""",
    arguments=("at=",),
)
def cursor(session: Session, words: Words) -> Reply:
    """Show or set the cursor."""
    state = session.state
    word = words.accept("on", "off", "info")
    if word == "off":
        words.end()
        return _hide(session)
    if word == "on":
        words.end()
        return _show(session)
    if words:
        at = words.point()
        words.end()
        session.move_cursor(at.at, _tangent_at(session, at.handle), chain=False)
        state.cursor_shown = True
    return _said(session)


@command(
    "show",
    group="view",
    usage=["show"],
    summary="Show the cursor, at 0,0 if it is not set: `cursor on`.",
    arguments=(),
)
def show(session: Session, words: Words) -> Reply:
    """Show the cursor."""
    words.end()
    return _show(session)


@command(
    "hide",
    group="view",
    usage=["hide"],
    summary="Hide the cursor: `cursor off`.",
    arguments=(),
)
def hide(session: Session, words: Words) -> Reply:
    """Hide the cursor."""
    words.end()
    return _hide(session)


def _show(session: Session) -> Reply:
    if session.state.cursor is None:
        session.state.cursor = Vec(0.0, 0.0)
    session.state.cursor_shown = True
    return _said(session)


def _hide(session: Session) -> Reply:
    session.state.cursor_shown = False
    return Reply("Cursor: hidden", remembered=False, data={"shown": False})


def _tangent_at(session: Session, handle: str) -> Vec | None:
    """Direction at the end of a curve that is named, as travelled."""
    name, _, point = handle.partition(".")
    if point not in ("p1", "p2", "start", "end"):
        return None
    curve = curve_of(session.document, session.document.entities[name])
    x, y = curve.tangent_at(0.0 if point in ("p1", "start") else 1.0)
    return Vec(x, y)


def _said(session: Session) -> Reply:
    state = session.state
    if state.cursor is None:
        return Reply("Cursor: not set", remembered=False, data={"cursor": None})
    text = f"Cursor: {place(state.cursor.x, state.cursor.y)}"
    if state.tangent is not None:
        text += f", tangent {place(state.tangent.x, state.tangent.y)}"
    data = {"cursor": [state.cursor.x, state.cursor.y], "shown": state.cursor_shown}
    return Reply(text, remembered=False, data=data)
