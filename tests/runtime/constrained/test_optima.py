"""Solves with rows that hold exactly, against optima that are known."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from benchmarks.constrained.formulas import FORMULAS, Formulas

CIRCLE = """
root Point {
    param x: vec2 [m]
    goal: vec2 [m]
    radius: real [m] = 2
    constraint near { (x - goal) / (1 [m]) }
    require circle { norm(x) == radius }
    require right { x.x >= 0.5 [m] }
}
"""


def circle(**data: object) -> arael.Model:
    return arael.loads(CIRCLE, name="circle", interpret=True)(x=[1, 0.1], **data)


@pytest.mark.parametrize("problem", FORMULAS, ids=lambda p: p.name)
def test_problems_of_the_literature(problem: Formulas) -> None:
    model = arael.loads(problem.text(), name=problem.name, interpret=True)(**problem.data())
    result = model.solve()
    assert result.status == "converged"
    assert result.violation <= 1e-9
    assert abs(result.cost - problem.cost) <= 1e-7 * max(1.0, abs(problem.cost))


def test_the_closest_point_of_a_circle() -> None:
    model = circle(goal=[3.0, 4.0])
    result = model.solve()
    assert result.converged
    assert np.allclose(model.x.value, [1.2, 1.6], rtol=0, atol=1e-9)
    # cost (5 - R)^2: raising the radius lowers it by 2 (5 - R)
    assert result.multipliers["Point.circle"] == pytest.approx(np.array([[6.0]]), rel=1e-7)
    assert result.multipliers["Point.right"] == pytest.approx(np.array([[0.0]]), abs=1e-9)
    assert not result.required["Point.right"].active.any()
    assert result.required["Point.circle"].units == ("m",)


@pytest.mark.parametrize("interpret", [True, False])
def test_multipliers_are_what_relaxing_gains(interpret: bool) -> None:
    # The other side of the circle is closer, but not allowed.
    source = CIRCLE.replace("0.5 [m]", "root.least").replace(
        "radius: real [m] = 2",
        """
    radius: real [m] = 2
    least: real [m] = 0.5""",
    )
    loaded = arael.loads(source, name="relaxed", interpret=interpret)

    def solved(**data: float) -> arael.Result:
        return loaded(x=[1, 0.5], goal=[-1.0, 3.0], **data).solve()

    result = solved()
    assert result.converged
    assert result.required["Point.right"].active.all()
    step = 1e-4
    raised = (solved(radius=2 - step).cost - solved(radius=2 + step).cost) / (2 * step)
    relaxed = (solved(least=0.5 + step).cost - solved(least=0.5 - step).cost) / (2 * step)
    assert result.multipliers["Point.circle"][0, 0] == pytest.approx(raised, rel=1e-5)
    assert result.multipliers["Point.right"][0, 0] == pytest.approx(relaxed, rel=1e-5)
    assert relaxed > 0
    assert "`Point.right` at Point costs" in str(result)
    assert "per m: relaxed by" in str(result)


def test_redundant_and_weakly_active_rows_are_ordinary() -> None:
    model = arael.loads(
        """
root R {
    param x: vec3
    constraint near { x - [1, 1, 1] }
    require plane { x.x + x.y + x.z == 3 }
    require again { 2 * (x.x + x.y + x.z) == 6 }
    require twice { [x.x + x.y, x.x + x.y] == [2, 2] }
    require touched { x.z >= 1 }
}
""",
        interpret=True,
    )(x=[5, -3, 2])
    result = model.solve()
    assert result.converged
    assert np.allclose(model.x.value, 1.0, rtol=0, atol=1e-9)
    assert result.iterations <= 3


def test_bounds_hold_exactly_beside_rows() -> None:
    model = arael.loads(
        """
root R {
    param x: vec2 in 0 .. 1
    constraint near { x - [-2, 3] }
    require line { x.x + x.y == 0.5 }
}
""",
        interpret=True,
    )(x=[0.3, 0.3])
    assert model.solve().converged
    assert model.x.value[0] == 0.0
    assert model.x.value[1] == pytest.approx(0.5, abs=1e-12)


def test_fixed_parameters_passes_and_a_second_solve() -> None:
    model = arael.loads(
        """
root R {
    param a: real
    param b: real
    pull: real = 1
    constraint near { [a - 4, (b - 4) * pull] }
    require product { a * b == 2 }
    solve {
        pass loose { pull = 0.1 }
        pass tight { pull = 10 }
    }
}
""",
        interpret=True,
    )(a=1, b=1)
    result = model.solve()
    assert [one.status for one in result.passes] == ["converged", "converged"]
    assert model.a.value * model.b.value == pytest.approx(2, rel=1e-12)
    again = model.solve(passes="tight")
    assert again.iterations <= 1
    model.a.fixed = True
    model.a.value = 1.0
    frozen = model.solve(passes="tight")
    assert frozen.converged
    assert model.b.value == pytest.approx(2, rel=1e-12)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_rotations_with_rows(precision: str) -> None:
    model = arael.loads(
        f"""
