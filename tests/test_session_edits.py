"""A session after any edits solves as a fresh one does on the same store.

The session takes over structures, gathered data, held blocks and the choice of the linear solver.
Each test would fail on a piece that is stale.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.result import Result
from arael.runtime.assembly import edits, shares
from arael.runtime.assembly.compiled import used_rows
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.assembly.scatter_plan import ScatterPlan
from arael.runtime.assembly.shares import Shares
from arael.session import Session

MODEL = """
struct Point {
    param pos: vec2
    param scale: real
    goal: vec2
    weight: real = 1
    seen: bool = true
    constraint near when seen { (pos - goal) * 0.3 * weight }
    constraint always { (pos - goal) * 0.02 }
    constraint unit { exp(scale * 0.2) - 1.2 + 0.1 * root.tilt }
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    d: vec2
    constraint tie { (b.pos - a.pos) * a.scale - d }
    constraint long when d.x > 1 { 0.1 * (norm(b.pos - a.pos) - d.x) }
}
root Net {
    tilt: real = 0
    points: arena of Point
    links: arena of Link
}
"""


@pytest.fixture(scope="module")
def net(tmp_path_factory: pytest.TempPathFactory) -> type:
    path = tmp_path_factory.mktemp("models") / "net.arael"
    path.write_text(MODEL, encoding="utf-8")
    return arael.load(path)


class Edited:
    """A model with the handles of its rows, and edits of it by name."""

    def __init__(self, net: type, points: int, seed: int, solver: str = "auto") -> None:
        self.solver = solver
        self.model: Any = net()
        self.rng = np.random.default_rng(seed)
        self.points: list[Any] = []
        self.links: list[tuple[Any, Any, Any]] = []
        self.freeze: tuple[str, ...] = ()
        self.labels: list[str] = []
        for k in range(points):
            self._point()
            if k:
                self._link(k - 1, k)

    def _point(self) -> None:
        k = len(self.points)
        goal = [k, 0.2 * self.rng.normal()]
        self.points.append(self.model.points.append(pos=goal, scale=1.0, goal=goal))

    def _link(self, i: int, j: int) -> None:
        a, b = self.points[i], self.points[j]
        d = [j - i + 0.1 * self.rng.normal(), 0.1]
        self.links.append((self.model.links.append(a=a, b=b, d=d), a, b))

    def _some(self, rows: list[Any]) -> Any:
        return rows[self.rng.integers(len(rows))]

    def append_link(self) -> None:
        i, j = self.rng.choice(len(self.points), 2, replace=False)
        self._link(int(i), int(j))

    def append_point(self) -> None:
        self._point()
        self._link(len(self.points) - 2, len(self.points) - 1)

    def remove_link(self) -> None:
        if self.links:
            at = int(self.rng.integers(len(self.links)))
            self.model.links.remove(self.links.pop(at)[0])

    def remove_point(self) -> None:
        if len(self.points) < 4 or self.labels:
            return
        at = int(self.rng.integers(len(self.points)))
        gone = self.points.pop(at)
        for link in [link for link in self.links if gone in link[1:]]:
            self.model.links.remove(link[0])
            self.links.remove(link)
        self.model.points.remove(gone)

    def fix(self) -> None:
        point = self._some(self.points)
        point.pos.fixed = point.scale.fixed = True

    def fix_part(self) -> None:
        self._some(self.points).pos.fixed = True

    def free(self) -> None:
        for point in self.points:
            if point.pos.fixed:
                point.pos.fixed = point.scale.fixed = False
                return

    def fix_many(self) -> None:
        for point in self.points[1::2]:
            point.pos.fixed = point.scale.fixed = True

    def free_all(self) -> None:
        self.model.points.pos.fixed[:] = self.model.points.scale.fixed[:] = False

    def freeze_or_free(self) -> None:
        self.freeze = () if self.freeze else ("points.scale",)

    def value(self) -> None:
        self._some(self.points).pos.value += self.rng.normal(size=2)

    def goal(self) -> None:
        self._some(self.points).goal += self.rng.normal(size=2)

    def weight(self) -> None:
        self.model.points.weight[int(self.rng.integers(len(self.points)))] = 2.0

    def tilt(self) -> None:
        self.model.tilt = float(self.rng.normal())

    def guard(self) -> None:
        point = self._some(self.points)
        point.seen = not point.seen

    def guard_of_link(self) -> None:
        if self.links:
            self._some(self.links)[0].d = [self.rng.choice([0.5, 1.5]), 0.1]

    def refer(self) -> None:
        if not self.links:
            return
        at = int(self.rng.integers(len(self.links)))
        link, _, b = self.links[at]
        a = self._some([p for p in self.points if p != b])
        link.a = a
        self.links[at] = (link, a, b)

    def swap(self) -> None:
        i, j = self.rng.choice(len(self.points), 2, replace=False)
        goal = self.model.points.goal
        goal[[i, j]] = goal[[j, i]]

    def residual(self) -> None:
        if self.labels:
            self.model.residuals.remove(self.labels.pop())
        else:
            self.labels.append("extra")
            text = "0.1 * (points[0].pos.x - points[2].pos.y - w)"
            self.model.residuals.add(text, label="extra", data={"w": 1.0})

    def residual_data(self) -> None:
        if self.labels:
            self.model.residuals["extra"].set_data(w=float(self.rng.normal()))

    def solve(self) -> Result:
        result: Result = self.model.solve(solver=self.solver, freeze=self.freeze)
        return result

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        return self.model.points.pos.value.copy(), self.model.points.scale.value.copy()

    def put(self, state: tuple[np.ndarray, np.ndarray]) -> None:
        self.model.points.pos.value[:], self.model.points.scale.value[:] = state


EDITS: dict[str, Callable[[Edited], None]] = {
    name: one
    for name, one in vars(Edited).items()
    if callable(one) and name[0] != "_" and name not in ("solve", "state", "put")
}


def same_components(warm: Result, cold: Result, what: str) -> None:
    """Components of a session's solve are those of a fresh one."""
    assert (warm.components is None) == (cold.components is None), what
    if warm.components is not None:
        assert warm.components.names == cold.components.names, what
        np.testing.assert_array_equal(warm.components.rows, cold.components.rows, what)
        np.testing.assert_array_equal(warm.components.status, cold.components.status, what)


