"""Notes on results that converged and mean less than they seem."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import arael
from tests.analysis.maps import planar
from tests.interpreted import Load, loader

SIGHT = """
struct Mark { param pos: vec3 }
struct Sight {
    mark: ref Mark in root.marks
    from: vec3
    d: real
    constraint range loss geman_mcclure(1) { (norm(mark.pos - from) - d) * 20 }
}
root Map { marks: list of Mark; sights: list of Sight }
"""
STAGES = """
struct P { param x: real
    param y: real
    constraint c { [x + y - 1, x - 1, y - 2] } }
root R { ps: list of P
    solve {
        pass one { freeze ps.x }
        pass two { freeze ps.y }
        pass all { }
    }
}
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("notes"))


def topics(result) -> list[str]:
    return [note.topic for note in result.notes]


def test_a_determined_problem_has_none(tmp_path: Path) -> None:
    result = planar(tmp_path).solve()
    assert result.notes == ()
    assert "note" not in str(result)
    assert "notes" not in result.to_dict()


def test_fewer_residuals_than_unknowns(load: Load) -> None:
    model = load("root R { param a: real = 1; param b: real = 2; constraint c { a + b - 1 } }")()
    result = model.solve()
    assert result.status == "converged"
    assert topics(result) == ["underdetermined", "free"]
    assert result.notes[0].message.startswith("2 unknowns have only 1 residual:")
    assert "+1 a -1 b" in result.notes[1].message


@pytest.mark.parametrize("count", [8, 150])  # dense eigenvectors, and symmetries beyond
def test_a_map_that_nothing_holds(tmp_path: Path, count: int) -> None:
    model = planar(tmp_path, count=count, fixes=0)
    result = model.solve()
    assert topics(result) == ["free"]
    assert "3 free directions: `poses.t` move together along x" in result.notes[0].message
    assert "free_directions()" in str(result)
    # A solve again says it again; one of a map that is held does not.
    assert model.solve().notes == result.notes
    model.poses[0].t.fixed = model.poses[0].th.fixed = True
    assert model.solve().notes == ()
    model.poses[0].th.fixed = False
    assert "`poses.t` turn together" in model.solve().notes[0].message


def test_a_damped_solve_is_checked_by_a_factor_of_its_own(tmp_path: Path) -> None:
    model = planar(tmp_path, fixes=0)
    assert topics(model.solve(strategy="damped")) == ["free"]
    model = planar(tmp_path)
    assert topics(model.solve(strategy="damped", max_iters=1)) == []


def test_single_precision(tmp_path: Path) -> None:
    assert topics(planar(tmp_path, precision="f32").solve()) == []
    assert topics(planar(tmp_path, fixes=0, precision="f32").solve()) == ["free"]


def seen(load: Load, start: list[float]):
    rng = np.random.default_rng(0)
    marks, places = rng.uniform(-5, 5, (12, 3)), rng.uniform(-9, 9, (6, 3))
    model = load(SIGHT)()
    begin = marks + 0.01 * rng.normal(size=marks.shape)
    begin[3] = start
    model.marks.extend(pos=begin)
    for i, mark in enumerate(marks):
        for place in places:
            d = float(np.linalg.norm(mark - place))
            model.sights.append(**{"mark": model.marks[i], "from": place, "d": d})
    return model


def test_a_point_that_ran_off_under_a_loss(load: Load) -> None:
    result = seen(load, [1e9, 0, 0]).solve()
    # Seen from so far, all ranges are along one line.
    assert topics(result) == ["free", "weightless", "far"]
    assert "2 free directions" in result.notes[0].message
    assert "marks[3].pos.z" in result.notes[0].message
    assert "`marks[3]` a weight below 1e-3" in result.notes[1].message
    assert result.notes[2].message.startswith("`marks[3].pos` lies")
    near = seen(load, [0, 0, 0])
    near.marks[3].pos.value = near.marks[2].pos.value
    near.marks[3].pos.fixed = True
    assert near.solve().notes == ()


def test_notes_are_sent_with_the_result(tmp_path: Path) -> None:
    result = planar(tmp_path, fixes=0).solve()
    sent = pickle.loads(pickle.dumps(result))
    assert sent.notes == result.notes
    assert len(sent.notes) == 1


def test_notes_belong_to_the_result(load: Load) -> None:
    """They do not follow the model."""
    model = seen(load, [1e9, 0, 0])
    result = model.solve()
    model.marks.pos.value = np.zeros((12, 3))
    assert topics(result) == ["free", "weightless", "far"]
    assert result.to_dict()["notes"][2]["topic"] == "far"


def test_a_freeze_ends_with_its_pass(load: Load) -> None:
    model = load(STAGES)(ps=[{"x": 0.0, "y": 0.0}])
    result = model.solve()
    assert [one.frozen for one in result.passes] == [("ps.x",), ("ps.y",), ()]
    assert [float(model.ps[0].x), float(model.ps[0].y)] == pytest.approx([1 / 3, 4 / 3])
    assert result.notes == ()
    assert "; frozen: ps.x" in str(result)


def test_what_the_last_pass_froze(load: Load) -> None:
    model = load(STAGES)(ps=[{"x": 0.0, "y": 0.0}])
    result = model.solve(passes=["all", "one"])
    assert topics(result) == ["frozen"]
    assert result.notes[0].message == "the last pass, `one`, did not solve for `ps.x`"
    # Frozen for the whole solve, and freed by a pass.
    free = arael.Pass("free", free="ps.x")
    result = model.solve(passes=["all", free, "all"], freeze="ps.x")
    assert [one.frozen for one in result.passes] == [("ps.x",), (), ("ps.x",)]
    # One pass of one's own freezing needs no note.
    assert model.solve(passes=[], freeze="ps.x").notes == ()


def test_residuals_that_are_added_after_a_solve(load: Load) -> None:
    model = load("root R { param a: real = 1; param b: real = 2; constraint c { a + b - 1 } }")()
    assert topics(model.solve()) == ["underdetermined", "free"]
    model.residuals.add("a - b", label="hold")
    assert model.solve().notes == ()
    model.residuals.remove("hold")
    assert topics(model.solve()) == ["underdetermined", "free"]


def test_a_bounded_cost_of_checks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rank of a structure is decided once."""
    asked = []
    from arael import solving

    decide = solving.structural_notes
    monkeypatch.setattr(solving, "structural_notes", lambda *a: asked.append(1) or decide(*a))
    model = planar(tmp_path)
    for k in range(4):
        model.poses[0].t.value = [3.0 + k, 0.1]
        model.solve()
    assert len(asked) == 1
    model.fixes.append(pose=model.poses[1], t=[0.0, 0.0])
    model.solve()
    assert len(asked) == 2
