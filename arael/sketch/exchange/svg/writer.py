"""Documents as SVG: the geometry to scale, in millimetres."""

from __future__ import annotations

from math import ceil, degrees, tau
from xml.sax.saxutils import quoteattr

from arael.sketch.document.document import Document
from arael.sketch.document.records import Entity
from arael.sketch.drawing.layout import title_of
from arael.sketch.drawing.svg import clean, printable
from arael.sketch.drawing.view import bounds_of_document
from arael.sketch.exchange.units import MILLIMETRES
from arael.sketch.geometry import (
    Affine,
    Arc,
    Bezier,
    BSpline,
    Circle,
    Curve,
    Ellipse,
    EllipticArc,
    Line,
    Point,
    curve_of,
)
from arael.sketch.text import lettering

_DASHES = {"solid": "", "dashed": ' stroke-dasharray="3 1.5"',
           "dashdot": ' stroke-dasharray="4 1 0.4 1"'}  # fmt: skip


def to_svg(document: Document) -> str:
    """Curves as exact SVG shapes, one unit a millimetre, y downwards.

    Construction geometry is in a group of its own, thinner and dashed; points are round dots. Every
    element carries the name of its entity. A text is one path of its strokes, with the text and its
    frame as data, from which `from_svg` makes a text again.
    """
    scale = MILLIMETRES[document.unit]
    box = bounds_of_document(document)
    size = max(box.size * scale, 1e-9) if box else 1.0
    margin = max(2.0, 0.02 * size)
    x, y = (scale * box.x_min - margin, scale * box.y_max + margin) if box else (0.0, 0.0)
    width = scale * (box.x_max - box.x_min) + 2 * margin if box else 100.0
    height = scale * (box.y_max - box.y_min) + 2 * margin if box else 100.0
    place = Affine(scale, 0.0, 0.0, -scale, -x, y)
    groups: dict[bool, list[str]] = {False: [], True: []}
    for name, entity in document.entities.items():
        numbers = document.numbers_of(name).tolist()
        if entity.text:
            a, b = (numbers[0], numbers[1]), (numbers[2], numbers[3])
            shape = _text(entity.text, a, b, place)
            groups[entity.construction].append(f"<{shape}{_marks(entity)}/>")
            continue
        if entity.kind == "point":
            shape = _dot(place((numbers[0], numbers[1])))
        else:
            shape = element(curve_of(entity.kind, numbers).transformed(place))
        dash = _DASHES[entity.style]
        groups[entity.construction].append(f"<{shape}{dash}{_marks(entity)}/>")
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_n(width)}mm" height="{_n(height)}mm" '
        f'viewBox="0 0 {_n(width)} {_n(height)}">',
        f"<title>{clean(title_of(document))}</title>",
        '<g fill="none" stroke="#000000" stroke-linecap="round" stroke-linejoin="round">',
        '<g class="construction" stroke-width="0.18" stroke="#6b7684" stroke-dasharray="1.5 1.5">',
        *groups[True],
        '</g>\n<g class="outline" stroke-width="0.35">',
        *groups[False],
        "</g>\n</g>\n</svg>\n",
    ]
    return "\n".join(parts)


def _marks(entity: Entity) -> str:
    style = "" if entity.style == "solid" else f' data-style="{entity.style}"'
    return f'{style} data-name="{entity.name}"'


def _n(x: float) -> str:
    """Fifteen digits."""
    text = f"{x:.15g}"
    return "0" if text == "-0" else text


def _p(point: Point) -> str:
    return f"{_n(point[0])} {_n(point[1])}"


def _dot(at: Point) -> str:
    return f'path d="M{_p(at)}h0" stroke-width="1" stroke-dasharray="none"'


def _text(text: str, start: Point, end: Point, place: Affine) -> str:
    strokes = []
    for stroke in lettering(text, start, end):
        pieces = [piece.transformed(place) for piece in stroke]
        strokes.append(f"M{_p(pieces[0].start)}{''.join(map(_piece, pieces))}")
    frame = f"{_p(place(start))} {_p(place(end))}"
    return (
        f'path d="{"".join(strokes)}" stroke-dasharray="none" '
        f'data-text={quoteattr(printable(text))} data-frame="{frame}"'
    )


def _piece(piece: Curve) -> str:
    if isinstance(piece, Circle):
        return _arc(Arc(piece.center, piece.radius, 0.0, tau))
    return _arc(piece) if isinstance(piece, Arc | EllipticArc) else f"L{_p(piece.end)}"


def element(curve: Curve) -> str:
    """Tag and geometry of the element of a curve."""
    if isinstance(curve, Line):
        (a, b), (c, d) = curve.p1, curve.p2
        return f'line x1="{_n(a)}" y1="{_n(b)}" x2="{_n(c)}" y2="{_n(d)}"'
    if isinstance(curve, Circle):
        x, y = curve.center
        return f'circle cx="{_n(x)}" cy="{_n(y)}" r="{_n(curve.radius)}"'
    if isinstance(curve, Ellipse):
        (x, y), turn = curve.center, degrees(curve.rotation)
        return (
            f'ellipse rx="{_n(curve.rx)}" ry="{_n(curve.ry)}" '
            f'transform="translate({_n(x)} {_n(y)}) rotate({_n(turn)})"'
        )
    if isinstance(curve, Arc | EllipticArc):
        return f'path d="M{_p(curve.start)}{_arc(curve)}"'
    assert isinstance(curve, Bezier | BSpline)
    pieces = curve.beziers() if isinstance(curve, BSpline) else [curve]
    curves = "".join(f"C{_p(q)} {_p(r)} {_p(s)}" for _, q, r, s in (p.poles for p in pieces))
    return f'path d="M{_p(curve.start)}{curves}"'


def _arc(curve: Arc | EllipticArc) -> str:
    """``A`` commands of at most 126 degrees: near half a turn the centre would be inaccurate."""
    rx, ry = curve.radii
    turn = degrees(curve.turned)
    count = max(1, ceil(abs(curve.sweep) / 2.2))
    onwards = int(curve.sweep > 0)
    return "".join(
        f"A{_n(rx)} {_n(ry)} {_n(turn)} 0 {onwards} {_p(curve.point_at((i + 1) / count))}"
        for i in range(count)
    )
