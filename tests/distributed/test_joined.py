"""Groups of small problems: as one instance, with the results of each alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import arael
from arael.compiler.cache import digest
from arael.distributed import compiled, contents, joined
from arael.distributed.groups import solve_group
from arael.distributed.work import Row, Settings, Task

GRAPHS = """
struct Pose { param p: vec2; param th: real
    sights: list of Sight }
struct Sight { mark: ref Mark in root.marks; bearing: real; range: real
    constraint seen {
        let d = mark.p - parent.p
        [root.weight * (norm(d) - range), 5 * sin(atan2(d.y, d.x) - parent.th - bearing)]
    } }
struct Mark { param p: vec2; count: int; offsets: real = 0.5 }
struct Label { name: string }
struct Extra { k: real }
struct Step { a: ref Pose in root.poses; b: ref Pose in root.poses; d: vec2; turn: real
    constraint moved loss huber(3) {
        let e = b.p - a.p
        [10 * (cos(a.th) * e.x + sin(a.th) * e.y - d.x),
         10 * (-sin(a.th) * e.x + cos(a.th) * e.y - d.y), 10 * rad_diff(b.th - a.th, turn)]
    } }
root Graph : f64 {
    weight: real = 1
    poses: list of Pose
    marks: list of Mark
    steps: list of Step
    labels: list of Label
    extra: Extra?
    solve {
        pass rough { weight = 0.1 max_iters = 20 }
        pass fine { weight = 2 }
    }
}
"""

BOWLS = """
struct Bowl { param q: quaternion; param s: real in 0 .. 2; k: real; axis: vec3
    constraint deep { [q.rotate([0, 0, 1]) - axis, 0.3 * q.rotate([1, 0, 0]).y] }
    constraint bounded { [0.1 * (s - k), s * s - k] } }
root Bowls : f64 { bowls: list of Bowl; scale: real = 1 }
"""

SHARED = """
struct Point { x: real; y: real
    constraint fit { root.a * x - y } }
