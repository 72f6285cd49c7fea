"""A sketch with every kind of entity, and with constraints and dimensions of most kinds."""

from __future__ import annotations

from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension, Parameter

ENTITIES: list[tuple[str, list[float], dict[str, object]]] = [
    ("line", [0, 0, 60, 0], {}),
    ("line", [60, 0, 60, 40], {"style": "dashed"}),
    ("line", [60, 40, 0, 40], {}),
    ("line", [0, 40, 0, 0], {}),
    ("circle", [20, 20, 8], {}),
    ("circle", [45, 20, 8], {"construction": True}),
    ("line", [-8, 20, 68, 20], {"construction": True, "style": "dashdot"}),
    ("arc", [60, 20, 60, 8, 60, 32, 12], {}),
    ("arc", [0, 60, 5, 60, 0, 55, 5], {"clockwise": True}),
    ("bezier", [0, 90, 5, 99, 15, 99, 20, 90], {}),
    ("bspline", [0, 45, 10, 60, 25, 45, 40, 62, 60, 48], {}),
    ("ellipse", [20, 75, 15, 6, 0.3], {}),
    ("ellipse", [20, 75, 3, 6, 0.3], {}),
    ("earc", [50, 75, 58, 75, 42, 75, 8, 5, 0], {}),
    ("point", [5, 5], {}),
    ("line", [0, 40, -15, 60], {}),
]

CONSTRAINTS: list[tuple[str, tuple[str, ...], tuple[float, ...]]] = [
    ("parallel", ("L0", "L2"), ()),
    ("coincident", ("L0.p2", "L1.p1"), ()),
    ("coincident", ("L1.p2", "L2.p1"), ()),
    ("perpendicular", ("L0", "L3"), ()),
    ("equal", ("A0", "A1"), ()),
    ("point_on", ("A0.center", "L4"), ()),
    ("lock", ("P0",), (5.0, 5.0)),
    ("concentric", ("EA0", "EA1"), ()),
    ("tangent", ("L1", "A2"), ()),
    ("midpoint", ("P0", "L0"), ()),
    ("symmetry", ("L0", "L4", "L2"), ()),
]

DIMENSIONS: list[tuple[str, tuple[str, ...], str, float]] = [
    ("length", ("L0",), "width", 60.0),
    ("vdistance", ("L1.p1", "L1.p2"), "40", 40.0),
    ("hdistance", ("P0", "A0.center"), "15 mm", 15.0),
    ("distance", ("A0.center", "A1.center"), "25", 25.0),
    ("distance", ("P0", "L0"), "5", 5.0),
    ("radius", ("A0",), "8", 8.0),
    ("diameter", ("A1",), "16", 16.0),
    ("radius", ("EA0",), "15", 15.0),
    ("radius_b", ("EA0",), "6", 6.0),
    ("angle", ("L2", "L5"), "53", 53.13),
    ("sweep", ("A2",), "180", 180.0),
    ("arc_length", ("A3",), "23.5", 23.5),
    ("xangle", ("L5",), "127", 126.87),
    ("total_length", ("L0", "L1"), "100", 100.0),
    ("area", ("L0", "L1", "L2", "L3"), "2400", 2400.0),
]


def plate(unit: str = "mm", shift: float = 0.0, scale: float = 1.0) -> Document:
    """The sketch; `scale` multiplies lengths, `shift` moves along x."""
    document = Document()
    with document.transaction("plate"):
        document.set_setting("unit", unit)
        document.put("parameters", Parameter("width", Amount("60", 60.0)))
        for kind, numbers, flags in ENTITIES:
            turn = 1 if kind in ("ellipse", "earc") else 0
            radii = {"circle": 1, "arc": 1, "ellipse": 2, "earc": 2}.get(kind, 0)
            count = len(numbers) - turn - radii
            placed = [
                scale * x + (scale * shift if i < count and i % 2 == 0 else 0.0)
                for i, x in enumerate(numbers[: len(numbers) - turn])
            ]
            document.add_entity(kind, placed + numbers[len(numbers) - turn :], **flags)
        document.put("constraints", Constraint("CL0H", "horizontal", ("L0",)))
        for kind, args, given in CONSTRAINTS:
            document.put("constraints", Constraint(document.next_name("C"), kind, args, given))
        for i, (kind, args, text, number) in enumerate(DIMENSIONS):
            document.put(
                "dimensions",
                Dimension(document.next_name("d"), kind, args, Amount(text, number),
                          derived=i % 5 == 4),
            )  # fmt: skip
        document.put(
            "dimensions",
            Dimension(
                document.next_name("d"),
                "length",
                ("L3",),
                None,
                Amount("30", 30.0),
                Amount("50", 50.0),
            ),
        )
    return document
