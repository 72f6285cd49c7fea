"""Bounds of single rows and components, and components fixed by the data, set from Python."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Pose {
    param pos: vec3 = [0, 0, 0]
    param ea: euler = [0, 0, 0]
    param gain: real in 0 .. 5 = 1
    goal: vec3 = [1, 2, 3]
    constraint c { [pos - goal, ea - 0.1 * goal] }
    constraint d { gain - 9 }
}

root R {
    param k: real in 0 .. 10 = 1
    param q: quaternion = [1, 0, 0, 0]
    param v: vec<5> = [0, 0, 0, 0, 0]
    poses: list of Pose
    constraint e { k - 20 }
    constraint f { v - [1, 2, 3, 4, 5] }
    constraint g { rotation_vector(q) }
}
"""
KIND: Any = arael.loads(TEXT, interpret=True)


def model(rows: int = 2) -> Any:
    found = KIND()
    found.poses.extend(gain=[1.0] * rows)
    return found


def rounded(parameter: Any) -> Any:
    return np.round(np.asarray(parameter), 6).tolist()


# --- the solver --------------------------------------------------------------------------------


def test_bounds_replace_those_of_the_model() -> None:
    m = model()
    m.k.high = 15
    m.solve()
    assert rounded(m.k) == 15
    m.k.high = None
    m.solve()
    assert rounded(m.k) == 20
    del m.k.high
    assert m.k.high == 10 and m.k.low == 0
    m.k = 5
    m.solve()
    assert rounded(m.k) == 10


def test_parameters_without_bounds_in_the_model_take_them() -> None:
    m = model()
    m.v.high[4] = 4.5
    m.v.low = [1.5, None, None, None, -1]
    m.v.value[0] = 2
    m.poses[0].pos.z.high = 2
    m.poses.pos.x.low = [-1, 1.5]
    m.poses[1].pos.x = 2
    m.solve()
    assert rounded(m.v) == [1.5, 2, 3, 4, 4.5]
    assert rounded(m.poses.pos) == [[1, 2, 2], [1.5, 2, 3]]
    assert m.poses.pos.low.tolist() == [[-1, -np.inf, -np.inf], [1.5, -np.inf, -np.inf]]


def test_bounds_of_a_collection_are_columns() -> None:
    m = model(3)
    m.poses.gain.high[...] = [2, 3, np.inf]
    m.solve()
    assert rounded(m.poses.gain) == [2, 3, 9]
    m.poses.append()
    assert m.poses.gain.high.tolist() == [2, 3, np.inf, 5]  # of the model
    m.poses.pos.value[...] = 0
    m.poses.pos.high = [[2, 1, None]] * 4
    m.solve()
    assert rounded(m.poses.pos) == [[1, 1, 3]] * 4


def test_a_session_follows_bounds() -> None:
    m = model()
    m.solve()
    assert rounded(m.poses.gain) == [5, 5]
    m.poses[1].gain.high = 7
    m.solve()
    assert rounded(m.poses.gain) == [5, 7]
    m.poses.gain.high[0] = 6  # through the view
    m.solve()
    assert rounded(m.poses.gain) == [6, 7]
    assert m.session.counts.analyses == 1  # the linear solver stays


def test_bounds_in_kernels_and_single_precision() -> None:
    m = arael.loads("root R { param a: real; constraint c { a - 3 } }", precision="f32")()
    m.a = {"value": 0, "high": 0.1}
    m.solve()
    assert m.a.value == np.float32(0.1)


def test_reading_a_bound_changes_nothing() -> None:
    m = model()
    assert (m.k.low, m.k.high) == (0, 10)
    assert m.poses.gain.high.tolist() == [5, 5] and m.v.low.tolist() == [-np.inf] * 5
    m.solve()
    assert rounded(m.poses.gain) == [5, 5] and rounded(m.v) == [1, 2, 3, 4, 5]


def test_values_fixed_outside_their_bounds_stay() -> None:
    m = model()
    m.poses[0].pos = {"value": [7, 0, 0], "fixed": [True, False, False], "high": 2.5}
    m.poses[1].gain = {"value": 8, "fixed": True}
    m.solve()
    assert rounded(m.poses.pos) == [[7, 2, 2.5], [1, 2, 3]]
    assert rounded(m.poses.gain) == [5, 8]