root Shared : f64 { param a: real; points: list of Point }
"""


@pytest.fixture
def sent() -> Iterator[Callable[[type], str]]:
    """Hand a model to this process as to a worker; its hash."""
    kept = []

    def send(kind: Any) -> str:
        data = msgspec.msgpack.encode(compiled.content_of(kind.compiled))
        kept.append(digest(data))
        contents.arrive(kept[-1], data)
        return kept[-1]

    yield send
    for one in kept:
        contents.forget(one)


def graph(kind: Any, seed: int) -> Any:
    """A path of 3 to 6 poses that see two marks."""
    rng = np.random.default_rng(seed)
    model = kind()
    marks = rng.uniform(3, 6, (2, 2))
    model.marks.extend(p=marks + rng.normal(0, 0.3, (2, 2)), count=[1, 2])
    at = np.zeros(3)
    for k in range(3 + seed % 4):
        pose = model.poses.append(p=at[:2] + rng.normal(0, 0.2, 2) * (k > 0), th=at[2])
        for m in (0, 1):
            d = marks[m] - at[:2]
            bearing = np.arctan2(d[1], d[0]) - at[2] + rng.normal(0, 0.02)
            pose.sights.append(mark=m, bearing=bearing, range=np.hypot(*d) + rng.normal(0, 0.02))
        at += [np.cos(at[2]), np.sin(at[2]), 0.2]
    count = len(model.poses)
    model.steps.extend(
        a=np.arange(count - 1), b=np.arange(1, count), d=np.tile([1.0, 0], (count - 1, 1)), turn=0.2
    )
    model.labels.extend(name=[f"label {k}" for k in range(seed % 3)])
    model.poses[0].p.fixed = model.poses[0].th.fixed = True
    return model


def bowl(kind: Any, seed: int) -> Any:
    rng = np.random.default_rng(seed)
    model = kind()
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    model.bowls.append(q=[1, 0, 0, 0], s=1.0, k=rng.uniform(0.5, 6), axis=axis)
    return model


def tasks(folder: Path, models: list[Any], ending: str = "npz") -> list[Task]:
    found = []
    for number, model in enumerate(models):
        path = folder / f"p{number}.{ending}"
        model.write(path)
        out = folder / f"out{number}.{ending}"
        found.append(Task(path.name, str(path), "key", str(out)))
    return found


@pytest.mark.parametrize(
    ("text", "make", "ending", "options"),
    [
        (GRAPHS, graph, "npz", {}),
        (GRAPHS, graph, "json", {}),
        (GRAPHS, graph, "npz", {"max_iters": 2}),
        (GRAPHS, graph, "npz", {"passes": [], "damping": "nielsen", "strategy": "damped"}),
        (GRAPHS, graph, "npz", {"freeze": ["poses.th"]}),
        (BOWLS, bowl, "npz", {}),
    ],
)
def test_a_group_ends_as_each_alone(
    sent: Any, tmp_path: Path, text: str, make: Any, ending: str, options: dict[str, Any]
) -> None:
    kind = arael.loads(text, interpret=True)
    vouched = sent(kind)
    some = tasks(tmp_path, [make(kind, seed) for seed in range(8)], ending)
    settings = Settings(options=options)
    together = solve_group(vouched, some, settings, 1)
    found = [Path(task.result or "").read_bytes() for task in some]
    for row, task, content in zip(together, some, found, strict=True):
        (alone,) = solve_group(vouched, [task], settings, 1)
        assert (row.together, row.apart) == (8, "")
        assert (row.status, row.converged, row.iterations) == (
            alone.status, alone.converged, alone.iterations,
        )  # fmt: skip
        assert row.cost == pytest.approx(alone.cost, rel=1e-9, abs=1e-18)
        assert list(row.parameters) == list(alone.parameters)
        assert list(row.parameters.values()) == pytest.approx(
            list(alone.parameters.values()), abs=1e-7
        )
        assert list(row.sigmas) == list(alone.sigmas)
        assert list(row.sigmas.values()) == pytest.approx(list(alone.sigmas.values()), rel=1e-5)
        assert row.seconds.keys() == alone.seconds.keys()
        equal_data(kind, task, content, tmp_path / f"joined.{ending}")


def equal_data(kind: Any, task: Task, content: bytes, path: Path) -> None:
    """The file that a group wrote has the data of the one that a solve alone wrote."""
    from arael.io.npz_writer import arrays_of

    path.write_bytes(content)
    one, other = kind(), kind()
    one.read(path)
    other.read(task.result or "")
    left, right = dict(arrays_of(one._store)), dict(arrays_of(other._store))
    assert left.keys() == right.keys()
    for name, array in left.items():
        if array.dtype.kind == "f":
            np.testing.assert_allclose(array, right[name], atol=1e-7, err_msg=name)
        else:
            np.testing.assert_array_equal(array, right[name], err_msg=name)


def reasons(rows: list[Row]) -> set[str]:
    assert all(row.converged for row in rows), [row.message for row in rows]
    assert {row.together for row in rows} == {1}
    return {row.apart for row in rows}


def test_problems_with_parameters_in_the_root_are_solved_in_turn(sent: Any, tmp_path: Path) -> None:
    kind = arael.loads(SHARED, interpret=True)
    models = [kind(a=0, points=[{"x": 1, "y": k}]) for k in range(3)]
    rows = solve_group(sent(kind), tasks(tmp_path, models), Settings(), 1)
    assert reasons(rows) == {"the root has parameters"}
    assert [row.parameters["a"] for row in rows] == pytest.approx([0, 1, 2])


def test_only_problems_with_the_same_root_data_are_joined(sent: Any, tmp_path: Path) -> None:
    kind = arael.loads(BOWLS, interpret=True)
    models = [bowl(kind, seed) for seed in range(5)]
    for model, scale in zip(models, (1, 2, 1, 2, 3), strict=True):
        model.scale = scale
    rows = solve_group(sent(kind), tasks(tmp_path, models), Settings(), 1)
    assert [row.together for row in rows] == [2, 2, 2, 2, 1]
    assert rows[4].apart == "the data of its root differ from those of the others"


def test_flags_and_bounds_of_some_problems_are_kept(sent: Any, tmp_path: Path) -> None:
    kind = arael.loads(BOWLS, interpret=True)
    models = [bowl(kind, seed) for seed in range(4)]
    models[2].bowls[0].s.fixed = True
    rows = solve_group(sent(kind), tasks(tmp_path, models), Settings(), 1)
    assert [row.together for row in rows] == [4] * 4
    assert ["bowls[0].s" in row.sigmas for row in (rows[0], rows[2])] == [True, False]
    assert rows[2].parameters["bowls[0].s"] == 1.0
    models[1].bowls[0].s.high = 1.1
    rows = solve_group(sent(kind), tasks(tmp_path, models), Settings(), 1)
    assert {row.apart for row in rows} == {"only some have `bowls.s.high`"}
    assert rows[1].parameters["bowls[0].s"] <= 1.1


def test_a_problem_of_two_parts_is_solved_in_turn(sent: Any, tmp_path: Path) -> None:
    kind = arael.loads(BOWLS, interpret=True)
    models = [bowl(kind, seed) for seed in range(3)]
    models[1].bowls.append(q=[1, 0, 0, 0], s=1.0, k=3, axis=[0, 1, 0])
    rows = solve_group(sent(kind), tasks(tmp_path, models), Settings(), 1)
    assert reasons(rows) == {"not each is one connected problem"}


def test_what_cannot_be_read_leaves_the_others_joined(sent: Any, tmp_path: Path) -> None:
    kind = arael.loads(BOWLS, interpret=True)
    some = tasks(tmp_path, [bowl(kind, seed) for seed in range(4)])
    Path(some[2].data).write_bytes(b"damaged")
    rows = solve_group(sent(kind), some, Settings(), 1)
    assert [row.status for row in rows] == ["converged", "converged", "failed", "converged"]
    assert [row.together for row in rows] == [3, 3, 1, 3]
    assert "p2.npz" in rows[2].message


@pytest.mark.parametrize(
    ("text", "options", "why"),
    [
        (BOWLS.replace("f64", "f32"), {}, "it is in f32"),
        (BOWLS, {"solver": "schur"}, "solver='schur' is asked for"),
        (BOWLS, {"solver_options": {"ordering": "amd"}}, "options of the linear solver are given"),
        (
            "struct P { param x: real }\nroot R : f64 { ps: list of P\n"
            "constraint all { sum(p in ps) { p.x } - 1 } }",
            {},
            "constraint `all` belongs to the root",
        ),
        (
            "struct P { param x: real\nconstraint c { x - root.first.x - 1 } }\n"
            "root R : f64 { ps: list of P; first: ref P in root.ps }",
            {},
            "the root has refs",
        ),
        (
            "struct P { param x: real; k: real\nconstraint c { x - sum(o in root.ps) { o.k } } }\n"
            "root R : f64 { ps: list of P }",
            {},
            "constraint `c` reads all rows of a list of the root",
        ),
        (
            "struct P { param x: real\nconstraint low when x < 1 { x - 2 } }\n"
            "root R : f64 { ps: list of P }",
            {},
            "constraint `low` has a guard over parameters",
        ),
        (
            "struct K { key t; t: real; v: real }\n"
            "struct P { param x: real\nks: list of K\nconstraint c { self.ks.at(x, v) } }\n"
            "root R : f64 { ps: list of P }",
            {},
            "constraint `c` looks rows up",
        ),
    ],
)
def test_models_that_are_not_joined(text: str, options: dict[str, Any], why: str) -> None:
    kind = arael.loads(text, interpret=True)
    assert joined.why_not(kind.layout, options) == why
