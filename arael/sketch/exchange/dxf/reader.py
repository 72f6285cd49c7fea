"""DXF files: our own sketches, and geometry of others."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from math import hypot, radians, tau
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.records import Style
from arael.sketch.document.saved import from_json
from arael.sketch.drawing.view import curves_of
from arael.sketch.exchange.building import Collector, Found
from arael.sketch.exchange.dxf.names import APPLICATION, CONSTRUCTION, RECORD
from arael.sketch.exchange.dxf.splines import spline_curves
from arael.sketch.exchange.dxf.texts import text_frame
from arael.sketch.exchange.imported import Imported
from arael.sketch.exchange.problems import (
    MAX_BYTES,
    MAX_DEPTH,
    MAX_ENTITIES,
    not_installed,
    over_limit,
    unreadable,
)
from arael.sketch.geometry import (
    Affine,
    Arc,
    Circle,
    Curve,
    Ellipse,
    Line,
    Point,
)

_MIRROR = Affine(-1.0, 0.0, 0.0, 1.0)
"""From the coordinates of an entity seen from below (extrusion -z) to those of the drawing."""

_PADDING = b"\0\r\n\t \x1a"
"""What may follow the end of a file: of a text, and of a binary one."""

# $INSUNITS: code -> unit of the document and its factor; others are millimetres by a factor.
_UNITS: dict[int, tuple[str, float]] = {
    0: ("mm", 1.0), 1: ("in", 1.0), 2: ("in", 12.0), 3: ("in", 63360.0), 4: ("mm", 1.0),
    5: ("cm", 1.0), 6: ("m", 1.0), 7: ("m", 1000.0), 8: ("in", 1e-6), 9: ("in", 1e-3),
    10: ("in", 36.0), 13: ("mm", 1e-3), 14: ("cm", 10.0), 15: ("m", 10.0), 16: ("m", 100.0),
}  # fmt: skip


def from_dxf(
    data: bytes, origin: str = "the drawing", tolerance: float | None = None
) -> Document | Imported:
    """A sketch that was written by `to_dxf`, or the geometry of another drawing.

    Blocks are exploded. Heights are dropped: everything is taken as lying in the plane. Texts of
    one line (`TEXT`) become texts; hatches, dimensions, paragraphs and other things that a sketch
    has no place for are counted in the notes.

    Raises
    ------
    AraelError
        E1302: no DXF, or damaged; E1303: too many curves, or blocks nested too deeply; E1305:
        ezdxf is not installed.
    """
    try:
        # imported here: start-up time
        import ezdxf
    except ImportError:
        raise not_installed("a DXF file", "ezdxf", "sketch") from None
    del ezdxf
    if len(data) > MAX_BYTES:
        raise over_limit(f"{len(data):,} bytes", MAX_BYTES, origin)
    if b"SECTION" in data[:4096] and not data.rstrip(_PADDING).endswith(b"EOF"):
        raise _cut_short(data, origin)
    file = _parsed(data, origin)
    try:
        return _read(file, origin, tolerance)
    except AraelError:
        raise
    except Exception as error:  # a parser of other people's files: anything may be inconsistent
        raise unreadable("DXF", _said(error), origin) from None


def _cut_short(data: bytes, origin: str) -> AraelError:
    """E1302, with the number of curves before the end.

    The parser drops a section that is not complete, so the section is ended before the record in
    which the file stops.
    """
    lines = data.splitlines()
    record = max((k for k in range(0, len(lines), 2) if lines[k].strip() == b"0"), default=0)
    ended = b"\n".join([*lines[:record], b"0", b"ENDSEC", b"0", b"EOF", b""])
    collector = Collector(origin)
    try:
        file = _parsed(ended, origin)
        _Geometry(collector, file).read(file.modelspace())
    except Exception:  # binary, or stopped where nothing can be read yet
        collector.found.clear()
    count = len(collector.found)
    return AraelError(
        Diagnostic(
            "E1302",
            f"the file is cut short: it ends before `EOF`, after {count} complete "
            f"curve{'' if count == 1 else 's'}",
            origin=origin,
            help=(
                "copy or download it again",
                "if the program that wrote it always leaves the end out, add the lines `0` and "
                "`EOF`",
            ),
        )
    )


def _said(error: Exception) -> str:
    text = " ".join(str(error).split())[:200]
    return text.rstrip(".") or type(error).__name__


def _parsed(data: bytes, origin: str) -> Any:
    # imported here: start-up time
    from ezdxf import recover

    if not data.strip():
        raise unreadable("DXF", "the file is empty", origin)
    try:
        file, _ = recover.read(BytesIO(data))
    except AraelError:
        raise
    except Exception as error:
        raise unreadable("DXF", _said(error), origin) from None
    return file


def _read(file: Any, origin: str, tolerance: float | None) -> Document | Imported:
    collector = Collector(origin)
    _Geometry(collector, file).read(file.modelspace())
    code = int(file.header.get("$INSUNITS", 0))
    unit, factor = _UNITS.get(code, ("mm", 1.0))
    if factor != 1.0:
        by = Affine.scaling(factor)
        for one in collector.found:
            one.shape = one.shape.transformed(by) if isinstance(one.shape, Curve) else by(one.shape)
    note = ""
    try:
        ours = _kept(file, origin)
        if ours is not None:
            if _same(ours, collector.found):
                return ours
            note = "the geometry was changed since arael wrote it: its constraints were left out"
    except AraelError as error:
        reason = error.diagnostics[0].message
        note = f"the sketch kept in the file was left out, since it cannot be read: {reason}"
    found = collector.imported(unit, tolerance)
    if note:
        found.notes.append(note)
    if code not in _UNITS:
        found.notes.append("the unit of the drawing is unknown: read as millimetres")
    return found


def _kept(file: Any, origin: str) -> Document | None:
    """The sketch in our record, checked like any file; None if there is none."""
    record = file.rootdict.get(RECORD)
    tags = getattr(record, "tags", None)
    if tags is None:
        return None
    text = "".join(str(tag.value) for tag in tags if tag.code == 1)
    return from_json(text.encode("utf-8"), f"{origin}: {RECORD}")


def _same(document: Document, found: list[Found]) -> bool:
    """Whether the curves of the file are those of the sketch, to 1e-9 of its size."""
    curves = curves_of(document)
    if len(found) != len(document.entities):
        return False
    size = max((c.bounds().size for c in curves.values()), default=1.0)
    far = max((abs(float(x)) for x in document.values), default=1.0)
    close = 1e-9 * size + 1e-12 * far
    for one in found:
        if one.name not in document.entities:
            return False
        if one.text != document.entities[one.name].text:
            return False
        if isinstance(one.shape, Curve):
            curve = curves.get(one.name)
            if curve is None or curve.closed != one.shape.closed:
                return False
            ts = (0.0, 0.3, 0.7, 1.0)
            if curve.closed:
                gap = max(curve.nearest(one.shape.point_at(t)).distance for t in ts)
            else:
                gap = max(
                    hypot(p[0] - q[0], p[1] - q[1])
                    for p, q in ((curve.point_at(t), one.shape.point_at(t)) for t in ts)
                )
        else:
            x, y = document.numbers_of(one.name).tolist()[:2]
            gap = hypot(one.shape[0] - x, one.shape[1] - y)
        if not gap <= close:
            return False
    return True


class _Geometry:
    """Reads the entities of a layout, blocks exploded."""

    def __init__(self, collector: Collector, file: Any) -> None:
        self.collector, self.file = collector, file
        self.visited = 0

    def read(self, entities: Any, blocks: tuple[str, ...] = ()) -> None:
        """Every entity; `blocks` are the names of the blocks that hold it."""
        for entity in entities:
            self.visited += 1
            if self.visited > 4 * MAX_ENTITIES:
                raise over_limit("too many entities", 4 * MAX_ENTITIES, self.collector.origin)
            self._entity(entity, blocks)

    def _entity(self, entity: Any, blocks: tuple[str, ...]) -> None:
        kind = entity.dxftype()
        if kind == "INSERT":
            self._insert(entity, blocks)
        elif kind in ("LWPOLYLINE", "POLYLINE"):
            if kind == "POLYLINE" and not entity.is_2d_polyline:
                self.collector.left_out["three-dimensional polyline"] += 1
            else:
                self.read(entity.virtual_entities(), blocks)
        elif kind == "TEXT" and not _is_ours(entity) and (frame := text_frame(entity)) is not None:
            self.collector.add(
                Found(
                    frame[0],
                    _is_construction(entity),
                    self._style(entity),
                    _name(entity),
                    frame[1],
                )
            )
        elif kind in _SHAPES:
            shapes = list(_SHAPES[kind](entity))
            if not shapes:
                self.collector.left_out[f"tilted {kind}"] += 1
            for shape in shapes:
                self.collector.add(
                    Found(shape, _is_construction(entity), self._style(entity), _name(entity))
                )
        elif kind != "DIMENSION" or not _is_ours(entity):
            self.collector.left_out[kind] += 1

    def _insert(self, entity: Any, blocks: tuple[str, ...]) -> None:
        name = str(entity.dxf.name).upper()
        if name in blocks:
            raise unreadable("DXF", f"block `{name[:60]}` contains itself", self.collector.origin)
        if len(blocks) >= MAX_DEPTH:
            raise over_limit("blocks are nested too deeply", MAX_DEPTH, self.collector.origin)
        if entity.mcount > MAX_ENTITIES:
            raise over_limit(
                f"{entity.mcount:,} copies of a block", MAX_ENTITIES, self.collector.origin
            )
        copies = entity.multi_insert() if entity.mcount > 1 else (entity,)
        for copy in copies:
            self.read(copy.virtual_entities(), (*blocks, name))

    def _style(self, entity: Any) -> Style:
        name = str(entity.dxf.get("linetype", "BYLAYER")).upper()
        if name == "BYLAYER":
            layer = str(entity.dxf.get("layer", "0"))
            if layer.upper() == CONSTRUCTION or layer not in self.file.layers:
                return "solid"
            name = str(self.file.layers.get(layer).dxf.get("linetype", "")).upper()
        if name.startswith(("DASHDOT", "CENTER", "DIVIDE", "PHANTOM")):
            return "dashdot"
        return "dashed" if name.startswith(("DASH", "HIDDEN", "DOT")) else "solid"


def _is_construction(entity: Any) -> bool:
    return str(entity.dxf.get("layer", "0")).upper() == CONSTRUCTION


def _is_ours(entity: Any) -> bool:
    """Whether it is a dimension, or the text of one, that `to_dxf` wrote."""
    return str(entity.dxf.get("layer", "0")).upper() == "DIMENSIONS"


def _name(entity: Any) -> str:
    if not entity.has_xdata(APPLICATION):
        return ""
    return next((str(t.value) for t in entity.get_xdata(APPLICATION) if t.code == 1000), "")


def _flat(entity: Any) -> Affine | None:
    """Map from the entity's coordinates to the plane; None if it is tilted out of it."""
    x, y, z = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if hypot(x, y) > 1e-9 * abs(z):
        return None
    return Affine() if z > 0 else _MIRROR


