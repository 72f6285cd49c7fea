"""Guards over parameters, guards that change between passes, conditionals over parameters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from arael.compiler.compiler import syntax, types
from arael.compiler.moving_guards import split
from arael.config import LmConfig
from arael.diagnostics.records import Findings, Source
from arael.loading import load
from arael.model import Model
from arael.runtime.problem import Problem
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

TRIMMED = """
struct Reading { x: real
    constraint near when abs(root.a - x) < root.reach { root.a - x }
}
root Mean { param a: real; reach: real = 1.5; readings: list of Reading }
"""


def model_of(tmp_path: Path, text: str) -> type[Model]:
    path = tmp_path / "model.arael"
    path.write_text(text)
    return load(path)


def test_kernels_against_interpreter_and_differences(tmp_path: Path) -> None:
    text = """
struct Node { param p: vec3; param q: quaternion }
struct Edge { a: ref Node in root.nodes; b: ref Node in root.nodes; k: real; gps: vec3?
    constraint ahead when dot(a.q.rotate([1, 0, 0]), b.p - a.p) > 0 and k > 0.2 {
        a.q.conj().rotate(b.p - a.p) * k
    }
    constraint near when a.p.x > 0 or k > 0.7 loss cauchy(2) { sqrt(a.p.x + 5) * b.p - a.p }
    constraint seen when gps and b.p.y < root.limit { gps - a.p }
    constraint always { b.p - a.p }
}
root R { limit: real; nodes: list of Node; edges: list of Edge }
"""
    model = model_of(tmp_path, text)(limit=0.3)
    rng = np.random.default_rng(0)
    q = rng.normal(size=(6, 4))
    model.nodes.extend(p=rng.normal(size=(6, 3)), q=q / np.linalg.norm(q, axis=1)[:, None])
    for i in range(23):
        gps = rng.normal(size=3) if i % 3 else None
        a, b = model.nodes[i % 6], model.nodes[(i + 1 + i // 6) % 6]
        model.edges.append(a=a, b=b, k=rng.random(), gps=gps)
    check_against_oracle(model)
    check_against_differences(model)
    p, k = model.nodes.p.value, model.edges.k
    a, b = np.array([i % 6 for i in range(23)]), np.array([(i + 1 + i // 6) % 6 for i in range(23)])
    has_gps = np.arange(23) % 3 != 0
    expected = {
        "Edge.near": int(((p[a, 0] > 0) | (k > 0.7)).sum()),
        "Edge.seen": int((has_gps & (p[b, 1] < 0.3)).sum()),
        "Edge.always": 23,
    }
    for kernels in (type(model).compiled.kernels, None):  # type: ignore[attr-defined]
        problem = Problem(model._compiled.layout, model._store, kernels)
        for number, group in enumerate(problem.layout.groups):
            acting = problem.evaluation.acting(number)
            if group.label in expected:
                assert acting.sum() == expected[group.label]
            assert acting.sum() > 0 and len(acting) == len(problem.structure.active[number])
            residuals, entries = problem.evaluation.group_rows(number)
            assert not residuals[~acting].any() and not entries[~acting].any()
            assert residuals[acting].any(axis=1).all()


@pytest.mark.parametrize("strategy", ["dogleg", "damped"])
@pytest.mark.parametrize("interpret", [False, True])
def test_instances_switch_as_the_solve_goes(
    tmp_path: Path, interpret: bool, strategy: Literal["dogleg", "damped"]
) -> None:
    path = tmp_path / "trimmed.arael"
    path.write_text(TRIMMED)
    model = load(path, interpret=interpret)(a=0.0)
    x = np.array([-3.0, 0.5, 1.2, 1.4, 2.0, 2.1, 2.3, 2.4, 2.6, 9.0])
    model.readings.extend(x=x)
    # The cost rises where readings come in, which only the reference's rule of ending goes over.
    config = LmConfig.reference(abs_precision=1e-14, rel_precision=1e-14)
    result = model.solve(replace(config, strategy=strategy, damping="gain"))
    assert (result.history["cost"][1:] > result.history["trial_cost"][:-1]).any()
    mean = 0.0
    for _ in range(50):
        near = np.abs(mean - x) < 1.5
        mean = x[near].mean()
    assert near.sum() == 8  # at the start only three are near
    assert model.a.value == pytest.approx(mean, rel=1e-9)
    assert result.cost == pytest.approx(((mean - x[near]) ** 2).sum(), rel=1e-9)
    assert model.cost() == pytest.approx(result.cost, rel=1e-12)
    table = model.cost_table()
    assert table.instances["Reading.near"] == 8
    jacobian = model.jacobian()
    assert jacobian.constraint.tolist() == np.flatnonzero(near).tolist()
    assert jacobian.dense().ravel().tolist() == [1.0] * 8


def test_readings_that_would_come_in_and_cost_more_end_the_solve(tmp_path: Path) -> None:
    """By default costs are compared with guards asked at the trial state."""
    path = tmp_path / "trimmed.arael"
    path.write_text(TRIMMED)
    model = load(path, interpret=True)(a=0.0)
    x = np.array([-3.0, 0.5, 1.2, 1.4, 2.0, 2.1, 2.3, 2.4, 2.6, 9.0])
    model.readings.extend(x=x)
    result = model.solve()
    cost = ((float(model.a.value) - x[np.abs(float(model.a.value) - x) < 1.5]) ** 2).sum()
    assert result.status == "stalled"
    assert result.end_cost == pytest.approx(cost, rel=1e-12)
    assert result.end_cost < result.start_cost
    assert result.predicted_decrease > 1e-3 * result.end_cost


def test_what_does_not_act_may_be_undefined(tmp_path: Path) -> None:
    model = model_of(
        tmp_path,
        "struct D { x: real\n    constraint c when root.a * x > 0 { sqrt(root.a * x) - 1 }\n}\n"
        "root R { param a: real = 0.5; data: list of D }\n",
    )()
    model.data.extend(x=[2.0, -2.0, 2.0])
    assert model.cost() == 0
    model.a = 2.0
    model.solve()
    assert model.a.value == pytest.approx(0.5, abs=1e-6)


def test_guards_change_between_passes(tmp_path: Path) -> None:
    model = model_of(
        tmp_path,
        """
