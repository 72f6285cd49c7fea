"""Priors on manifolds: differences invert retractions; derivatives at other values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.geometry.differences import difference

KINDS = {
    "real": 1.0,
    "vec3": [1.0, 2.0, 3.0],
    "angle": 3.0,
    "euler": [0.1, 0.2, 0.3],
    "rotation": [0.1, 0.2, 0.3],
    "quaternion": [0.1, -0.2, 2.0],
    "direction": [0.36, 0.48, -0.8],
    "transform": [1.0, 2.0, 3.0, 0.3, -0.2, 0.5],
    "similarity": [1.0, 2.0, 3.0, 0.9, 0.1, 0.3, 0.3, 2.0],
}
TANGENT = {"real": 1, "vec3": 3, "angle": 1, "direction": 2, "transform": 6, "similarity": 7}

MODEL = """
struct Known {{ param x: {kind} }}
struct Pair {{
    param first: real
    of_it: ref Known in root.known
    constraint link {{ {residual} }}
}}
root All {{ known: list of Known
    pairs: list of Pair }}
"""


def model_of(kind: str) -> Any:
    residual = {
        "rotation": "[(3 + first) * x.x.euler_angles(), first]",
        "quaternion": "[(3 + first) * x.x.log(), first]",
        "transform": "[(3 + first) * x.x.log(), first]",
        "similarity": "[(3 + first) * x.x.log(), first]",
    }.get(kind, "[(3 + first) * x.x, first]")
    text = MODEL.format(kind=kind, residual=residual.replace("x.x", "of_it.x"))
    model = arael.loads(text, name=f"manifold_{kind}", interpret=True)()
    model.known.append(x=normal(kind))
    model.pairs.append(first=0.1, of_it=0)
    return model


def normal(kind: str) -> Any:
    value = np.array(KINDS[kind])
    if kind == "similarity":
        value[3:7] /= np.linalg.norm(value[3:7])
    return value


@pytest.mark.parametrize("kind", KINDS)
def test_a_difference_inverts_the_step(kind: str) -> None:
    model = model_of(kind)
    dim = TANGENT.get(kind, 3)
    problem = model.problem()
    delta = np.random.default_rng(dim).normal(0, 0.4, problem.size)
    delta[dim:] = 0
    base = problem.x[:-1][None]
    problem.retract(delta)
    name = "vec" if kind.startswith("vec") else kind
    assert difference(name, base, problem.x[:-1][None])[0] == pytest.approx(delta[:dim], abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_of_a_prior_are_right_away_from_its_first_estimate(kind: str) -> None:
    model = model_of(kind)
    prior = model.marginalise(model.pairs[0])
    assert len(prior.function.residual) == TANGENT.get(kind, 3)
    before, information = prior.residuals.ravel(), prior.function.jacobian
    problem = model.problem()
    delta = np.random.default_rng(5).normal(0, 0.3, problem.size)
    problem.retract(delta)
    problem.write_back()
    assert prior.residuals.ravel() == pytest.approx(before + information @ delta, abs=1e-11)
    assert all(check.agrees for check in model.check_gradients())


def test_first_estimates_are_kept_by_the_next_prior() -> None:
    text = """
    struct P { param a: angle
      param p: vec2 }
    struct S { x: ref P in root.ps
      y: ref P in root.ps
      constraint s { y.p - x.p - x.a.rotation_matrix() * [1, 0] }
      constraint t { y.a - x.a - 0.1 } }
    root R { ps: deque of P
      ss: deque of S }
    """
    model = arael.loads(text, name="first", interpret=True)()
    model.ps.extend(4, p=[[0, 0], [1, 0], [2, 0], [3, 0]], a=[0, 0.1, 0.2, 0.3])
    model.ss.extend(x=[0, 1, 2], y=[1, 2, 3])
    model.ps[0].p.fixed = model.ps[0].a.fixed = True
    first = model.marginalise(model.ps[0])
    assert [part.base.tolist() for part in first.function.parts] == [[0.1], [1.0, 0.0]]
    shifted, plain = model.copy(), model.copy()
    for one, keeps in ((shifted, True), (plain, False)):
        one.ps[0].a.value = 0.5
        prior = one.marginalise(one.ps[0], first_estimates=keeps)
        heading = 0.1 if keeps else 0.5
        moved = np.array([-np.sin(heading), np.cos(heading)])
        # y.p = x.p + R (1, 0), whose derivative by the heading is `moved`.
        cov = np.linalg.inv(prior.function.information)
        assert [part.kind for part in prior.function.parts] == ["angle", "vec"]
        across = cov[1:, 1:] - 2 * np.eye(2)  # p and the step have covariance 1 each
        assert across == pytest.approx(np.outer(moved, moved), abs=1e-9)
