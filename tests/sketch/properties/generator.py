"""Random command lines for a sketch, of all kinds, most of them possible."""

from __future__ import annotations

import random
from collections.abc import Iterable

from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS, OPERANDS
from arael.sketch.document.records import Entity
from arael.sketch.geometry import chains, curve_of

#: Commands whose words are not the operands of a table.
_BY_HAND = frozenset({"image", "fix", "lock", "smooth", "area", "total_length"})


def snapshot(document: Document) -> tuple[object, ...]:
    """All that a document holds: records in their order, and the bits of its numbers."""
    tables = ("entities", "constraints", "dimensions", "parameters", "groups", "settings")
    return (
        *(tuple(getattr(document, table).items()) for table in tables),
        document.values.tobytes(),
    )


def perform(session: Session, line: str) -> None:
    """Run a line; ``drag POINT X Y`` by the editor."""
    if line.startswith("drag ") and "@" not in line:
        _, handle, x, y = line.split()
        session.editor.drag({handle: (float(x), float(y))})
    else:
        session.run(line)


class Generator:
    """Makes command lines that fit what is in a sketch now.

    Parameters
    ----------
    session : the sketch
    seed : of the random numbers
    most : entities at most; beyond that some are deleted
    """

    def __init__(self, session: Session, seed: int, most: int = 14) -> None:
        self.session = session
        self.random = random.Random(seed)
        self.most = most
        self.parameters = 0

    @property
    def document(self) -> Document:
        return self.session.document

    # --- lines ------------------------------------------------------------------------------

    def line(self) -> str:
        """The next command line."""
        count = len(self.document.entities)
        if count < 3:
            return self.entity()
        ways = [
            (3.0 if count < self.most else 0.0, self.entity),
            (6.0, self.constraint),
            (4.0, self.dimension),
            (2.0, self.value),
            (1.5, self.drag),
            (1.0, self.parameter),
            (1.0 if count < self.most else 4.0, self.delete),
            (0.5, self.lock),
            (0.5, self.flag),
            (0.7, self.several),
        ]
        weights, makers = zip(*ways, strict=True)
        return str(self.random.choices(makers, weights)[0]())

    def several(self) -> str:
        """Two commands that are one step."""
        return f"{self.entity()}; {self.constraint()}"

    def entity(self) -> str:
        pick, n = self.random, self.number
        a, b, c, d = (self.place() for _ in range(4))
        kinds = {
            "line": f"add_line {a} {b}",
            "polyline": f"add_line {a} {b} {c}",
            "chain": f"add_line {a}",
            "rect": f"add_rect {a} {b}{pick.choice(['', ' hv', ' driven'])}",
            "point": f"add_point {a}",
            "circle": f"add_circle {a} {n(0.5, 4)}",
            "circle2": f"add_circle2 {a} {b}",
            "arc": f"add_arc {a} {b} {c}",
            "ellipse": f"add_ellipse {a} {n(2, 4)} {n(0.5, 2)} {n(0, 170)}",
            "earc": f"add_earc_center {a} {n(2, 4)} {n(1, 2)} {n(0, 90)} {n(0, 80)} {n(120, 300)}",
            "bezier": f"add_spline {a} {b} {c} {d} bezier",
            "bspline": f"add_spline {a} {b} {c} {d} {self.place()}",
        }
        weights = [5, 2, 2, 1, 2, 3, 1, 3, 1, 1, 1, 1]
        return pick.choices(list(kinds.values()), weights)[0]

    def constraint(self) -> str:
        kinds = [kind for kind in CONSTRAINTS if kind not in _BY_HAND]
        kind = self.random.choice([*kinds, "coincident", "horizontal", "parallel", "tangent"])
        form = self.random.choice(CONSTRAINTS[kind].forms)
        operands = self.operands(form.operands)
        if operands is None:
            return self.entity()
        force = " force" if self.random.random() < 0.1 else ""
        return f"{kind} {operands}{force}"

    def dimension(self) -> str:
        kinds = [kind for kind in DIMENSIONS if kind not in _BY_HAND]
        kind = self.random.choice([*kinds, "length", "radius", "distance"])
        form = self.random.choice(DIMENSIONS[kind].forms)
        operands = self.operands(form.operands)
        if operands is None:
            return self.entity()
        angle = DIMENSIONS[kind].quantity == "angle"
        how = self.random.random()
        if how < 0.35:
            value = "driven"
        elif how < 0.45:
            value = "derived"
        elif how < 0.55 and kind != "xangle":  # see test_ranges_of_directions
            value = f">= {self.number(0.1, 3)}"
        elif how < 0.7 and self.document.parameters:
            value = self.random.choice(list(self.document.parameters)) + "*1.5"
        else:
            value = self.number(5, 170) if angle else self.number(0.5, 8)
        return f"{kind} {operands} {value}"

    def value(self) -> str:
        """Another value of something that has one."""
        names = [d.name for d in self.document.dimensions.values() if d.value is not None]
        if not names:
            return self.dimension()
        record = self.document.dimensions[self.random.choice(names)]
        assert record.value is not None
        now = record.value.number * self.random.uniform(0.5, 1.6)
        return f"set_driven {record.name} {now!r}"

    def drag(self) -> str:
        return f"drag {self.random.choice(self.points())} {self.number(-9, 9)} {self.number(-9, 9)}"

    def parameter(self) -> str:
        names = list(self.document.parameters)
        if names and self.random.random() < 0.6:
            name = self.random.choice(names)
            other = self.random.choice([*names, "2"])
            return f"param {name} {self.random.choice([self.number(0.5, 4), f'{other} + 0.5'])}"
        self.parameters += 1
        return f"param w{self.parameters} {self.number(0.5, 4)}"

    def delete(self) -> str:
        tables = [self.document.entities, self.document.constraints, self.document.dimensions]
        found = [name for table in tables for name in table]
        count = self.random.choice([1, 1, 2])
        return "delete " + " ".join(self.random.sample(found, min(count, len(found))))

    def lock(self) -> str:
        point = self.random.choice(self.points())
        return f"{self.random.choice(['lock', 'lock', 'unlock'])} {point}"

    def flag(self) -> str:
        name = self.random.choice(list(self.document.entities))
        dimensions = list(self.document.dimensions)
        ways = [f"constr {name}", f"quiet {name}", f"fix {name}"]
        if dimensions:
            ways.append(f"set_derived {self.random.choice(dimensions)}")
            ways.append(f"dim_pos {self.random.choice(dimensions)} offset 1.5")
        return self.random.choice(ways)

    # --- words ------------------------------------------------------------------------------

    def number(self, low: float, high: float) -> str:
        return f"{self.random.uniform(low, high):.3f}"

    def place(self) -> str:
        """A place, sometimes that of a point that is there."""
        if self.document.entities and self.random.random() < 0.3:
            return self.random.choice(self.points())
        return f"{self.number(-10, 10)},{self.number(-10, 10)}"

    def points(self) -> list[str]:
        return [
            entity.name if point == "pos" else f"{entity.name}.{point}"
            for entity in self.document.entities.values()
            for point in point_offsets(entity)
        ]

    def operands(self, classes: Iterable[str]) -> str | None:
        """Words for operands of some classes; None if there are too few."""
        words: list[str] = []
        for one in classes:
            found = [word for word in self._fitting(one.rstrip("*")) if word not in words]
            if not found:
                return None
            words.append(self.random.choice(found))
        return " ".join(words)

    def _fitting(self, operand: str) -> list[str]:
        entities: list[Entity] = list(self.document.entities.values())
        if operand == "point":
            return self.points()
        if operand == "end":
            ends = (".p1", ".p2", ".start", ".end")
            return [point for point in self.points() if point.endswith(ends)]
        return [one.name for one in entities if one.kind in OPERANDS[operand]]