struct D { x: real; late: bool
    constraint c when not late or root.everything { root.a - x }
}
root R {
    param a: real = 0
    everything: bool = false
    data: list of D
    solve {
        pass first { everything = false }
        pass second { everything = true }
    }
}
""",
    )()
    model.data.extend(x=[1.0, 3.0, 11.0], late=[False, False, True])
    model.solve(passes="first", rel_precision=1e-12, abs_precision=1e-12)
    assert model.a.value == pytest.approx(2)
    model.solve(rel_precision=1e-12, abs_precision=1e-12)
    assert model.a.value == pytest.approx(5)


@pytest.mark.parametrize("start", [2.0, -2.0])
def test_only_the_taken_arm_counts(tmp_path: Path, start: float) -> None:
    model = model_of(
        tmp_path,
        "root R { param a: real; param b: vec2 = [1, 2]\n"
        "    constraint c { if a > 0 then [log(a), b.x * a] else [1 + a^2, sqrt(-a) * b.y] }\n"
        "    constraint d { b }\n}\n",
    )(a=start)
    check_against_oracle(model)
    check_against_differences(model)
    row = model.jacobian().dense()[:2]
    expected = (
        [[0.5, 0, 0], [1, 2, 0]]
        if start > 0
        else [[-4, 0, 0], [-2 / (2 * np.sqrt(2)), 0, np.sqrt(2)]]
    )
    np.testing.assert_allclose(row, expected, atol=1e-12)


def test_guards_fall_apart_at_and() -> None:
    text = """
struct D { x: real; gps: vec2?
    constraint c when gps and (root.a > 0 or x > 1) and x < 3 and root.a < 5 { root.a - x }
}
root R { param a: real; data: list of D }
"""
    model = types(syntax(Source("model.arael", text)), Findings())
    still, moving = split(model.constraints[0].guard)
    assert still is not None and moving is not None
    layout_of = [still.span.text, moving.span.text]
    assert layout_of == ["x < 3", "root.a < 5"]
    assert split(None) == (None, None)
