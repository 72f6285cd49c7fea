"""FreeCAD's planegcs by the package `planegcs`, its three methods in turn as FreeCAD tries them.

Its diagnosis is part of the first solve after constraints changed; the package passes on neither
the count of freedoms nor the lists of redundant and conflicting constraints.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

from planegcs import Algorithm, SolveStatus
from planegcs import Sketch as Solver

from benchmarks.sketch.repeating import AbsentError, main, repeated
from benchmarks.sketch.sketches import Rule, Sketch

SETTINGS = "largest step or error 1e-10; DogLeg, else Levenberg-Marquardt, else BFGS"
WAYS = (Algorithm.DogLeg, Algorithm.LevenbergMarquardt, Algorithm.BFGS)


class System:
    """A sketch in the solver."""

    def __init__(self, sketch: Sketch, rules: Sequence[Rule]) -> None:
        self.sketch, self.solver = sketch, Solver()
        self.points = [self.solver.add_point(x, y) for x, y in sketch.points.tolist()]
        self.numbers = 2 * len(self.points)
        self.lines = [self.solver.add_line(self.points[a], self.points[b]) for a, b in sketch.lines]
        self.radii = []
        self.circles = []
        for c, radius in zip(sketch.circles, sketch.radii.tolist(), strict=True):
            self.radii.append(self.numbers)  # the number that is given to its radius
            self.numbers += 1
            self.circles.append(self.solver.add_circle(self.points[c], radius))
        self.arcs: list[int] = []
        self.arms: list[dict[int, int]] = []
        for arc in sketch.arcs:
            self._arc(*arc)
        self.values: list[int] = []
        self.tags = [self.add(rule) for rule in rules]

    def _arc(self, center: int, start: int, end: int) -> None:
        (cx, cy), (sx, sy), (ex, ey) = self.sketch.points[[center, start, end]].tolist()
        turns = (math.atan2(sy - cy, sx - cx), math.atan2(ey - cy, ex - cx))
        arc = self.solver.add_arc(self.points[center], math.hypot(sx - cx, sy - cy), *turns)
        self.arcs.append(arc)
        self.solver.arc_rules(arc)
        # Its ends are points of its own, made just before it.
        self.solver.coincident(arc - 2, self.points[start])
        self.solver.coincident(arc - 1, self.points[end])
        self.arms.append(
            {p: self.solver.add_line(self.points[center], self.points[p]) for p in (start, end)}
        )

    def add(self, rule: Rule) -> list[int]:
        """Add a rule; its tags."""
        solver, of = self.solver, rule.of
        numbers = [solver.add_param(v) for v in rule.values] if rule.kind != "lock" else []
        self.values.append(numbers[0] if numbers else -1)
        if rule.kind == "lock":
            return list(solver.fix_point(self.points[of[0]], *rule.values))
        if rule.kind == "horizontal":
            return [solver.horizontal(self.lines[of[0]])]
        if rule.kind == "vertical":
            return [solver.vertical(self.lines[of[0]])]
        if rule.kind == "length":
            a, b = self.sketch.lines[of[0]]
            return [solver.p2p_distance(self.points[a], self.points[b], *numbers)]
        if rule.kind == "distance":
            return [solver.p2p_distance(self.points[of[0]], self.points[of[1]], *numbers)]
        if rule.kind == "equal":
            return [solver.equal_length(self.lines[of[0]], self.lines[of[1]])]
        if rule.kind == "radius":
            return [solver.circle_radius(self.circles[of[0]], *numbers)]
        if rule.kind == "equal_radius":
            return [solver.solver.equal_radius_cc(self.circles[of[0]], self.circles[of[1]])]
        if rule.kind == "arc_radius":
            return [solver.solver.arc_radius(self.arcs[of[0]], *numbers)]
        if rule.kind == "equal_arcs":
            return [solver.solver.equal_radius_aa(self.arcs[of[0]], self.arcs[of[1]])]
        if rule.kind == "tangent":
            line, arc = self.sketch.lines[of[0]], self.sketch.arcs[of[1]]
            shared = next(p for p in arc[1:] if p in line)
            return [solver.perpendicular(self.lines[of[0]], self.arms[of[1]][shared])]
        raise AbsentError(f"no {rule.kind} in planegcs")

    def remove(self, tags: Sequence[int]) -> None:
        """Remove a rule by its tags."""
        for tag in tags:
            self.solver.solver.clear_by_tag(tag)

    def solve(self) -> str:
        """Solve from where everything is."""
        for way in WAYS:  # in turn, as FreeCAD does
            ended = self.solver.solve(way)
            if ended == SolveStatus.Success:
                return "solved"
        return str(ended).rpartition(".")[2].lower()

    def answer(self) -> dict[str, list[float]]:
        """Points and radii."""
        points = [v for p in self.points for v in self.solver.get_point(p)]
        return {"points": points, "radii": [self.solver.get_param(r) for r in self.radii]}


def _found(system: System, times: list[float], said: str) -> dict[str, Any]:
    return {
        "times": times,
        "answer": system.answer(),
        "said": said,
        "settings": SETTINGS,
        "version": "planegcs 0.1.1 (FreeCAD)",
    }


def resolve(sketch: Sketch, budget: float) -> dict[str, Any]:
    """A changed length, solved again."""
    if sketch.equations > 5000:
        raise AbsentError("not asked: dense; by its growth a minute a solve")
    system = System(sketch, sketch.rules)
    said = system.solve()

    def turn(number: int) -> None:
        nonlocal said
        value = sketch.targets[number % len(sketch.targets)]
        system.solver.set_param(system.values[sketch.changed], value)
        said = system.solve()

    times = repeated(budget, turn)
    turn(1)
    return _found(system, times, said)


def freedom(sketch: Sketch, budget: float) -> dict[str, Any]:
    """Not to be had."""
    raise AbsentError("part of a solve after an edit; the package does not pass it on")


def _with(sketch: Sketch, rule: Rule, budget: float) -> dict[str, Any]:
    system = System(sketch, sketch.rules)
    system.solve()
    said = ""

    def turn(_: int) -> None:
        nonlocal said
        tags = system.add(rule)
        said = system.solve()
        system.remove(tags)

    return _found(system, repeated(budget, turn), said)


def edit(sketch: Sketch, budget: float) -> dict[str, Any]:
    """The dimension that changes removed and added, in turns, each with a solve."""
    system = System(sketch, sketch.rules)
    said = system.solve()
    tags = system.tags[sketch.changed]

    def turn(number: int) -> None:
        nonlocal said, tags
        if number % 2:
            tags = system.add(sketch.rules[sketch.changed])
        else:
            system.remove(tags)
            tags = []
        said = system.solve()

    times = repeated(budget, turn)
    if not tags:
        turn(1)
    return _found(system, times, said)


def drag(sketch: Sketch, budget: float) -> dict[str, Any]:
    """The end held at the cursor by two coordinates, frame by frame."""
    system = System(sketch, sketch.rules)
    said = system.solve()
    x, y = sketch.points[sketch.grabbed].tolist()
    cursor = [system.solver.add_param(v) for v in (x, y)]
    system.solver.solver.coordinate_x(system.points[sketch.grabbed], cursor[0])
    system.solver.solver.coordinate_y(system.points[sketch.grabbed], cursor[1])
    times = []
    for place in sketch.path.tolist():
        began = time.perf_counter()
        for number, value in zip(cursor, place, strict=True):
            system.solver.set_param(number, value)
        said = system.solve()
        times.append(time.perf_counter() - began)
    return _found(system, times, said)


TASKS = {
    "resolve": resolve,
    "freedom": freedom,
    "edit": edit,
    "redundant": lambda s, b: _with(s, s.candidates["redundant"], b),
    "contradicting": lambda s, b: _with(s, s.candidates["contradicting"], b),
    "drag": drag,
}

if __name__ == "__main__":
    main(TASKS, "planegcs")