class Everything(Generator):
    """Commands that modify, ask and select as well; groups, image, area and chains."""

    def line(self) -> str:
        """The next command line."""
        if len(self.document.entities) < 3 or self.random.random() < 0.6:
            return super().line()
        ways = [
            (3.0, self.cut),
            (2.0, self.corner),
            (3.0, self.transform),
            (2.0, self.group),
            (2.0, self.by_hand),
            (1.0, self.drag_command),
            (1.0, self.ask),
            (1.0, self.housekeeping),
            (0.5, self.shape),
        ]
        weights, makers = zip(*ways, strict=True)
        return str(self.random.choices(makers, weights)[0]())

    def some(self, *kinds: str, most: int = 3) -> list[str]:
        """Names of some entities of some kinds, of all without any; empty if there is none."""
        found = [e.name for e in self.document.entities.values() if not kinds or e.kind in kinds]
        return self.random.sample(found, min(len(found), self.random.randint(1, most)))

    def several_of(self, *kinds: str, count: int = 2) -> list[str] | None:
        found = [e.name for e in self.document.entities.values() if not kinds or e.kind in kinds]
        return self.random.sample(found, count) if len(found) >= count else None

    def about(self) -> str:
        return self.random.choice([self.random.choice(self.points()), self.place()])

    def cut(self) -> str:
        names, pick = self.several_of(), self.random
        if names is None:
            return self.entity()
        a, b = names
        nopin = pick.choice(["", "", " nopin"])
        ways = [
            f"split {a} {self.place()}{nopin}",
            f"split {a} by {b}{nopin}",
            f"trim {a} {self.place()}{nopin}",
            f"trim {a} by {b} {pick.choice(['forward', 'backward'])}{nopin}",
            f"extend {a} to {b}{pick.choice(['', ' forward', ' backward'])}{nopin}",
            f"extend {a} {self.place()}{nopin}",
        ]
        return pick.choice(ways)

    def corner(self) -> str:
        lines = self.several_of("line")
        word = self.random.choice(["fillet", "chamfer"])
        size = self.number(0.05, 1.5)
        if lines is None:
            return self.entity()
        ends = [point for point in self.points() if point.startswith("L")]
        if self.random.random() < 0.4:
            return f"{word} {self.random.choice(ends)} {size}"
        return f"{word} {lines[0]} {lines[1]} {size}"

    def transform(self) -> str:
        names = " ".join(self.some())
        ways = [
            f"move {names} @{self.number(-4, 4)},{self.number(-4, 4)}",
            f"rotate {names} about {self.about()} {self.number(-180, 180)}",
            f"scale {names} about {self.about()} {self.number(0.4, 2.2)}",
            f"move {names} from {self.about()} to {self.place()}",
        ]
        return self.random.choice(ways)

    def group(self) -> str:
        lines, pick = self.some("line", most=1), self.random
        if not lines or len(self.document.entities) > 2 * self.most:
            return self.delete()
        names = " ".join(self.some(most=2))
        line = lines[0]
        ways = [
            f"mirror {names} about {line}{pick.choice(['', ' noconstraint', ' strict'])}",
            f"offset_line {line} {self.number(0.1, 2)}{pick.choice(['', ' right', ' nopin'])}",
            f"pattern circular {names} about {self.about()} {pick.randint(2, 4)}",
            f"pattern rect {names} {pick.randint(2, 3)} {self.number(1, 4)}",
        ]
        if self.document.groups and pick.random() < 0.5:
            return f"delete {pick.choice(list(self.document.groups))}{pick.choice(['', ' all'])}"
        return pick.choice(ways)

    def shape(self) -> str:
        ways = [
            f"add_slot {self.place()} {self.place()} {self.number(0.3, 1.5)}",
            f"add_polygon {self.random.randint(3, 6)} {self.place()} {self.place()}",
            f"add_rect3 {self.place()} {self.place()} {self.place()}",
            f"add_rectcenter {self.place()} {self.place()}",
            f"add_circle3 {self.place()} {self.place()} {self.place()}",
        ]
        lines = self.several_of("line", count=3)
        if lines is not None:
            ways.append(f"add_circle2t {lines[0]} {lines[1]} {self.number(0.3, 2)}")
            ways.append(f"add_circle3t {' '.join(lines)}")
        return self.random.choice(ways)

    def by_hand(self) -> str:
        """The kinds whose words are not the operands of a table."""
        pair = self.several_of("line")
        names, line = self.some("line", "arc", most=4), self.some("line", most=1)
        ways = [f"lock {self.random.choice(self.points())} {self.place()}"]
        if pair is not None:
            a, b = pair
            ways += [
                f"image {a} {b} rotate {self.number(10, 170)} about {self.about()}",
                f"image {a} {b} shift {self.number(-3, 3)},{self.number(-3, 3)}",
            ]
        if names:
            ways.append(f"total_length {' '.join(names)} {self.number(3, 30)}")
        if line:
            ways += [f"length {line[0]} {line[0]}.length*1.1"]
            ways += [f"select {line[0]} chain"]
        loop = self.loop() or self.several_of("line", count=3)
        if loop:
            ways.append(f"area {' '.join(loop)} {self.number(3, 60)}")
        return self.random.choice(ways)

    def loop(self) -> list[str]:
        """Curves that make up a closed chain, in any order; empty if there is none."""
        document = self.document
        curves = [e for e in document.entities.values() if e.kind not in ("point", "circle")]
        blocks = [curve_of(e.kind, document.numbers_of(e.name).tolist()) for e in curves]
        found = [chain for chain in chains(blocks, 1e-6) if chain.closed]
        if not found:
            return []
        names = [curves[link.number].name for link in self.random.choice(found).links]
        self.random.shuffle(names)
        return names

    def drag_command(self) -> str:
        word = self.random.choice([*self.points(), *self.document.entities])
        return f"drag {word} @{self.number(-5, 5)},{self.number(-5, 5)}"

    def ask(self) -> str:
        names = [*self.document.entities, *self.document.constraints, *self.document.dimensions]
        name = self.random.choice(names)
        ways = ["free", "dof", "dof analyze", "cost", "list", f"why {name}", f"info {name}"]
        ways += [f"what_if {self.constraint()}", f"explain {self.dimension()}"]
        ways += [f"measure {' '.join(self.some(most=2))}", "list dims", f"find {self.place()}"]
        dimensions = list(self.document.dimensions)
        if dimensions:
            ways.append(f"sensitivity {self.random.choice(dimensions)}")
        return self.random.choice(ways)

    def housekeeping(self) -> str:
        names = list(self.document.parameters)
        ways = ["select all", "deselect", "freeze", f"style {self.some()[0]} dashed"]
        ways.append(f"select {self.some()[0]} linked")
        if names:
            self.parameters += 1
            ways.append(f"rename_param {self.random.choice(names)} v{self.parameters}")
            ways.append(f"del_param {self.random.choice(names)}")
        return self.random.choice(ways)
