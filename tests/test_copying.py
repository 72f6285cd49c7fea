"""Copies of models: independent, complete, and through pickle."""

from __future__ import annotations

import copy
import math
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Pose {
    param pos: vec2
    prev: ref Pose in root.poses?
    name: string = "p"
    marks: list of Mark
    constraint near { pos - [1, 2] }
    constraint step when prev { pos - prev.pos - [1, 0] }
}
struct Mark { at: real }
root Path {
    param scale: real = 2
    poses: deque of Pose
    constraint one { scale * scale - 3 }
}
"""


def path_model() -> arael.Model:
    path = arael.loads(TEXT, interpret=True)()
    a = path.poses.append(pos=[0, 0])
    b = path.poses.append(pos=[1, 0], prev=a)
    path.poses.append(pos=[5, 1], prev=b, marks=[{"at": 1.0}, {"at": 2.0}])
    path.poses.popleft()
    path.poses[0].pos.fixed = True
    return path


def test_loads_takes_a_model_from_its_text() -> None:
    path = path_model()
    assert path.solve().converged
    assert path.scale.value == pytest.approx(math.sqrt(3))


@pytest.mark.parametrize("text", [b"root R { }", 3, None])
def test_what_is_no_text_is_reported(text: object) -> None:
    with pytest.raises(AraelError, match="E0103"):
        arael.loads(text)  # type: ignore[arg-type]


def test_errors_in_a_text_name_it() -> None:
    with pytest.raises(AraelError, match=r"mine\.arael:1:1"):
        arael.loads("roof R { }", name="mine.arael")


def test_a_text_has_a_size_limit() -> None:
    with pytest.raises(AraelError, match="E0104"):
        arael.loads("# " + "x" * 2_000_000 + "\nroot R { }")


@pytest.mark.parametrize(
    "way",
    [
        lambda m: m.copy(),
        copy.copy,
        copy.deepcopy,
        lambda m: pickle.loads(pickle.dumps(m)),
    ],
    ids=["copy", "copy.copy", "deepcopy", "pickle"],
)
def test_a_copy_is_equal_and_independent(way: object) -> None:
    path = path_model()
    path.poses.pos.optimize = True
    other = way(path)  # type: ignore[operator]
    assert other.cost() == path.cost()
    assert other.poses.name.tolist() == ["p", "p"]
    assert other.poses[1].marks.at.tolist() == [1.0, 2.0]
    assert other.poses[0].pos.fixed and not other.poses[1].pos.fixed
    assert other.poses[1].prev == other.poses[0]
    assert other.poses[0].prev is None
    before = path.cost()
    assert other.solve().converged
    other.poses.append(pos=[7, 7], prev=other.poses[1])
    assert path.cost() == before and len(path.poses) == 2
    assert path.solve().converged
    with pytest.raises(AraelError, match="E0710"):
        path.poses[0].prev = other.poses[1]


def test_data_that_is_missing_is_missing_in_the_copy() -> None:
    model = arael.loads("root R { param a: real; x: real; constraint c { a - x } }")()
    model.a = 1.0
    other = model.copy()
    with pytest.raises(AraelError, match="`x` is not set"):
        other.cost()
    other.x = 2.0
    assert other.solve().converged and other.a.value == pytest.approx(2.0)


def test_flags_of_later_rows_are_copied() -> None:
    path = path_model()
    path.poses.pos.optimize = False
    other = path.copy()
    other.poses.append(pos=[0, 0])
    assert not other.poses[2].pos.optimize


@pytest.mark.parametrize("through_pickle", [False, True])
def test_runtime_residuals_are_copied(through_pickle: bool) -> None:
    path = path_model()
    path.residuals.functions("fn twice(x) = 2 * x")
    fit = arael.runtime_residual(
        "twice(a) * x - y + b[0] + tail",
        label="fit",
        parameters={"a": {"value": 1, "low": 0, "high": 5}, "b": {"value": [0, 1], "fixed": True}},
        data={"x": [0, 1, 2], "y": [1, 3, 5]},
        loss="huber(2)",
    )
    path.residuals.define("tail", "scale * 0.5")
    path.residuals.add(fit)
    path.residuals.add("norm(p.pos) - 2", entities={"p": path.poses[1]}, when="1 > 0")
    other = pickle.loads(pickle.dumps(path)) if through_pickle else path.copy()
    assert other.cost() == path.cost()
    ours, theirs = path.solve(), other.solve()
    assert theirs.end_cost == ours.end_cost and theirs.iterations == ours.iterations
    assert other.residuals["fit"].parameters["a"] == fit.parameters["a"]
    fit.parameters["a"] = 4.0
    assert other.residuals["fit"].parameters["a"] != 4.0


def test_a_model_of_runtime_residuals_only_is_copied() -> None:
    fit = arael.runtime_residual("a * x - y", parameters={"a": 1}, data={"x": [1, 2], "y": [2, 4]})
    model = arael.runtime_model(fit)
    for other in (model.copy(), pickle.loads(pickle.dumps(model))):
        assert other.solve().converged
        assert other.residuals.parameters["a"] == pytest.approx(2.0)
    assert fit.parameters["a"] == 1.0


def test_bound_functions_come_along() -> None:
    text = (
        "extern fn f(x) derivs [cos(x)]\nroot R { param a: real = 1; constraint c { f(a) - 0.5 } }"
    )
    model = arael.loads(text, functions={"f": math.sin}, interpret=True)()
    other = pickle.loads(pickle.dumps(model))
    assert other.solve().converged
    assert math.sin(other.a.value) == pytest.approx(0.5)


def test_another_process_opens_a_pickle(tmp_path: Path) -> None:
    path = path_model()
    (tmp_path / "model.pickle").write_bytes(pickle.dumps(path))
    code = "import pickle; m = pickle.load(open('model.pickle', 'rb')); print(m.solve().end_cost)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert float(done.stdout) == path.solve().end_cost


def test_a_copy_during_a_solve_is_of_the_values_before() -> None:
    path = path_model()
    start = np.array(path.poses.pos.value)
    copies: list[arael.Model] = []
    path.solve(observer=lambda record: copies.append(path.copy()) or True)
    assert copies
    np.testing.assert_array_equal(copies[0].poses.pos.value, start)