def test_components_fixed_by_the_data() -> None:
    m = model()
    m.poses[0].pos.fixed = [True, False, True]
    m.poses[1].ea.z.fixed = True
    m.v.fixed = [True, False, False, False, True]
    assert m.poses.pos.fixed.tolist() == [[True, False, True], [False] * 3]
    assert m.poses[1].pos.fixed is False and m.poses[1].ea.z.fixed is True
    m.solve()
    assert rounded(m.poses.pos) == [[0, 2, 0], [1, 2, 3]]
    assert rounded(m.poses.ea) == [[0.1, 0.2, 0.3], [0.1, 0.2, 0]]
    assert rounded(m.v) == [0, 2, 3, 4, 0]
    m.v.fixed = [True] * 5
    assert m.v.fixed is True
    m.poses.pos.fixed = [[False, True, False]]
    assert m.poses.pos.fixed.tolist() == [[False, True, False]] * 2
    m.poses.pos.fixed = False
    m.v.fixed = False
    m.poses.ea.fixed = False
    m.solve()
    assert rounded(m.v) == [1, 2, 3, 4, 5] and rounded(m.poses.ea[1]) == [0.1, 0.2, 0.3]


def test_components_have_values_flags_and_bounds() -> None:
    m = model()
    m.poses.pos.y = [3, 4]
    m.poses[0].pos.x = 5
    assert m.poses.pos.value.tolist() == [[5, 3, 0], [0, 4, 0]]
    assert m.poses[0].pos.x + 1 == 6 and float(m.poses[1].pos.y) == 4
    assert f"{m.poses[0].pos.x:.1f}" == "5.0" and "poses[0].pos.x: 5" in repr(m.poses[0].pos.x)
    assert np.asarray(m.poses.pos.y).tolist() == [3, 4] and m.poses.pos.y[1] == 4
    m.poses[0].pos.z.optimize = False
    assert m.poses[0].pos.optimize.tolist() == [True, True, False]
    m.poses.pos.z.high = None
    assert m.poses[0].pos.z.high == np.inf


def test_covariance_and_report_name_bounds_of_rows() -> None:
    m = model()
    m.poses[0].pos.z.high = 2
    m.solve()
    found = m.covariance()
    assert found.on_bound["poses[0].pos.z"] == "its upper bound 2"
    assert "poses[0].pos.z = 2 (on its upper bound 2)" in " ".join(str(m.report()).split())


def test_problem_has_bounds_of_rows() -> None:
    m = model()
    m.poses[0].pos.z.high = 2
    m.poses[0].pos.z.low = -1
    m.poses[0].pos.z = 1
    problem = m.problem()
    k = problem.names.index("poses[0].pos.z")
    assert (problem.low[k], problem.high[k]) == (-2, 1)


def test_profiles_end_at_bounds_of_rows() -> None:
    m = model(1)
    m.poses[0].pos.z.high = 3.5
    m.solve()
    found = m.profile("poses[0].pos.z")
    assert found.high == pytest.approx(3.5) and found.low == pytest.approx(3 - 1.96, abs=1e-2)


# --- copies -----------------------------------------------------------------------------------


