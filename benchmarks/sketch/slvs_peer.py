"""SolveSpace's solver by its wheel `slvs`: entities and constraints in a table of the module.

A constraint's value cannot be changed, so the length that changes is that of a line in the fixed
group, to which the sketch's line is equal: a new value is then one number set, as in its own
program. Removing a constraint means building the table anew, which counts.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import slvs

from benchmarks.sketch.repeating import AbsentError, main, repeated
from benchmarks.sketch.sketches import Rule, Sketch
from benchmarks.sketch.writing import command

SETTINGS = "largest residual 1e-8"
ENDS = {
    0: "solved",
    1: "inconsistent",
    2: "did not converge",
    3: "refused: too many unknowns",
    4: "solved, redundant",
}
FIXED, DRAWN = 1, 2


class Table:
    """A sketch in the module's table; there is one at a time."""

    def __init__(self, sketch: Sketch, rules: Sequence[Rule], driven: int = -1) -> None:
        self.sketch, self.gauge = sketch, 0
        self.handles: dict[int, Rule] = {}
        slvs.clear_sketch()
        self.plane = slvs.add_base_2d(FIXED)
        self.normal = slvs.add_normal_3d(FIXED, 1.0, 0.0, 0.0, 0.0)
        self.points = [
            slvs.add_point_2d(DRAWN, x, y, self.plane) for x, y in sketch.points.tolist()
        ]
        self.lines = [
            slvs.add_line_2d(DRAWN, self.points[a], self.points[b], self.plane)
            for a, b in sketch.lines
        ]
        self.radii = [slvs.add_distance(DRAWN, r, self.plane) for r in sketch.radii.tolist()]
        self.circles = [
            slvs.add_circle(DRAWN, self.normal, self.points[c], r, self.plane)
            for c, r in zip(sketch.circles, self.radii, strict=True)
        ]
        self.arcs = [
            slvs.add_arc(DRAWN, self.normal, *(self.points[p] for p in arc), self.plane)
            for arc in sketch.arcs
        ]
        for number, rule in enumerate(rules):
            if number == driven:
                self._drive(rule)
            else:
                self.add(rule)

    def _drive(self, rule: Rule) -> None:
        ends = [slvs.add_point_2d(FIXED, x, -10.0, self.plane) for x in (0.0, rule.values[0])]
        self.gauge = ends[1]["param"][0]
        line = slvs.add_line_2d(FIXED, *ends, self.plane)
        slvs.equal(DRAWN, self.lines[rule.of[0]], line, self.plane)

    def add(self, rule: Rule) -> None:
        """Add a rule, and remember its handle for the list of culprits."""
        made = self._add(rule)
        self.handles[made["h"]] = rule

    def _add(self, rule: Rule) -> Any:
        of, plane = rule.of, self.plane
        value = rule.values[0] if rule.values else 0.0
        if rule.kind == "lock":
            place = slvs.add_point_2d(FIXED, *rule.values, plane)
            return slvs.coincident(DRAWN, self.points[of[0]], place, plane)
        if rule.kind == "horizontal":
            return slvs.horizontal(DRAWN, self.lines[of[0]], plane)
        if rule.kind == "vertical":
            return slvs.vertical(DRAWN, self.lines[of[0]], plane)
        if rule.kind == "length":
            a, b = self.sketch.lines[of[0]]
            return slvs.distance(DRAWN, self.points[a], self.points[b], value, plane)
        if rule.kind == "distance":
            return slvs.distance(DRAWN, self.points[of[0]], self.points[of[1]], value, plane)
        if rule.kind == "equal":
            return slvs.equal(DRAWN, self.lines[of[0]], self.lines[of[1]], plane)
        if rule.kind == "radius":
            return slvs.diameter(DRAWN, self.circles[of[0]], 2 * value)
        if rule.kind == "equal_radius":
            return slvs.equal(DRAWN, self.circles[of[0]], self.circles[of[1]], plane)
        if rule.kind == "arc_radius":
            return slvs.diameter(DRAWN, self.arcs[of[0]], 2 * value)
        if rule.kind == "equal_arcs":
            return slvs.equal(DRAWN, self.arcs[of[0]], self.arcs[of[1]], plane)
        if rule.kind == "tangent":
            return slvs.tangent(DRAWN, self.arcs[of[1]], self.lines[of[0]], plane)
        raise AbsentError(f"no {rule.kind} in SolveSpace")

    def solve(self, culprits: bool = False) -> dict[str, Any]:
        """Solve from where everything is; with the commands of the constraints to blame."""
        if not culprits:
            return {**slvs.solve_sketch(DRAWN, False), "culprits": []}
        ended, bad = slvs.solve_sketch(DRAWN, True)
        rules = [self.handles[h] for h in bad if h in self.handles]
        return {**ended, "culprits": [command(self.sketch, rule) for rule in rules]}

    def answer(self) -> dict[str, list[float]]:
        """Points and radii."""
        value = slvs.get_param_value
        points = [value(h) for p in self.points for h in p["param"][:2]]
        return {"points": points, "radii": [value(r["param"][0]) for r in self.radii]}

    def start_from(self, answer: Mapping[str, Sequence[float]]) -> None:
        """Move everything."""
        for p, x, y in zip(self.points, answer["points"][::2], answer["points"][1::2], strict=True):
            slvs.set_param_value(p["param"][0], x)
            slvs.set_param_value(p["param"][1], y)
        for r, radius in zip(self.radii, answer["radii"], strict=True):
            slvs.set_param_value(r["param"][0], radius)


