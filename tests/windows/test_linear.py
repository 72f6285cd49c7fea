"""Marginalisation of linear problems equals the solution of the whole problem."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael

TIGHT = {"abs_precision": 0.0, "rel_precision": 0.0, "initial_lambda": 1e-12}

CHAIN = """
struct Node {
    param x: vec2
    param h: real
}
struct Link {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    d: vec2
    w: real = 1
    constraint link { (b.x - a.x - d * b.h) * (1 + w) }
    constraint height { b.h - 0.9 * a.h - w }
}
struct Fix {
    n: ref Node in root.nodes
    d: vec2
    constraint fix { [(n.x * root.scale - d) * 0.5, n.h - 0.1 * d.x] }
}
root Net {
    nodes: list of Node
    links: list of Link
    fixes: list of Fix
    scale: real = 1
}
"""


@pytest.fixture(scope="module")
def net() -> Any:
    return arael.loads(CHAIN, name="net", interpret=True)


def filled(net: Any, edges: Any, count: int, seed: int) -> Any:
    rng = np.random.default_rng(seed)
    model = net()
    model.nodes.extend(count, x=rng.normal(size=(count, 2)), h=rng.normal(size=count))
    a, b = np.transpose(edges)
    n = len(a)
    model.links.extend(a=a, b=b, d=rng.normal(size=(n, 2)), w=rng.uniform(0.5, 2, n))
    some = rng.permutation(count)[: count // 3 + 1]
    model.fixes.extend(n=some, d=rng.normal(size=(len(some), 2)))
    return model


def chain(count: int) -> list[tuple[int, int]]:
    return [(k, k + 1) for k in range(count - 1)]


def grid(side: int) -> list[tuple[int, int]]:
    at = np.arange(side * side).reshape(side, side)
    across = zip(at[:, :-1].ravel(), at[:, 1:].ravel(), strict=True)
    down = zip(at[:-1].ravel(), at[1:].ravel(), strict=True)
    return [*across, *down]


@pytest.mark.sweep(4)
@pytest.mark.parametrize("first_estimates", [True, False])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("edges", "count"), [(chain(12), 12), (grid(4), 16)])
def test_rows_in_any_order_leave_the_batch_solution(
    net: Any, edges: Any, count: int, seed: int, first_estimates: bool
) -> None:
    model, whole = filled(net, edges, count, seed), filled(net, edges, count, seed)
    whole.solve(**TIGHT)
    batch = whole.covariance()
    rng = np.random.default_rng(seed)
    nodes, others = list(model.nodes), list(whole.nodes)
    waiting = list(range(count))
    while len(waiting) > 3:
        chosen = rng.choice(
            waiting, size=min(int(rng.integers(1, 3)), len(waiting) - 3), replace=False
        )
        model.marginalise([nodes[k] for k in chosen], first_estimates=first_estimates)
        waiting = [k for k in waiting if k not in chosen]
        if rng.random() < 0.5:
            model.solve()
    model.solve(**TIGHT)
    found = model.covariance()
    assert len(model.nodes) == 3
    for k in waiting:
        assert nodes[k].x.value == pytest.approx(others[k].x.value, abs=1e-10)
        assert nodes[k].h.value == pytest.approx(others[k].h.value, abs=1e-10)
        expected = batch.marginal(others[k])
        assert found.marginal(nodes[k]) == pytest.approx(expected, abs=1e-10)
    constant = sum(p.function.constant for p in model.residuals.priors.values())
    assert model.cost() + constant == pytest.approx(whole.cost(), rel=1e-10)