def _xy(v: Any) -> Point:
    return float(v[0]), float(v[1])


def _line(entity: Any) -> Iterator[Curve | Point]:
    yield Line(_xy(entity.dxf.start), _xy(entity.dxf.end))


def _point(entity: Any) -> Iterator[Curve | Point]:
    yield _xy(entity.dxf.location)


def _circle(entity: Any) -> Iterator[Curve | Point]:
    by = _flat(entity)
    if by is not None:
        yield Circle(_xy(entity.dxf.center), float(entity.dxf.radius)).transformed(by)


def _arc(entity: Any) -> Iterator[Curve | Point]:
    by = _flat(entity)
    if by is not None:
        start, end = radians(entity.dxf.start_angle), radians(entity.dxf.end_angle)
        arc = Arc(_xy(entity.dxf.center), float(entity.dxf.radius), start, _turn(end - start))
        found = arc.transformed(by)
        assert isinstance(found, Arc)
        yield found.forward()


def _turn(sweep: float) -> float:
    """The sweep in (0, 2 pi]; a full turn that lost its last digits stays one."""
    found = sweep % tau
    return tau if found < 1e-12 or sweep == tau else found


def _ellipse(entity: Any) -> Iterator[Curve | Point]:
    by = _flat(entity)
    if by is None:
        return
    center, (mx, my) = _xy(entity.dxf.center), _xy(entity.dxf.major_axis)
    ratio = abs(float(entity.dxf.ratio))
    up = 1.0 if by.determinant > 0 else -1.0
    start, end = float(entity.dxf.start_param), float(entity.dxf.end_param)
    frame = Affine(mx, my, -up * ratio * my, up * ratio * mx, *center)
    if abs(abs(end - start) - tau) < 1e-9:
        yield _ellipse_of(Circle((0.0, 0.0), 1.0).transformed(frame))
        return
    found = Arc((0.0, 0.0), 1.0, start, _turn(end - start)).transformed(frame)
    yield found.forward()


def _ellipse_of(found: Circle | Ellipse) -> Curve:
    if isinstance(found, Circle):
        return Ellipse(found.center, found.radius, found.radius, 0.0)
    return found


def _spline(entity: Any) -> Iterator[Curve | Point]:
    yield from spline_curves(entity)


_SHAPES = {
    "LINE": _line,
    "POINT": _point,
    "CIRCLE": _circle,
    "ARC": _arc,
    "ELLIPSE": _ellipse,
    "SPLINE": _spline,
}
