"""Freedoms of the cost that J'J does not show, and covariances in a free gauge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from arael.analysis import freedom
from arael.diagnostics.records import AraelError
from arael.runtime.failures import SolveError
from tests.analysis.maps import planar

RANGES = """
struct Anchor { param pos: vec3 [m] }
struct State {
    param pos: vec3 [m]
    param vel: vec3 [m/s]
}
struct Range {
    a: ref Anchor in root.anchors
    s: ref State in root.states
    d: real [m]
    isigma: real [1/m] = 20
    constraint range { (norm(a.pos - s.pos) - d) * isigma }
}
struct Step {
    a: ref State in root.states
    b: ref State in root.states
    p_isigma: real [1/m] = 2
    v_isigma: real [s/m] = 1
    constraint constant_velocity {
        [(b.pos - a.pos - a.vel * root.dt) * p_isigma, (b.vel - a.vel) * v_isigma]
    }
}
root Ranging {
    dt: real [s] = 1
    anchors: list of Anchor
    states: list of State
    ranges: list of Range
    steps: list of Step
}
"""
DATUM = ["anchors[0].pos", "anchors[1].pos.y", "anchors[1].pos.z", "anchors[2].pos.z"]


@pytest.fixture(scope="module")
def ranging(tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.mktemp("ranging") / "ranging.arael"
    path.write_text(RANGES, encoding="utf-8")
    return arael.load(path, interpret=True)


def measured(ranging, count: int = 16, anchors: int = 6):
    """Ranges from a loop to anchors whose places are not known, solved."""
    rng = np.random.default_rng(3)
    a = rng.uniform(-10, 10, (anchors, 3))
    t = np.linspace(0, 2 * np.pi, count)
    p = np.column_stack([6 * np.cos(t), 6 * np.sin(t), 3 * np.sin(2 * t)])
    model = ranging()
    model.anchors.extend(pos=a)
    model.states.extend(pos=p, vel=np.gradient(p, axis=0))
    for i in range(count):
        for j in range(anchors):
            d = float(np.linalg.norm(a[j] - p[i]) + 0.05 * rng.normal())
            model.ranges.append(a=model.anchors[j], s=model.states[i], d=d)
    for i in range(count - 1):
        model.steps.append(a=model.states[i], b=model.states[i + 1])
    model.solve(rel_precision=1e-13)
    return model


@pytest.fixture
def solved(ranging):
    return measured(ranging)


def test_the_cost_is_free_to_turn_where_residuals_are_not(solved) -> None:
    found = solved.free_directions()
    assert [one.gauge for one in found] == ["translation"] * 3 + ["rotation"] * 3
    assert [one.residuals_change for one in found] == [False] * 3 + [True] * 3
    assert str(found[5]) == (
        "`anchors.pos`, `states.pos` turn together about z, `states.vel` with them"
    )
    # J'J sees three of them.
    assert found.parameters - found.rank == 6
    assert solved.jacobian().rank() == found.parameters - 3
    # By 1 rad about z: velocities by w x v, positions by w x p and a shift.
    turned = found[5].vector.reshape(-1, 3)
    v = solved.states.vel.value
    assert turned[7::2] == pytest.approx(np.cross([0, 0, 1.0], v), abs=1e-9)


def test_the_cost_itself_is_the_oracle(solved) -> None:
    before, gauge = solved.cost(), solved.free_directions()[3:]
    turn = arael.geometry.rotation_matrix(np.array([0.3, -0.5, 1.0]))
    for table, name in ((solved.anchors, "pos"), (solved.states, "pos"), (solved.states, "vel")):
        field = getattr(table, name)
        field.value = field.value @ turn.T
    assert before > 1
    assert solved.cost() == pytest.approx(before, rel=1e-12)
    assert len(gauge) == 3


def test_diagnose_and_covariance_report_them(solved) -> None:
    found = solved.diagnose()
    assert [one.topic for one in found.findings] == ["free"]
    assert found.to_dict()["rank"] == found.parameters - 6
    solved.anchors[0].pos.fixed = True
    with pytest.raises(SolveError, match=r"3 of \d+ directions are free") as error:
        solved.covariance()
    advice = error.value.diagnostics[0].help[0]
    assert "a point, two coordinates of another and one of a third" in advice


@pytest.mark.parametrize("held", [1, 2])
def test_fixed_coordinates_take_turns_away(solved, held: int) -> None:
    """A point leaves three turns, one coordinate more two, two more one, three none."""
    solved.anchors[0].pos.fixed = True
    solved.anchors[1].pos.fixed = [False, held > 1, True]
    left = solved.free_directions()
    assert [one.gauge for one in left] == ["rotation"] * (3 - held)
    # The fixed coordinates do not move.
    for one in left:
        place = dict(zip(solved.parameter_names(), one.vector, strict=True))
        assert "anchors[0].pos.x" not in place
        assert abs(one.vector).max() > 1


def test_sigmas_in_a_datum_of_coordinates(solved) -> None:
    """Of the system without the six coordinates, by NumPy."""
    j, names = solved.jacobian().dense(), solved.parameter_names()
    held = [n for n in names if any(n == d or n.startswith(f"{d}.") for d in DATUM)]
    assert len(held) == 6
    rest = [i for i, n in enumerate(names) if n not in held]
    expected = np.sqrt(np.diag(np.linalg.inv(j[:, rest].T @ j[:, rest])))
    transformed = solved.covariance(gauge="free").in_datum(DATUM)
    solved.anchors[0].pos.fixed = True
    solved.anchors[1].pos.fixed = [False, True, True]
    solved.anchors[2].pos.fixed = [False, False, True]
    assert list(solved.free_directions()) == []
    assert solved.covariance().sigma() == pytest.approx(expected, rel=1e-8)
    # The same network in the same datum; J'J is not quite that of a free network at r != 0.
    ratio = transformed.sigma()[rest] / expected
    assert np.median(ratio) == pytest.approx(1, abs=0.25)
    assert ratio == pytest.approx(np.ones(len(ratio)), abs=0.4)
    assert transformed.marginal("anchors[0]") == pytest.approx(np.zeros((3, 3)), abs=1e-9)


def test_solves_of_a_session_follow_what_is_fixed(solved) -> None:
    assert [one.topic for one in solved.solve().notes] == ["free"]
    solved.anchors[0].pos.fixed = True
    solved.anchors[1].pos.fixed = [False, True, True]
    solved.anchors[2].pos.fixed = [False, False, True]
    assert solved.solve().notes == ()
    assert solved.covariance().marginal(solved.anchors[4]).shape == (3, 3)
    solved.anchors[2].pos.fixed = False
    assert [one.topic for one in solved.solve().notes] == ["free"]
    with pytest.raises(SolveError, match=r"1 of \d+ directions are free"):
        solved.covariance()


def test_inner_constraints_are_the_least_trace(solved) -> None:
    j = solved.jacobian().dense()
    g = np.column_stack([one.vector for one in solved.free_directions()])
    z = np.linalg.qr(g, mode="complete")[0][:, 6:]
    expected = z @ np.linalg.inv(z.T @ j.T @ j @ z) @ z.T
    found = solved.covariance(gauge="free")
    assert len(found.free_directions) == 6
    assert found.matrix == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert found.sigma() == pytest.approx(np.sqrt(np.diag(expected)), rel=1e-7)
    for row in (0, 7):
        block = found.marginals("states.pos")[row]
        assert block == pytest.approx(found.marginal(f"states[{row}].pos"), rel=1e-7)
    # To another datum by S = I - G (E'G)^-1 E', here of some control points.
    names = solved.parameter_names()
    e = np.array([[n.startswith(("anchors[0]", "anchors[3]", "states[2].pos"))] for n in names]) * g
    s = np.eye(len(names)) - g @ np.linalg.solve(e.T @ g, e.T)
    other = found.in_datum(["anchors[0]", "anchors[3]", "states[2].pos"])
    assert other.matrix == pytest.approx(s @ expected @ s.T, abs=1e-8 * np.abs(expected).max())
    assert np.trace(other.matrix) > np.trace(expected)


def test_a_free_map_has_the_pseudo_inverse(tmp_path: Path) -> None:
    model = planar(tmp_path, fixes=0)
    model.solve()
    j = model.jacobian().dense()
    found = model.covariance(gauge="free", scale="residual")
    expected = np.linalg.pinv(j.T @ j, rcond=1e-10)
    factor = model.cost() / (j.shape[0] - (j.shape[1] - 3))
    assert found.factor == pytest.approx(factor)
    assert found.matrix == pytest.approx(expected * factor, rel=1e-6, abs=1e-8)
    # In the datum of a pose, it is the covariance with that pose fixed.
    fixed = found.in_datum("poses[0]")
    model.poses[0].t.fixed = model.poses[0].th.fixed = True
    held = model.covariance()
    assert fixed.marginal("poses[4]") == pytest.approx(held.marginal("poses[4]") * factor, rel=1e-5)


def test_without_free_directions_the_gauge_does_not_matter(tmp_path: Path) -> None:
    model = planar(tmp_path)
    found = model.covariance(gauge="free")
    assert found.free_directions == []
    assert found.matrix == pytest.approx(model.covariance().matrix)
    with pytest.raises(AraelError, match="no free directions"):
        found.in_datum("poses[0]")


def test_a_datum_that_leaves_something_free(solved) -> None:
    found = solved.covariance(gauge="free")
    with pytest.raises(AraelError, match="not all of the 6 free directions"):
        found.in_datum(["anchors[0].pos", "anchors[1].pos"])
    with pytest.raises(AraelError, match='"fixed" or "free"'):
        solved.covariance(gauge="inner")


def test_a_turn_about_the_minimum_is_no_freedom(tmp_path: Path) -> None:
    """|p - c|^2 does not change when p turns about c, yet p is determined."""
    path = tmp_path / "one.arael"
    path.write_text(
        "struct P { param pos: vec2 = [3, 1]; constraint c { pos - [1, 2] } }\n"
        "root R { param v: vec3 = [0, 0, 0]; ps: list of P\n"
        "constraint d { v - [1, 2, 3] }\nconstraint e { v - [1, 2.5, 3] } }\n",
        encoding="utf-8",
    )
    model = arael.load(path, interpret=True)(ps=[{}, {"pos": [1, 5]}])
    for _ in range(2):  # at the start, and at the minimum
        assert list(model.free_directions()) == []
        model.solve()
    model.ps.pos.value = np.zeros((2, 2))
    assert list(model.free_directions()) == []


def test_second_derivatives_settle_what_no_candidate_has(tmp_path: Path, monkeypatch) -> None:
    """Every point of the circle is a minimum of cost 4, where the residual turns with the point."""
    path = tmp_path / "circle.arael"
    path.write_text(
        "root R { param x: real = 1.2; param y: real = 0.5\n"
        "constraint c { let s = x * x + y * y\n let f = 1 + 1 / s\n"
        "[x * f, y * f, 5 * (s - 1)] } }\n",
        encoding="utf-8",
    )
    model = arael.load(path, interpret=True)()
    model.solve(rel_precision=1e-14)
    assert model.cost() == pytest.approx(4)
    x, y = float(model.x.value), float(model.y.value)
    found = model.free_directions()
    assert len(found) == 1
    assert found[0].residuals_change
    assert found[0].words.endswith("(to second order)")
    assert found[0].vector @ [x, y] == pytest.approx(0, abs=1e-4)
    assert model.jacobian().rank() == 2
    # Of the larger problem of ranges they agree with the symmetries.
    monkeypatch.setattr(freedom, "symmetries", lambda *_: [])
    assert len(model.free_directions()) == 1


def test_both_tests_agree(ranging, monkeypatch) -> None:
    model = measured(ranging, count=8)
    named = model.free_directions()
    monkeypatch.setattr(freedom, "symmetries", lambda *_: [])
    found = model.free_directions()
    assert len(found) == len(named) == 6
    every = np.linalg.qr(np.column_stack([one.vector for one in named]))[0]
    for one in found:
        off = one.vector - every @ (every.T @ one.vector)
        assert np.linalg.norm(off) < 1e-2 * np.linalg.norm(one.vector)