def contents(one: Any) -> list[Any]:
    """Arrays and numbers of a plan, in a fixed order."""
    if isinstance(one, list | tuple):
        return [part for element in one for part in contents(element)]
    if isinstance(one, ScatterPlan):
        by_execution = [[key, shares] for key, shares in sorted(one._shares.items())]
        kept = one.active, one.pattern, one.placements, one.trash, one.behind, one.counts
        return contents((kept, one.diagonal_at, by_execution))
    if isinstance(one, BlockPattern):
        return contents((one.sizes, one.column_start, one.rows, one.value_start, one.by_rows))
    if isinstance(one, Placement | Shares):
        return contents(list(vars(one).values()))
    return [one]


def same_plan(warm: ScatterPlan, cold: ScatterPlan, what: str) -> None:
    """The plan that edits have come to is that of the store alone, to the last number."""
    warm.check()
    mine, theirs = contents(warm), contents(cold)
    assert len(mine) == len(theirs), what
    for one, other in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(one, other, err_msg=what)


def agree(edited: Edited, what: str) -> None:
    """Solve in the session at hand and in a fresh one from the same start."""
    session, start = edited.model.session, edited.state()
    warm, end = edited.solve(), edited.state()
    edited.put(start)
    object.__setattr__(edited.model, "_session", Session())
    cold, other = edited.solve(), edited.state()
    structure = session.earlier.structure
    if not structure.idle:
        same_plan(structure.plan, edited.model.session.earlier.structure.plan, what)
    assert warm.status == cold.status, what
    same_components(warm, cold, what)
    np.testing.assert_allclose(warm.start_cost, cold.start_cost, 1e-12, err_msg=what)
    np.testing.assert_allclose(warm.end_cost, cold.end_cost, 1e-8, 1e-16, err_msg=what)
    np.testing.assert_allclose(np.sort(warm.x), np.sort(cold.x), 1e-5, 1e-6, err_msg=what)
    for mine, theirs in zip(end, other, strict=True):
        np.testing.assert_allclose(mine, theirs, 1e-5, 1e-6, err_msg=what)
    # Instruments look at the store alone, whatever the session holds.
    names = edited.model.parameter_names()
    object.__setattr__(edited.model, "_session", session)
    edited.put(end)
    assert edited.model.parameter_names() == names, what
    assert len(cold.x) == len(warm.x), what
    if not edited.freeze:
        assert len(edited.model.serialize()) == len(warm.x), what


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    ("points", "seed", "solver"),
    [
        (4, 0, "auto"),
        (5, 1, "auto"),
        (6, 2, "band"),
        (7, 3, "schur"),
        (8, 4, "sparse"),
        (40, 5, "auto"),
        (41, 6, "auto"),
    ],
)
def test_a_session_after_random_edits_solves_as_a_fresh_one(
    net: type, points: int, seed: int, solver: str
) -> None:
    edited = Edited(net, points, seed, solver)
    agree(edited, "at first")
    done = []
    for _ in range(40):
        for _ in range(int(edited.rng.integers(1, 3))):
            name = str(edited.rng.choice(sorted(EDITS)))
            EDITS[name](edited)
            done.append(name)
        if edited.model.points.pos.fixed.all():
            edited.free_all()
            done.append("free_all")
        agree(edited, ", ".join(done[-6:]))


