"""Compiled kernels and the expression machine pose the same problem, and solve it alike."""

from __future__ import annotations

import contextlib
import signal

import numpy as np
import pytest

import arael

MODEL = """
struct Node {
    param pos: vec2
    param gain: real in 0 .. 10
    anchored: real = 0

    constraint prior { [(pos - pos.value) * 0.3, (gain - 1) * root.weight] }
    constraint anchor when anchored > 0.5 { pos .* [1, gain] }
}

# May tie a node to itself.
struct Tie {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    length: real

    constraint stretch {
        let d = b.pos * a.gain - a.pos
        [sqrt(d.x * d.x + d.y * d.y + 0.1) - length, sin(d.x) * root.scale]
    }
}

root Net {
    nodes: list of Node
    ties:  list of Tie
    weight: real = 0.7
    param scale: real
}
"""


@pytest.fixture(scope="module", params=["f64", "f32"])
def both(request, tmp_path_factory):
    """Two instances with the same data: compiled and interpreted."""
    path = tmp_path_factory.mktemp("models") / "net.arael"
    path.write_text(MODEL, encoding="utf-8")
    return request.param, [
        arael.load(path, precision=request.param, interpret=interpret)
        for interpret in (False, True)
    ]


def filled(model):
    """Node 1 keeps its gain, node 4 its position, node 6 everything; one tie is a loop."""
    rng = np.random.Generator(np.random.PCG64(7))
    net = model(scale=0.8)
    n = 11
    net.nodes.extend(
        pos=rng.normal(size=(n, 2)),
        gain=rng.uniform(0.5, 1.5, n),
        anchored=(np.arange(n) % 3 == 0).astype(float),
    )
    a = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 5, 9, 3, 2, 8, 1])
    b = np.array([1, 0, 3, 2, 9, 5, 1, 10, 4, 6, 0, 2, 7, 3, 6, 8, 5])
    net.ties.extend(a=a, b=b, length=rng.uniform(0.5, 2, len(a)))
    net.nodes[1].gain.fixed = True
    net.nodes[4].pos.fixed = True
    net.nodes[6].pos.fixed = net.nodes[6].gain.fixed = True
    return net


@pytest.mark.sweep(2)
def test_same_linearisation(both):
    precision, models = both
    tolerance = (
        {"rtol": 1e-12, "atol": 1e-12} if precision == "f64" else {"rtol": 2e-5, "atol": 2e-5}
    )
    compiled, interpreted = (filled(m) for m in models)
    assert compiled.parameter_names() == interpreted.parameter_names()
    assert len(compiled.parameter_names()) == 11 * 3 - 1 - 2 - 3 + 1
    assert compiled.cost() == pytest.approx(interpreted.cost(), rel=tolerance["rtol"])
    np.testing.assert_allclose(compiled.gradient(), interpreted.gradient(), **tolerance)
    np.testing.assert_allclose(compiled.hessian(), interpreted.hessian(), **tolerance)
    one, other = compiled.jacobian(), interpreted.jacobian()
    np.testing.assert_allclose(one.residuals, other.residuals, **tolerance)
    np.testing.assert_allclose(one.dense(), other.dense(), **tolerance)
    np.testing.assert_allclose(one.dense().T @ one.dense() * 2, compiled.hessian(), **tolerance)


def test_same_solution(both):
    precision, models = both
    compiled, interpreted = (filled(m) for m in models)
    results = [net.solve(rel_precision=1e-9, abs_precision=0.0) for net in (compiled, interpreted)]
    assert all(r.converged for r in results)
    tight = precision == "f64"
    assert results[0].cost == pytest.approx(results[1].cost, rel=1e-10 if tight else 1e-4)
    np.testing.assert_allclose(
        compiled.nodes.pos.value, interpreted.nodes.pos.value, atol=1e-6 if tight else 2e-2
    )
    before = filled(models[0])
    np.testing.assert_array_equal(compiled.nodes.pos.value[[4, 6]], before.nodes.pos.value[[4, 6]])
    assert compiled.nodes.gain.value[1] == before.nodes.gain.value[1]
    assert (compiled.nodes.gain.value >= 0).all()


@pytest.mark.parametrize("both", ["f64"], indirect=True)
def test_gradient_of_kernels_agrees_with_central_differences(both):
    """In f64 only: differences of f32 costs say nothing."""
    net = filled(both[1][0])
    gradient, names = net.gradient(), net.parameter_names()
    pos = net.nodes.pos.value.copy()
    for k, axis in (("x", 0), ("y", 1)):
        for node in (0, 3, 5, 8):
            costs = []
            for h in (1e-6, -1e-6):
                moved = pos.copy()
                moved[node, axis] += h
                net.nodes.pos.value = moved
                costs.append(net.cost())
            net.nodes.pos.value = pos
            # The drift residual is relative to the start and has no gradient there.
            expected = (costs[0] - costs[1]) / 2e-6
            assert gradient[names.index(f"nodes[{node}].pos.{k}")] == pytest.approx(
                expected, rel=1e-6, abs=1e-7
            )


@pytest.mark.parametrize("both", ["f64"], indirect=True)
def test_ctrl_c_ends_a_solve_that_never_enters_python(both):
    """Compiled kernels, no observer: only the loop's own look at signals can end this in time."""
    net = filled(both[1][0])
    assert net._compiled.kernels is not None

    def interrupt(*_):
        raise KeyboardInterrupt

    net.solve(max_iters=1)  # so that little is done before the loop
    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1, 1.0)
    result = None
    try:
        while result is None:
            # On a busy machine the signal may come before the loop, and leaves `solve` from there.
            with contextlib.suppress(KeyboardInterrupt):
                # Steps too short to converge: this would go on for minutes.
                result = net.solve(
                    max_iters=10**8,
                    min_iters=10**8,
                    initial_lambda=1e9,
                    lambda_floor=1e9,
                    time_limit=60.0,
                )
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    assert result.status == "aborted"
    assert result.accepted_iterations > 100
    assert net.cost_table()["Tie.stretch"] < result.start_cost


@pytest.mark.parametrize("both", ["f64"], indirect=True)
def test_covariance_takes_refs(both):
    net = filled(both[1][0])
    net.solve()
    found = net.covariance()
    np.testing.assert_allclose(
        found.matrix @ net.hessian(), 2 * np.eye(len(found.names)), atol=1e-8
    )
    assert found.marginal(net.nodes[0]).shape == (3, 3)
    assert found.marginal(net.nodes[1]).shape == (2, 2)
    np.testing.assert_array_equal(found.marginal(net.nodes[8]), found.marginal("nodes[8]"))
    np.testing.assert_array_equal(
        found.relative(net.nodes[0], net.nodes[8]), found.relative("nodes[0]", "nodes[8]")
    )
    with pytest.raises(arael.AraelError, match=r"`nodes\[6\]` is not solved for"):
        found.marginal(net.nodes[6])
