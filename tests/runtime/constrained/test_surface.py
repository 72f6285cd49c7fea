"""Covariance, free directions and diagnosis where rows hold exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.distributed.parts.solve import check_splittable
from arael.runtime.assembly.positions import dense_matrix
from arael.runtime.constrained.rows import Rows

SPHERE = """
root R {
    param x: vec3
    param z: real in 0 ..
    data: vec3
    constraint near { (x - data) * 100 }
    constraint down { z + 1 }
    require sphere { norm2(x) == 4 }
    require again { norm(x) == 2 }
    require high { x.z >= 1 }
}
"""


def sphere(data: np.ndarray) -> arael.Model:
    return arael.loads(SPHERE, name="sphere", interpret=True)(x=[1, 1, 1], z=1, data=data)


def test_the_covariance_is_that_of_many_solves() -> None:
    truth = np.array([np.sqrt(2), np.sqrt(2) / 2, 1.2])
    truth *= 2 / np.linalg.norm(truth)
    model = sphere(truth)
    model.solve()
    covariance = model.covariance()
    rng = np.random.default_rng(0)
    found = []
    for _ in range(300):
        model.data = truth + 0.01 * rng.standard_normal(3)
        assert model.solve().converged
        found.append(model.x.value.copy())
    sampled = np.cov(np.array(found).T)
    exact = covariance.marginal("x")
    assert np.allclose(sampled, exact, rtol=0, atol=0.2 * exact.max())
    normal = truth / 2
    assert normal @ exact @ normal == pytest.approx(0, abs=1e-12)
    tangent = np.cross(normal, [0, 0, 1])
    assert tangent @ exact @ tangent == pytest.approx(1e-4 * (tangent @ tangent), rel=1e-8)
    assert covariance.on_bound == {"z": "its lower bound 0"}


def test_a_strongly_active_inequality_takes_a_direction_too() -> None:
    model = sphere(np.array([1.6, 1.2, 0.1]))
    result = model.solve()
    assert result.required["R.high"].active.all()
    exact = model.covariance().marginal("x")
    assert exact[2, 2] == pytest.approx(0, abs=1e-12)
    assert np.linalg.matrix_rank(exact, tol=1e-10) == 1
    assert model.covariance().sigma()[2] == pytest.approx(0, abs=1e-6)


def test_what_rows_determine_is_no_parameter_of_the_fit() -> None:
    text = """
root R {
    param a: real
    param b: real
    data: vec3
    constraint near { [a, b, a + b] - data }
    require sum { a + b == 3 }
}
"""
    model = arael.loads(text, interpret=True)(a=0, b=0, data=[1, 2.4, 2.9])
    model.solve()
    report = model.report(scale="residual")
    assert report.statistics.freedom == 2
    # a = b shifted: one unknown, seen twice
    assert model.covariance("residual").sigma()[0] == pytest.approx(
        np.sqrt(0.5 * model.cost() / 2), rel=1e-7
    )


def test_what_rows_determine_is_not_free() -> None:
    text = """
root R {
    param x: vec2
    constraint near { x.x - 1 }
    require line { x.x + x.y == 3 }
}
"""
    model = arael.loads(text, interpret=True)(x=[0, 0])
    assert model.solve().notes == ()
    assert model.x.value == pytest.approx([1, 2])
    assert len(model.free_directions()) == 0
    assert model.covariance().matrix == pytest.approx(np.array([[1, -1], [-1, 1]]), abs=1e-9)
    loose = arael.loads(text.replace("x.x + x.y == 3", "x.x >= -5"), interpret=True)(x=[0, 0])
    loose.solve(min_diagonal=1e-9)
    assert len(loose.free_directions()) == 1


def test_diagnosis_and_cost_table_know_the_rows() -> None:
    model = sphere(np.array([1.6, 1.2, 0.1]))
    before = model.diagnose()
    assert any(one.topic == "violated" and "R.sphere" in one.message for one in before.findings)
    model.solve()
    after = model.diagnose()
    assert {one.topic for one in after.findings} <= {"dominant"}  # the data is off the sphere
    table = model.cost_table()
    assert set(table) == {"R.near", "R.down"}
    assert table.total == pytest.approx(model.cost())
    assert set(table.violations) == {"R.sphere", "R.again", "R.high"}
    assert "R.sphere" in str(table)
    assert "holds" in str(table)
    assert set(model.jacobian().labels) == {"R.near", "R.down"}
    assert all(check.agrees for check in model.check_gradients())


def test_second_derivatives_of_rows() -> None:
    model = arael.loads(
        """
struct P {
    param x: vec2
    next: ref P in root.ps
    constraint near { x }
    require curved { x.x * next.x.y^2 + sin(x.y) == 1 }
    require apart { norm(x - next.x) >= 1 }
}
root R { ps: list of P }
""",
        interpret=True,
    )()
    rng = np.random.default_rng(1)
    model.ps.extend(x=rng.standard_normal((5, 2)), next=[1, 2, 3, 4, 0])
    problem = model._problem()
    rows = Rows(problem)
    weights = rng.standard_normal(rows.count)

    def slope() -> np.ndarray:
        return rows.transposed(rows.evaluate()[1], weights)

    values = rows.curvature(weights, rows.evaluate()[1])
    exact = np.zeros((problem.size, problem.size))
    start = [state.copy() for state in problem.states]
    for k in range(problem.size):
        ends = []
        for sign in (1, -1):
            step = np.zeros(problem.size)
            step[k] = sign * 1e-5
            problem.evaluation.moved_by(step)
            ends.append(slope())
            problem.evaluation.start_at(0, start[0])
        exact[:, k] = (ends[0] - ends[1]) / 2e-5
    assert np.allclose(dense_matrix(problem.structure.pattern, values), exact, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    "what",
    [
        lambda model, result: model.problem(),
        lambda model, result: model.covariance(gauge="free"),
        lambda model, result: model.verdict(),
        lambda model, result: model.next_data(1, {}, "rows"),
        lambda model, result: result.sensitivity("points[0].x.x"),
        lambda model, result: result.certificate(),
        lambda model, result: model.marginalise(model.points[0]),
        lambda model, result: check_splittable(model._compiled.layout),
    ],
)
def test_what_does_not_know_rows_refuses_by_name(what: Any) -> None:
    model = arael.loads(
        """
struct Point {
    param x: vec2
    constraint near { x - [1, 2] }
    require circle { norm(x) == 1 }
}
root R { points: list of Point }
""",
        interpret=True,
    )(points=[{"x": [1, 0]}])
    result = model.solve()
    with pytest.raises(AraelError, match=r"require|holds exactly"):
        what(model, result)