struct Body {{
    param q: quaternion
    goal: vec3
    constraint turned {{ q.rotate([1, 0, 0]) - goal }}
    require level {{ q.rotate([0, 0, 1]).y == 0.1 }}
}}
root R : {precision} {{ bodies: list of Body }}
""",
        interpret=True,
    )()
    rng = np.random.default_rng(3)
    for _ in range(12):
        q, goal = rng.standard_normal(4), rng.standard_normal(3)
        model.bodies.append(q=q / np.linalg.norm(q), goal=goal / np.linalg.norm(goal))
    result = model.solve()
    assert result.converged
    w, x, y, z = model.bodies.q.value.T
    tilt = 2 * (y * z - w * x)
    assert np.allclose(tilt, 0.1, rtol=0, atol=1e-9 if precision == "f64" else 1e-4)


def test_kernels_machine_and_threads_agree() -> None:
    costs = []
    for interpret, threads in ((True, 1), (False, 1), (False, 2)):
        model = arael.loads(CIRCLE, name="circle", interpret=interpret)(x=[1, 1], goal=[-1.0, 3.0])
        costs.append(model.solve(num_threads=threads).cost)
    assert costs[1] == costs[2]
    assert costs[0] == pytest.approx(costs[1], rel=1e-12)


def test_a_robust_loss_beside_rows() -> None:
    model = arael.loads(
        """
root R {
    param x: real
    param y: real
    constraint far loss huber(1) { x - 10 }
    constraint near { y }
    require sum { x + y == 2 }
}
""",
        interpret=True,
    )(x=0, y=0)
    assert model.solve().converged
    # huber: slope of the cost is -2 beyond 1, so that y = -1 and x = 3
    assert model.x.value == pytest.approx(3, rel=1e-9)


def test_guarded_instances_add_nothing() -> None:
    loaded = arael.loads(
        """
struct P {
    param x: real
    held: bool
    constraint near { x - 1 }
    require at_most when held { x <= 0.5 }
}
root R { ps: list of P }
""",
        interpret=True,
    )
    model = loaded(ps=[{"x": 0, "held": True}, {"x": 0, "held": False}])
    result = model.solve()
    assert model.ps.x.value == pytest.approx([0.5, 1.0], abs=1e-12)
    assert result.multipliers["P.at_most"].shape == (1, 1)
    assert result.required["P.at_most"].places == ("ps[0]",)


def test_limits_of_attempts_time_and_observers() -> None:
    assert circle(goal=[3.0, 4.0]).solve(max_iters=1).status == "max_iterations"
    assert circle(goal=[3.0, 4.0]).solve(time_limit=0.0).status == "time_limit"
    stopped = circle(goal=[3.0, 4.0]).solve(observer=lambda record: False)
    assert stopped.status == "observer_terminated"
    lines: list[str] = []
    circle(goal=[3.0, 4.0]).solve(trace=lines.append)
    assert lines[0].startswith("1/0: ")


def test_a_result_as_plain_data() -> None:
    found = circle(goal=[3.0, 4.0]).solve().to_dict()["required"]
    assert [one["label"] for one in found["rows"]] == ["Point.circle", "Point.right"]
    assert found["violation"] < 1e-9


def test_sums_over_rows_hold_and_are_one_requirement() -> None:
    model = arael.loads(
        """
struct Part {
    param x: real in 0 ..
    constraint near { x - 1 }
}
struct Whole {
    total: real
    parts: list of Part
    require sum { sum(k in parts) { k.x } == total }
}
root R { wholes: list of Whole }
""",
        interpret=True,
    )()
    for total, count in ((1.0, 2), (6.0, 3), (2.0, 2)):
        model.wholes.append(total=total, parts=[{"x": 0.5}] * count)
    result = model.solve()
    assert result.converged
    assert model.wholes.parts.x.value == pytest.approx([0.5, 0.5, 2, 2, 2, 1, 1])
    required = result.required["Whole.sum"]
    assert required.places == ("wholes[0]", "wholes[1]", "wholes[2]")
    assert required.multipliers.ravel() == pytest.approx([1, -2, 0], abs=1e-9)


def test_derivatives_that_do_not_exist_at_the_start_are_named() -> None:
    with pytest.raises(arael.AraelError, match="E1002") as caught:
        arael.loads(CIRCLE, name="circle", interpret=True)(x=[0, 0], goal=[3.0, 4.0]).solve()
    assert "`norm(x)`" in str(caught.value)


def test_what_costs_nothing_has_no_price() -> None:
    model = arael.loads(
        "root R {\n param x: vec2\n require on { norm2(x) == 4 }\n}", name="only", interpret=True
    )(x=[1, 1])
    result = model.solve()
    assert result.converged
    assert np.linalg.norm(model.x.value) == pytest.approx(2, rel=1e-9)
    assert "1 required row holds" in str(result)
    assert "costs" not in str(result)


def test_a_function_that_fails_leaves_the_best_state() -> None:
    model = circle(goal=[3.0, 4.0])
    calls = []

    def function(x):
        calls.append(1)
        if len(calls) > 6:
            raise ValueError("no more")
        return x[:, 1:] - 1.0

    model.add_residuals(function, [model.x], name="level", kind="at_least")
    with pytest.raises(arael.AraelError, match="no more") as caught:
        model.solve()
    assert caught.value.best is not None
    assert caught.value.best.status == "aborted"