def _found(table: Table, times: list[float], said: str, **more: Any) -> dict[str, Any]:
    return {
        "times": times,
        "answer": table.answer(),
        "said": said,
        "settings": SETTINGS,
        "version": "SolveSpace (slvs 3.3)",
        **more,
    }


def _refused(ended: Mapping[str, Any]) -> None:
    if ended["result"] == 3:
        raise AbsentError(ENDS[3])


def resolve(sketch: Sketch, budget: float) -> dict[str, Any]:
    """A changed length, solved again."""
    table = Table(sketch, sketch.rules, sketch.changed)
    _refused(table.solve())
    said: dict[str, Any] = {}

    def turn(number: int) -> None:
        slvs.set_param_value(table.gauge, sketch.targets[number % len(sketch.targets)])
        said.update(table.solve())

    times = repeated(budget, turn)
    turn(1)
    return _found(table, times, ENDS[said["result"]])


def freedom(sketch: Sketch, budget: float) -> dict[str, Any]:
    """The count of freedoms comes with every solve."""
    table = Table(sketch, sketch.rules)
    ended = table.solve()
    _refused(ended)
    times = repeated(budget, lambda _: ended.update(table.solve()))
    return _found(table, times, "with a solve", freedoms=ended["dof"])


def _with(sketch: Sketch, rule: Rule, budget: float, restart: bool = False) -> dict[str, Any]:
    """Build with a rule more, from a solved state, and solve with the search for culprits."""
    table = Table(sketch, sketch.rules)
    _refused(table.solve())
    solved = table.answer()
    ended: dict[str, Any] = {}

    def turn(_: int) -> None:
        table.__init__(sketch, (*sketch.rules, rule))  # type: ignore[misc]
        table.start_from(solved)
        ended.update(table.solve(True))

    times = repeated(budget, turn)
    said = ENDS[ended["result"]]
    if ended["result"] in (1, 4):
        said += f"; named: {', '.join(ended['culprits']) or 'nothing'}"
    return _found(table, times, said)


def edit(sketch: Sketch, budget: float) -> dict[str, Any]:
    """Without the dimension that changes and with it, in turns: build, solve, verdict."""
    table = Table(sketch, sketch.rules)
    _refused(table.solve())
    solved = table.answer()
    less = (*sketch.rules[: sketch.changed], *sketch.rules[sketch.changed + 1 :])
    ended: dict[str, Any] = {}

    def turn(number: int) -> None:
        table.__init__(sketch, sketch.rules if number % 2 else less)  # type: ignore[misc]
        table.start_from(solved)
        ended.update(table.solve(True))

    times = repeated(budget, turn)
    turn(1)
    return _found(table, times, ENDS[ended["result"]])


def drag(sketch: Sketch, budget: float) -> dict[str, Any]:
    """The end is put at the cursor and held by ``WHERE_DRAGGED``, frame by frame."""
    table = Table(sketch, sketch.rules)
    table.solve()
    slvs.dragged(DRAWN, table.points[sketch.grabbed], table.plane)
    times, ended = [], {}
    for x, y in sketch.path.tolist():
        began = time.perf_counter()
        for handle, value in zip(table.points[sketch.grabbed]["param"], (x, y), strict=False):
            slvs.set_param_value(handle, value)
        ended = table.solve()
        times.append(time.perf_counter() - began)
    return _found(table, times, ENDS[ended["result"]])


TASKS = {
    "resolve": resolve,
    "freedom": freedom,
    "edit": edit,
    "redundant": lambda s, b: _with(s, s.candidates["redundant"], b),
    "contradicting": lambda s, b: _with(s, s.candidates["contradicting"], b),
    "drag": drag,
}

if __name__ == "__main__":
    main(TASKS, "SolveSpace")