@pytest.mark.sweep(4)
@pytest.mark.parametrize("name", sorted(EDITS))
def test_after_each_edit_twice_a_session_solves_as_a_fresh_one(net: type, name: str) -> None:
    edited = Edited(net, 25, 7)
    agree(edited, "at first")
    for k in range(2):
        EDITS[name](edited)
        agree(edited, f"{name}, {k}")


def counted(edited: Edited) -> tuple[int, int]:
    counts = edited.model.session.counts
    return counts.problems, counts.analyses


def pattern_of(edited: Edited) -> Any:
    return edited.model.session.earlier.structure.pattern


def test_fixing_and_freeing_keeps_the_problem_and_the_solver(net: type) -> None:
    edited = Edited(net, 30, 5)
    edited.solve()
    pattern, (problems, analyses) = pattern_of(edited), counted(edited)
    point = edited.points[9]
    for fixed in (True, False, True):
        point.pos.fixed = point.scale.fixed = fixed
        where = point.pos.value.copy()
        assert edited.solve().converged
        assert pattern_of(edited) is pattern
        assert edited.model.session.earlier.structure.idle == fixed
        assert (where == point.pos.value).all() == fixed
    assert counted(edited) == (problems, analyses)


def test_a_fixed_row_between_two_parts_of_a_problem_leaves_two_components(net: type) -> None:
    edited = Edited(net, 30, 5)
    assert edited.solve().components is None
    for k in range(2):
        point = edited.points[9 + 11 * k]
        point.pos.fixed = point.scale.fixed = True
        agree(edited, f"{k + 1} rows fixed")
        found = edited.solve().components
        assert edited.model.session.earlier.structure.idle == k + 1
        assert (
            found is not None and found.names == ["points[0]", "points[10]", "points[21]"][: k + 2]
        )
        assert found.rows.tolist() == [[9, 20], [9, 10, 9]][k]
    edited.free_all()
    agree(edited, "all free")
    assert edited.solve().components is None


def test_what_is_fixed_for_long_leaves_the_system_when_it_is_much(net: type) -> None:
    edited = Edited(net, 30, 5)
    assert edited.solve().plan["n"] == 90
    edited.fix_many()
    assert edited.solve().plan["n"] == 45
    assert edited.model.session.earlier.structure.idle == 0


