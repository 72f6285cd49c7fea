"""The only table of what a sketch can hold: kinds of entities, constraints, dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class EntityKind:
    """A kind of geometry.

    Attributes
    ----------
    prefix : of names
    values : names of the numbers; for splines those of one pole
    points : named points and the offset of their x within the numbers
    freedoms : degrees of freedom; for splines of one pole
    poles : smallest number of poles of a spline, else 0
    most : largest number of poles, else 0 for any
    """

    prefix: str
    values: tuple[str, ...]
    points: tuple[tuple[str, int], ...]
    freedoms: int
    poles: int = 0
    most: int = 0


ENTITIES = MappingProxyType(
    {
        "point": EntityKind("P", ("x", "y"), (("pos", 0),), 2),
        "line": EntityKind("L", ("p1.x", "p1.y", "p2.x", "p2.y"), (("p1", 0), ("p2", 2)), 4),
        "circle": EntityKind("A", ("center.x", "center.y", "radius"), (("center", 0),), 3),
        # Runs counter-clockwise from start to end; two equations hold the ends on the circle.
        "arc": EntityKind(
            "A",
            ("center.x", "center.y", "start.x", "start.y", "end.x", "end.y", "radius"),
            (("center", 0), ("start", 2), ("end", 4)),
            5,
        ),
        "ellipse": EntityKind(
            "EA",
            ("center.x", "center.y", "radius", "radius_b", "rotation"),
            (("center", 0),),
            5,
        ),
        "earc": EntityKind(
            "EA",
            (
                "center.x",
                "center.y",
                "start.x",
                "start.y",
                "end.x",
                "end.y",
                "radius",
                "radius_b",
                "rotation",
            ),
            (("center", 0), ("start", 2), ("end", 4)),
            7,
        ),
        # Splines: cubic; a B-spline is clamped, with uniform knots inside.
        "bezier": EntityKind("S", ("x", "y"), (), 2, poles=4, most=4),
        "bspline": EntityKind("S", ("x", "y"), (), 2, poles=4),
    }
)

#: Classes of operands, and which kinds of entities each takes; ``point`` is any point's handle.
OPERANDS = MappingProxyType(
    {
        "line": ("line",),
        "arc": ("circle", "arc"),
        # With a start and an end.
        "open_arc": ("arc",),
        "ellipse": ("ellipse", "earc"),
        "round": ("circle", "arc", "ellipse", "earc"),
        "spline": ("bezier", "bspline"),
        "curve": ("line", "circle", "arc", "ellipse", "earc", "bezier", "bspline"),
        "entity": ("point", "line", "circle", "arc", "ellipse", "earc", "bezier", "bspline"),
        "point": (),
        # The end of a line, arc, elliptic arc or spline: ``L0.p2``, ``A0.start``, ``S0.p1``.
        "end": (),
    }
)


@dataclass(frozen=True, slots=True)
class Form:
    """One set of operands that a kind takes.

    Attributes
    ----------
    operands : classes, keys of `OPERANDS`; one followed by ``*`` stands for one or more
    freedoms : how many degrees of freedom it takes
    numbers : names of the record's numbers
    """

    operands: tuple[str, ...]
    freedoms: int
    numbers: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ConstraintKind:
    """A kind of relation.

    Attributes
    ----------
    forms : sets of operands, the first that fits is meant
    modes : values of `Constraint.mode` that mean something
    meaning : in words, for help
    """

    forms: tuple[Form, ...]
    meaning: str
    modes: tuple[str, ...] = ("",)


CONSTRAINTS = MappingProxyType(
    {
        "horizontal": ConstraintKind(
            (Form(("line",), 1), Form(("point", "point"), 1)),
            "a line, or two points, along x",
        ),
        "vertical": ConstraintKind(
            (Form(("line",), 1), Form(("point", "point"), 1)),
            "a line, or two points, along y",
        ),
        "parallel": ConstraintKind(
            (
                Form(("line", "line"), 1),
                Form(("line", "ellipse"), 1),
                Form(("ellipse", "line"), 1),
                Form(("ellipse", "ellipse"), 1),
            ),
            "same direction; of an ellipse the major axis",
        ),
        "perpendicular": ConstraintKind(
            (
                Form(("line", "line"), 1),
                Form(("line", "ellipse"), 1),
                Form(("ellipse", "line"), 1),
                Form(("ellipse", "ellipse"), 1),
            ),
            "at a right angle; of an ellipse the major axis",
        ),
        "collinear": ConstraintKind((Form(("line", "line"), 2),), "on one straight line"),
        "equal": ConstraintKind(
            (Form(("line", "line"), 1), Form(("arc", "arc"), 1), Form(("ellipse", "ellipse"), 2)),
            "the same length, or the same radius",
        ),
        "equal_angle": ConstraintKind(
            (Form(("line", "line", "line", "line"), 1),),
            "the angle of the first two lines is that of the other two",
        ),
        "tangent": ConstraintKind(
            (
                Form(("line", "round"), 1),
                Form(("round", "line"), 1),
                Form(("round", "round"), 1),
                Form(("end", "end"), 1),
            ),
            "touching in one direction; by ends: in one direction where they meet",
            # Of circles: touching from outside or one inside the other.
            modes=("", "outside", "inside"),
        ),
        "smooth": ConstraintKind(
            (Form(("end", "end"), 1),), "the same curvature where two curves meet"
        ),
        "coincident": ConstraintKind((Form(("point", "point"), 2),), "one place"),
        "concentric": ConstraintKind((Form(("round", "round"), 2),), "one centre"),
        "point_on": ConstraintKind((Form(("point", "curve"), 1),), "a point on a curve"),
        "midpoint": ConstraintKind(
            (Form(("point", "line"), 2), Form(("point", "open_arc"), 2)),
            "a point in the middle of a line or an arc",
        ),
        "symmetry": ConstraintKind(
            (
                # point, axis, point; line, axis, line; arc, axis, arc; point, centre, point
                Form(("point", "line", "point"), 2),
                Form(("line", "line", "line"), 2),
                Form(("arc", "line", "arc"), 3),
                Form(("point", "point", "point"), 2),
            ),
            "mirrored about a line (the second operand), or about a point",
        ),
        "on_normal": ConstraintKind(
            (Form(("point", "end"), 1),),
            "a point on the normal of a curve at its end",
        ),
        # One equation for every number of the source that coincidences leave open: `mode` lists
        # them (``p1 p2``, ``center radius``); the numbers turn about a centre, then shift.
        "image": ConstraintKind(
            (
                Form(("entity", "entity"), 0, ("angle", "dx", "dy")),
                Form(("entity", "entity", "point"), 0, ("angle", "dx", "dy")),
                Form(("entity", "entity", "line"), 0, ("angle", "along", "across")),
            ),
            "a turned or shifted copy; of a line operand the shift is along and across it",
            modes=(),
        ),
        "lock": ConstraintKind((Form(("point",), 2, ("x", "y")),), "a point held at a place"),
        "fix": ConstraintKind((Form(("entity",), 0),), "all numbers of an entity held"),
    }
)


@dataclass(frozen=True, slots=True)
class DimensionKind:
    """A kind of quantity.

    Attributes
    ----------
    forms : sets of operands
    quantity : ``length``, ``angle`` (degrees) or ``area``
    meaning : in words, for help
    signed : whether its sign at the time it is made is kept as `Dimension.side`
    modes : values of `Dimension.mode`
    """

    forms: tuple[Form, ...]
    quantity: str
    meaning: str
    signed: bool = False
    modes: tuple[str, ...] = ("",)


DIMENSIONS = MappingProxyType(
    {
        "length": DimensionKind((Form(("line",), 1),), "length", "length of a line"),
        "distance": DimensionKind(
            (
                Form(("point", "point"), 1),
                Form(("point", "line"), 1),
                Form(("line", "line"), 2),  # they stay parallel
                Form(("arc", "arc"), 1),
                Form(("point", "arc"), 1),
                Form(("line", "arc"), 1),
            ),
            "length",
            "distance of points, of a point and a line, of parallel lines; of circles from edge "
            "to edge: to another one, a line, a point",
            signed=True,
            # Of circles: side by side, or one inside the other; empty: concentric.
            modes=("", "outside", "inside"),
        ),
        "hdistance": DimensionKind(
            (Form(("point", "point"), 1),), "length", "distance along x", signed=True
        ),
        "vdistance": DimensionKind(
            (Form(("point", "point"), 1),), "length", "distance along y", signed=True
        ),
        "radius": DimensionKind(
            (Form(("round",), 1),), "length", "radius; of an ellipse the first"
        ),
        "diameter": DimensionKind((Form(("arc",), 1),), "length", "twice the radius"),
        "radius_b": DimensionKind(
            (Form(("ellipse",), 1),), "length", "second radius of an ellipse"
        ),
        "sweep": DimensionKind(
            (Form(("open_arc",), 1),), "angle", "angle from start to end of an arc"
        ),
        "arc_length": DimensionKind((Form(("open_arc",), 1),), "length", "length along an arc"),
        "angle": DimensionKind(
            (Form(("line", "line"), 1),),
            "angle",
            "angle between the directions of two lines",
            signed=True,
            modes=("", "supplement"),
        ),
        "xangle": DimensionKind(
            (Form(("line",), 1), Form(("ellipse",), 1)),
            "angle",
            "angle from the x axis",
        ),
        "total_length": DimensionKind(
            (Form(("curve*",), 1),), "length", "length of a chain of curves"
        ),
        "area": DimensionKind(
            (Form(("curve*",), 1),), "area", "area inside a closed chain of curves"
        ),
    }
)

#: Kinds of groups.
GROUPS = ("offset", "pattern", "slot", "polygon")

#: Prefixes of names: of entities by kind, then constraints, dimensions, groups.
PREFIXES = (*dict.fromkeys(kind.prefix for kind in ENTITIES.values()), "C", "d", "M")
