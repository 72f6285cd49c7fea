"""Curves of the plane as frozen values, and pure functions on them; no document, no solver."""

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.angles import Sector, angle, angle_between, line_angle, sector_angle
from arael.sketch.geometry.arcs import (
    arc_tangent,
    arc_through,
    elliptic_arc,
    elliptic_arc_tangent,
    elliptic_arc_through,
)
from arael.sketch.geometry.blocks import chain_area, curve_of, numbers_of
from arael.sketch.geometry.chains import Chain, Link, area, chain_length, chains
from arael.sketch.geometry.circles import (
    TangentCircle,
    circle_through,
    circles_tangent_to_three,
    circles_tangent_to_two,
)
from arael.sketch.geometry.circular import Arc, Circle
from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.contacts import Contact, intersections
from arael.sketch.geometry.coordinates import (
    along,
    arc_point,
    distance,
    intersect,
    midpoint,
    mirror,
    normal,
    project,
    rotate,
    scale,
    shift,
    tangent,
    towards,
)
from arael.sketch.geometry.corners import Corner, Fillet, chamfer, corner, fillet
from arael.sketch.geometry.curve import Bounds, Curve, Nearest, Piece
from arael.sketch.geometry.edges import between_edges, to_edge
from arael.sketch.geometry.elliptic import Ellipse, EllipticArc
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.splines import Bezier, BSpline
from arael.sketch.geometry.vectors import DegenerateError, Point

__all__ = [
    "Affine",
    "Arc",
    "BSpline",
    "Bezier",
    "Bounds",
    "Chain",
    "Circle",
    "Conic",
    "Contact",
    "Corner",
    "Curve",
    "DegenerateError",
    "Ellipse",
    "EllipticArc",
    "Fillet",
    "Line",
    "Link",
    "Nearest",
    "Piece",
    "Point",
    "Sector",
    "TangentCircle",
    "along",
    "angle",
    "angle_between",
    "arc_point",
    "arc_tangent",
    "arc_through",
    "area",
    "between_edges",
    "chain_area",
    "chain_length",
    "chains",
    "chamfer",
    "circle_through",
    "circles_tangent_to_three",
    "circles_tangent_to_two",
    "corner",
    "curve_of",
    "distance",
    "elliptic_arc",
    "elliptic_arc_tangent",
    "elliptic_arc_through",
    "fillet",
    "intersect",
    "intersections",
    "line_angle",
    "midpoint",
    "mirror",
    "normal",
    "numbers_of",
    "project",
    "rotate",
    "scale",
    "sector_angle",
    "shift",
    "tangent",
    "to_edge",
    "towards",
]
