"""STEP files by build123d: faces of closed chains, wires of open ones."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.drawing.outlines import beziers_of
from arael.sketch.exchange.problems import not_installed
from arael.sketch.exchange.units import MILLIMETRES
from arael.sketch.geometry import (
    Affine,
    Arc,
    Circle,
    Curve,
    Line,
    Point,
    chains,
    curve_of,
)
from arael.sketch.geometry.contacts import intersections


def to_step(document: Document) -> bytes:
    """The outline, without construction geometry and texts, in millimetres in the plane z = 0.

    A closed chain inside another one is a hole of its face.

    Raises
    ------
    AraelError
        E1305: build123d is not installed; E1307: there is no outline.
    """
    try:
        # imported here: start-up time
        import build123d
    except ImportError:
        raise not_installed("a STEP file", "build123d", "step") from None
    scale = Affine.scaling(MILLIMETRES[document.unit])
    curves = [
        curve_of(entity.kind, document.numbers_of(name).tolist()).transformed(scale)
        for name, entity in document.entities.items()
        if entity.kind != "point" and not entity.construction and not entity.text
    ]
    if not curves:
        raise AraelError(
            Diagnostic(
                "E1307",
                "the sketch has no outline to write",
                help=("points, texts and construction geometry are not part of a STEP file",),
            )
        )
    shape = build123d.Compound(children=_shapes(build123d, curves))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sketch.step"
        build123d.export_step(shape, str(path))
        return path.read_bytes()


def _shapes(b3d: Any, curves: list[Curve]) -> list[Any]:
    size = max(curve.bounds().size for curve in curves)
    wires = []
    loops = []
    for chain in chains(curves, 1e-6 * size):
        ordered = chain.curves(curves)
        wire = b3d.Wire([edge for curve in ordered for edge in _edges(b3d, curve)])
        if chain.closed:
            loops.append((ordered, wire))
        else:
            wires.append(wire)
    # by the number of loops around it a loop is an outline (even) or a hole (odd)
    loops.sort(key=lambda loop: -_extent(loop[0]))
    faces: list[tuple[list[Curve], int, Any, list[Any]]] = []
    seen: list[list[Curve]] = []
    for ordered, wire in loops:
        depth = sum(inside(ordered[0].start, other) for other in seen)
        seen.append(ordered)
        if depth % 2 == 0:
            faces.append((ordered, depth, wire, []))
            continue
        holder = next(
            face
            for face in reversed(faces)
            if face[1] == depth - 1 and inside(ordered[0].start, face[0])
        )
        holder[3].append(wire)
    return [b3d.Face(wire, holes) for _, _, wire, holes in faces] + wires


def _extent(loop: list[Curve]) -> float:
    box = loop[0].bounds()
    for curve in loop[1:]:
        box = box.union(curve.bounds())
    return box.size


def inside(point: Point, loop: list[Curve]) -> bool:
    """Whether a point lies inside a closed chain: crossings of a ray are odd."""
    far = max(curve.bounds().size + abs(curve.start[0] - point[0]) for curve in loop)
    # a slope that no drawing has, so that the ray meets no joint
    ray = Line(point, (point[0] + 3 * far, point[1] + 0.0123456789 * far))
    return sum(len(intersections(ray, curve)) for curve in loop) % 2 == 1


def _edges(b3d: Any, curve: Curve) -> list[Any]:
    if isinstance(curve, Line):
        return [b3d.Edge.make_line((*curve.p1, 0), (*curve.p2, 0))]
    if isinstance(curve, Circle):
        return [b3d.Edge.make_circle(curve.radius).moved(b3d.Location((*curve.center, 0)))]
    if isinstance(curve, Arc):
        points = ((*curve.point_at(t), 0) for t in (0.0, 0.5, 1.0))
        return [b3d.Edge.make_three_point_arc(*points)]
    # splines exactly; ellipses by cubic curves, to 1e-6 of the radius
    return [b3d.Edge.make_bezier(*((*pole, 0) for pole in piece)) for piece in beziers_of(curve)]
