"""Documents as DXF (R2010)."""

from __future__ import annotations

import json
from io import StringIO
from math import atan2, degrees, dist, pi
from typing import Any

from arael.sketch.document.document import Document
from arael.sketch.document.records import Entity
from arael.sketch.document.saved import to_json
from arael.sketch.drawing.view import bounds_of_document, curves_of
from arael.sketch.exchange.dxf.dimensions import add_dimension
from arael.sketch.exchange.dxf.names import (
    APPLICATION,
    CONSTRUCTION,
    DIMENSIONS,
    LINETYPES,
    OUTLINE,
    RECORD,
    UNITS,
)
from arael.sketch.exchange.problems import not_installed
from arael.sketch.geometry import (
    Arc,
    Bezier,
    BSpline,
    Circle,
    Curve,
    Ellipse,
    EllipticArc,
    Line,
)
from arael.sketch.text import height_of

_CHUNK = 240
"""Characters of one string of a record; DXF allows 255 bytes."""


def to_dxf(document: Document) -> bytes:
    """Geometry, dimensions, and the sketch itself as data.

    Curves are on the layers OUTLINE and CONSTRUCTION with their line types, and carry their names
    as extended data. Texts are `TEXT` entities aligned between the ends of their frames, which are
    not drawn: other programs show them in another font, but as wide. Dimensions are dimension
    entities. The whole document is kept as JSON in a record, from which `from_dxf` restores it if
    the geometry is still the same.

    Raises
    ------
    AraelError
        E1305: ezdxf is not installed.
    """
    try:
        # imported here: start-up time
        import ezdxf
    except ImportError:
        raise not_installed("a DXF file", "ezdxf", "sketch") from None
    file = ezdxf.new("R2010", setup=True)  # type: ignore[attr-defined, unused-ignore]
    file.header["$INSUNITS"] = UNITS[document.unit]
    file.header["$MEASUREMENT"] = 0 if document.unit == "in" else 1
    file.appids.new(APPLICATION)
    file.layers.add(OUTLINE, color=7)
    file.layers.add(CONSTRUCTION, color=8, linetype="DASHED")
    file.layers.add(DIMENSIONS, color=3)
    box = bounds_of_document(document)
    size = box.size if box is not None and box.size > 0 else 1.0
    center = (0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max)) if box else (0.0, 0.0)
    file.header["$LTSCALE"] = size / 100.0
    space = file.modelspace()
    curves = curves_of(document)
    for name, entity in document.entities.items():
        attributes = _attributes(entity)
        if entity.kind == "point":
            drawn = space.add_point(document.numbers_of(name).tolist(), dxfattribs=attributes)
        elif entity.text:
            drawn = add_text(space, entity.text, curves[name], attributes)
        else:
            drawn = add_curve(space, curves[name], attributes)
        drawn.set_xdata(APPLICATION, [(1000, name)])
    for dimension in document.dimensions.values():
        add_dimension(space, document, curves, dimension, size, center)
    record = file.rootdict.add_xrecord(RECORD)
    text = json.dumps(json.loads(to_json(document)), separators=(",", ":"))
    record.reset([(1, text[i : i + _CHUNK]) for i in range(0, len(text), _CHUNK)])
    stream = StringIO()
    file.write(stream)
    return stream.getvalue().encode("utf-8")


def _attributes(entity: Entity) -> dict[str, Any]:
    found: dict[str, Any] = {"layer": CONSTRUCTION if entity.construction else OUTLINE}
    if entity.style != "solid" or entity.construction:
        found["linetype"] = LINETYPES[entity.style]
    return found


def add_text(space: Any, text: str, frame: Curve, attributes: dict[str, Any]) -> Any:
    """The TEXT entity of a text: its width is that of the frame in any font."""
    # imported here: start-up time
    from ezdxf.enums import TextEntityAlignment

    height = height_of(text, dist(frame.start, frame.end))
    drawn = space.add_text(encoded(text), height=height, dxfattribs=attributes)
    (dx, dy), (x, y) = frame.end, frame.start
    drawn.dxf.rotation = degrees(atan2(dy - y, dx - x))
    drawn.set_placement(frame.start, frame.end, align=TextEntityAlignment.ALIGNED)
    return drawn


def encoded(text: str) -> str:
    """A text as DXF writes it: ``%%`` and ``^`` begin codes there."""
    if "%%" in text:
        text = text.replace("%", "%%%")
    return text.replace("^", "^ ")


def add_curve(space: Any, curve: Curve, attributes: dict[str, Any]) -> Any:
    """The DXF entity of a curve."""
    if isinstance(curve, Line):
        return space.add_line(curve.p1, curve.p2, dxfattribs=attributes)
    if isinstance(curve, Circle):
        return space.add_circle(curve.center, curve.radius, dxfattribs=attributes)
    if isinstance(curve, Arc):
        start, sweep = curve.forward().span
        return space.add_arc(
            curve.center, curve.radius, degrees(start), degrees(start + sweep),
            dxfattribs=attributes,
        )  # fmt: skip
    if isinstance(curve, Ellipse | EllipticArc):
        whole = isinstance(curve, Ellipse)
        start, sweep = (0.0, 2 * pi) if whole else curve.span
        rx, ry = curve.radii
        shift = 0.0
        if ry > rx:  # the major axis comes first; angles count from it
            rx, ry, shift = ry, rx, 0.5 * pi
        axis = curve.at_angle(shift)
        major = axis[0] - curve.center[0], axis[1] - curve.center[1]
        return space.add_ellipse(
            curve.center, major, max(ry / rx, 1e-6), start - shift, start - shift + sweep,
            dxfattribs=attributes,
        )  # fmt: skip
    assert isinstance(curve, Bezier | BSpline)
    spline = space.add_spline(dxfattribs=attributes)
    spline.set_open_uniform([(*pole, 0.0) for pole in curve.poles], degree=3)
    return spline