def test_a_row_that_was_never_in_the_system_takes_a_new_one(net: type) -> None:
    edited = Edited(net, 30, 5)
    edited.fix()
    assert edited.solve().plan["n"] == 87
    edited.free_all()
    assert edited.solve().plan["n"] == 90


def test_instruments_leave_out_what_a_session_holds(net: type) -> None:
    edited = Edited(net, 6, 5)
    edited.solve()
    edited.fix()
    edited.solve()
    assert edited.model.session.earlier.structure.idle == 1
    assert edited.model._problem().structure.idle == 0
    assert edited.model.hessian().shape == (15, 15)


def test_a_few_couplings_more_take_the_same_solver_without_comparing(net: type) -> None:
    edited = Edited(net, 60, 5)
    first = edited.solve().plan
    assert len(first["costs"]) > 3
    for k in range(3):
        edited._link(10 * k, 10 * k + 2)
        plan = edited.solve().plan
        assert plan["solver"] == first["solver"]
        assert list(plan["costs"]) == [first["solver"]]
        assert plan["why"].startswith(f"{first['solver']} was chosen for 180 unknowns earlier")
    assert counted(edited)[1] == 4
    for _ in range(20):
        edited.append_point()
    assert len(edited.solve().plan["costs"]) > 3  # a third larger


def test_a_band_that_has_grown_is_compared_again(net: type) -> None:
    edited = Edited(net, 60, 5)
    assert edited.solve().plan["solver"] == "band"
    edited._link(0, 59)
    plan = edited.solve().plan
    assert len(plan["costs"]) > 3
    assert plan["solver"] != "band"


def test_a_solver_with_options_is_made_as_they_say(net: type) -> None:
    edited = Edited(net, 60, 5)
    edited.solve()
    edited._link(3, 5)
    result = edited.model.solve(solver_options={"ordering": "natural"})
    assert len(result.plan["costs"]) > 3
    edited._link(13, 15)
    assert len(edited.solve().plan["costs"]) > 3  # what options made is no choice
    assert edited.model.solve(solver="sparse").plan["why"] == "sparse was requested"


