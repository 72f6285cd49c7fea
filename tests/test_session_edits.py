"""A session after any edits solves as a fresh one does on the same store.

The session takes over structures, gathered data, held blocks and the choice of the linear solver.
Each test would fail on a piece that is stale.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import arael
from arael.result import Result
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

    def __init__(self, net: type, points: int, seed: int) -> None:
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
        result: Result = self.model.solve(freeze=self.freeze)
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


def agree(edited: Edited, what: str) -> None:
    """Solve in the session at hand and in a fresh one from the same start."""
    session, start = edited.model.session, edited.state()
    warm, end = edited.solve(), edited.state()
    edited.put(start)
    object.__setattr__(edited.model, "_session", Session())
    cold, other = edited.solve(), edited.state()
    assert warm.status == cold.status, what
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


@pytest.mark.parametrize(("points", "seed"), [(4, 0), (5, 1), (6, 2), (40, 3), (41, 4)])
def test_a_session_after_random_edits_solves_as_a_fresh_one(
    net: type, points: int, seed: int
) -> None:
    edited = Edited(net, points, seed)
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


@pytest.mark.parametrize("name", sorted(EDITS))
def test_after_each_edit_twice_a_session_solves_as_a_fresh_one(net: type, name: str) -> None:
    edited = Edited(net, 25, 7)
    agree(edited, "at first")
    for k in range(2):
        EDITS[name](edited)
        agree(edited, f"{name}, {k}")