@pytest.mark.parametrize("copy", [lambda m: m.copy(), lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_have_bounds_and_components(copy: Any) -> None:
    m = model()
    m.poses[0].gain.high = 2
    m.poses[1].pos.fixed = [True, False, False]
    m.poses.ea.optimize = [[False, True, True]]
    other = copy(m)
    m.poses.gain.high = 3
    other.poses.append()
    assert other.poses.gain.high.tolist() == [2, 5, 5]
    assert other.poses.pos.fixed.tolist() == [[False] * 3, [True, False, False], [False] * 3]
    assert other.poses.ea.optimize.tolist() == [[False, True, True]] * 3
    other.solve()
    assert rounded(other.poses.gain) == [2, 5, 5] and rounded(other.poses.pos)[1] == [0, 2, 3]


def test_rows_added_as_dicts_and_columns() -> None:
    m = model(0)
    m.poses.append(pos={"value": [0, 0, 0], "low": [-1, None, 0], "fixed": [False, True, False]})
    m.poses.extend(
        gain=[1, 2],
        **{"gain.low": [0.5, None], "gain.high": 4, "pos.fixed": [[True, False, False]] * 2},
    )
    assert m.poses.pos.low.tolist()[0] == [-1, -np.inf, 0]
    assert m.poses.gain.low.tolist() == [0, 0.5, -np.inf]
    assert m.poses.gain.high.tolist() == [5, 4, 4]
    assert m.poses.pos.fixed.tolist() == [[False, True, False], *[[True, False, False]] * 2]


def test_bounds_leave_with_their_rows() -> None:
    m = model(3)
    m.poses.gain.high = [1, 2, 3]
    m.poses.pop()
    assert m.poses.gain.high.tolist() == [1, 2]
    m.poses.clear()
    m.poses.append()
    assert m.poses.gain.high.tolist() == [5]


def test_structs_assigned_as_a_whole_keep_bounds() -> None:
    text = """
    struct Inner { param a: vec2 = [0, 0]; b: real = 1 }
    root R { i: Inner; o: Inner?; constraint c { i.a } }
    """
    m = arael.loads(text, interpret=True)()
    m.i.a.high = [1, 2]
    m.i.a.fixed = [True, False]
    m.i = {"b": 2}
    assert m.i.a.high.tolist() == [1, 2] and m.i.a.fixed.tolist() == [True, False]
    m.i = {"a": {"value": [0, 0], "high": 3}}
    assert m.i.a.high.tolist() == [3, 3] and m.i.a.fixed is False
    m.o = {"a": {"value": [0, 0], "low": -3}}
    m.o = None
    m.o = {"b": 1}
    assert m.o.a.low.tolist() == [-np.inf] * 2


# --- messages -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "change", "words"),
    [
        ("E0705", lambda m: setattr(m.k, "low", float("nan")), "k.low: error"),
        ("E0703", lambda m: setattr(m.k, "low", "a"), 'found the string "a"'),
        ("E0703", lambda m: setattr(m.k, "low", [1, [2, 3]]), "expected numbers"),
        ("E0703", lambda m: setattr(m.k, "low", 10**400), "expected numbers"),
        ("E0703", lambda m: setattr(m.k, "low", True), "expected numbers"),
        ("E0704", lambda m: setattr(m.k, "low", [1, 2]), "expected a number, found shape (2,)"),
        ("E0704", lambda m: setattr(m.poses.pos, "high", [[1, 2]]), "or shape (3,) or (2, 3)"),
        ("E0703", lambda m: setattr(m.q, "low", 0), "only plain parameters have bounds"),
        ("E0703", lambda m: m.q.low, "only plain parameters have bounds"),
        ("E0703", lambda m: setattr(m.poses[0].ea.x, "low", 0), "only plain parameters"),
        ("E0703", lambda m: m.v.x, "index the array: `v.low[4] = 0`"),
        ("E0704", lambda m: setattr(m.poses.pos.x, "low", [1, 2, 3]), "poses.pos.x.low"),
        ("E0703", lambda m: setattr(m.poses[0].pos.x, "fixed", 1), "expected true or false"),
        ("E0703", lambda m: setattr(m.poses[0].pos.x, "value", "a"), "poses[0].pos.x: error"),
        ("E0703", lambda m: setattr(m.v, "fixed", [True]), "for each of 5 components"),
        ("E0703", lambda m: setattr(m, "k", {"value": 1, "max": 2}), '"low": ..., "high"'),
        ("E0705", lambda m: setattr(m, "k", {"value": 7, "low": float("nan")}), "k.low"),
        ("E0705", lambda m: m.poses.append(gain={"value": 1, "low": float("nan")}), "gain.low"),
        ("E0704", lambda m: m.poses.extend(gain=[1, 2], **{"gain.low": [1, 2, 3]}), "(3,)"),
        ("E0701", lambda m: m.poses.append(**{"goal.low": 1}), "has no field `goal.low`"),
    ],
)
def test_messages(code: str, change: Any, words: str) -> None:
    m = model()
    with pytest.raises(AraelError) as caught:
        change(m)
    assert caught.value.diagnostics[0].code == code
    assert words in str(caught.value)
    assert m.k.value == 1 and len(m.poses) == 2 and m.k.low == 0


def test_values_outside_and_bounds_without_value_end_a_solve() -> None:
    m = model()
    m.poses[1].pos.z.low = 1
    with pytest.raises(AraelError) as caught:
        m.solve()
    assert caught.value.diagnostics[0].code == "E1007"
    assert "`poses[1].pos.z` starts at 0, outside its bounds 1 .. inf" in str(caught.value)
    m.poses[1].pos.z.high = 0
    with pytest.raises(AraelError) as caught:
        m.solve()
    assert caught.value.diagnostics[0].code == "E0730"
    assert "the bounds 1 .. 0 of `poses[1].pos.z` leave no value" in str(caught.value)
    m.poses[1].pos.z.fixed = True  # then they do not matter
    m.solve()
    m.poses[1].pos.z.fixed = False
    m.poses.pos.low[1, 2] = np.nan
    with pytest.raises(AraelError, match="are not numbers"):
        m.solve()


def test_what_an_update_sets_has_the_bounds_of_the_model() -> None:
    text = """
    component Count { param x: real = 0; param n: real = 0; update { n = n + 1 } }
    root R { param c: Count; constraint near { c.x - 1 } }
    """
    m = arael.loads(text, interpret=True)()
    with pytest.raises(AraelError, match="an update sets this parameter"):
        m.c.n.low = 0


def test_a_system_without_bounds_is_known_as_such_until_a_row_has_some() -> None:
    free = arael.loads("root R {\n    param k: real = 1\n    constraint c { k - 20 }\n}")()
    assert free.solve().converged
    assert free.session.earlier.structure.system.__dict__["bounded"] == ()
    free.k.high = 3.0
    assert free.k.value > 3
    free.k.value = 1.0
    free.solve()
    assert free.k.value == 3.0