def test_the_first_solve_of_a_small_problem_imports_nothing(tmp_path: Path) -> None:
    path = tmp_path / "tiny.arael"
    path.write_text("root Tiny { param x: real\n constraint c { x - 2 } }", encoding="utf-8")
    code = (
        "import sys, arael\n"
        f"model = arael.load({str(path)!r}, interpret=True)(x=0)\n"
        "before = set(sys.modules)\n"
        "assert model.solve().plan['solver'] == 'dense'\n"
        "print(sorted(set(sys.modules) - before))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "[]\n", done.stderr


def test_an_edit_places_only_what_is_new(net: type, monkeypatch: pytest.MonkeyPatch) -> None:
    edited = Edited(net, 60, 5)
    edited.solve()
    placed: list[int] = []

    def counting(ways: Any, blocks: Any, n: int, nowhere: int) -> Any:
        placed.append(n)
        return used_rows(ways, blocks, n, nowhere)

    monkeypatch.setattr(edits, "used_rows", counting)
    for what, edit in (
        ("appended", lambda: edited._link(20, 21)),
        ("removed", lambda: edited.model.links.remove(edited.links.pop(7)[0])),
        ("switched off", lambda: setattr(edited.points[9], "seen", False)),
        ("switched on", lambda: setattr(edited.points[9], "seen", True)),
    ):
        (problems, analyses), pattern = counted(edited), pattern_of(edited)
        if what == "removed":  # another link couples these points
            edited._link(7, 8)
            edited.solve()
            problems, placed[:] = problems + 1, []
        edit()
        edited.solve()
        # Of a removed row the rows before and after are looked at, for the blocks it leaves.
        assert sum(placed) <= 2, what
        assert placed, what
        assert counted(edited) == (problems + 1, analyses), what
        assert pattern_of(edited) is pattern, what
        placed.clear()
        agree(edited, what)
        placed.clear()


@pytest.mark.sweep(2)
@pytest.mark.parametrize("grain", [None, 300.0])
def test_random_edits_of_a_larger_problem_solve_as_fresh(
    net: type, monkeypatch: pytest.MonkeyPatch, grain: float | None
) -> None:
    if grain is not None:  # what threads share is cut into shares, as of large problems
        monkeypatch.setattr(shares, "GRAIN", grain)
    edited = Edited(net, 700, 11)
    agree(edited, "at first")
    plan = edited.model.session.earlier.structure.plan
    assert plan.pattern.value_count > shares._CACHED
    assert (plan.shares[0].count > 1) == (grain is not None)
    couplings = [lambda k: edited._link(k, k + 1), lambda k: edited._link(k, k - 1)]
    for k in range(24):
        name = str(edited.rng.choice(["couple", "remove_link", "guard_of_link", "guard", "refer"]))
        if name == "couple":
            couplings[k % 2](int(edited.rng.integers(1, 698)))
        else:
            EDITS[name](edited)
        agree(edited, f"{k}: {name}")


LED = """
struct Early { param p: vec3; goal: vec3; constraint hold { (p - goal) * 0.5 } }
struct Middle { param m: vec2; goal: vec2; constraint hold { (m - goal) * 0.5 } }
struct Late { param p: vec3; goal: vec3; constraint hold { (p - goal) * 0.5 } }
struct Before {
    a: ref Early in root.early
    b: ref Middle in root.middle
    d: real
    constraint tie { a.p.x * b.m.x + a.p.z - b.m.y - d }
}
struct After {
    a: ref Late in root.late
    b: ref Middle in root.middle
    d: real
    constraint tie { a.p.x * b.m.x + a.p.z - b.m.y - d }
}
root Led {
    early: list of Early
    middle: list of Middle
    late: list of Late
    before: arena of Before
    after: arena of After
}
"""


@pytest.mark.slow
def test_edits_of_instances_in_the_order_of_their_leads(tmp_path: Path) -> None:
    """Leads stand before and behind what they are coupled with, now more of these, now of those."""
    path = tmp_path / "led.arael"
    path.write_text(LED, encoding="utf-8")
    model: Any = arael.load(path)()
    rng = np.random.default_rng(4)
    for name, kind, width in (("early", "p", 3), ("middle", "m", 2), ("late", "p", 3)):
        goal = rng.normal(size=(6, width))
        getattr(model, name).extend(**{kind: goal, "goal": goal})
    links: dict[str, list[tuple[Any, int, int]]] = {"before": [], "after": []}

    def append(kind: str, i: int, j: int) -> None:
        ends = {"a": (model.early if kind == "before" else model.late)[i], "b": model.middle[j]}
        row = getattr(model, kind).append(**ends, d=0.1 * rng.normal())
        links[kind].append((row, i, j))

    for kind in links:
        for i, j in rng.permutation([(i, j) for i in range(6) for j in range(6)]):
            append(kind, int(i), int(j))
    model.solve()
    orders: set[bool] = set()
    kept = 0
    for k in range(40):
        before = model.session.earlier.structure.pattern
        kind = ("before", "after")[(k // 10) % 2]
        if k % 3 == 2:
            row, i, j = links[kind].pop(int(rng.integers(len(links[kind]))))
            getattr(model, kind).remove(row)
        else:
            append(kind, int(rng.integers(6)), int(rng.integers(6)))
        session, start = model.session, model.serialize()
        model.solve()
        warm = model.session.earlier.structure.plan
        orders.add(warm.pattern.by_rows)
        kept += warm.pattern is before
        model.deserialize(start)
        object.__setattr__(model, "_session", Session())
        model.solve()
        same_plan(warm, model.session.earlier.structure.plan, f"edit {k}")
        object.__setattr__(model, "_session", session)
    assert orders == {False, True}
    assert 25 < kept < 40
