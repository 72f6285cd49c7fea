"""Evaluating graphs at points, and differentiating them numerically, for the tests of this
folder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.manifolds.parameters import parameter_type
from arael.runtime.machine.tape import Tape
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import Method
from arael.symbolic.jacobian import jacobian as derive
from tests.oracle import evaluate

Array = NDArray[Any]


def inputs(g: Graph, n: int, name: str = "x") -> list[int]:
    return [g.input((name, i)) for i in range(n)]


def run(g: Graph, outputs: Iterable[int], point: Sequence[float]) -> Array:
    """Values of `outputs` where the graph's inputs, in order of creation, are `point`."""
    tape = g.tape(outputs)
    values = evaluate(tape, list(point))
    return np.array([values[node][()] for node in tape.outputs])


def jacobian(
    g: Graph,
    outputs: Sequence[int],
    by: Sequence[int],
    point: Sequence[float],
    methods: Sequence[Method] = ("forward", "eliminate"),
) -> Array:
    """Symbolic derivative of `outputs` by input nodes `by`, evaluated."""
    one, zero = g.const(1.0), g.const(0.0)
    rows = derive(g, outputs, {node: {k: one} for k, node in enumerate(by)}, methods)
    flat = [row.get(k, zero) for row in rows for k in range(len(by))]
    return run(g, flat, point).reshape(len(outputs), len(by))


def jacobian_program(g: Graph, outputs: list[int], seeds: dict[int, dict[int, int]]) -> Tape:
    """Program of `outputs` and of all their derivatives."""
    rows = derive(g, outputs, seeds)
    return g.tape([*outputs, *(node for row in rows for node in row.values())])


def central(g: Graph, outputs: Sequence[int], point: Sequence[float], step: float = 1e-6) -> Array:
    """Central differences of `outputs` by every input of the graph."""
    x = np.asarray(point, float)
    columns = []
    for k in range(len(x)):
        h = np.zeros_like(x)
        h[k] = step
        columns.append((run(g, outputs, x + h) - run(g, outputs, x - h)) / (2 * step))
    return np.array(columns).T


def complex_step(g: Graph, outputs: Sequence[int], point: Sequence[float]) -> Array:
    """Derivative of `outputs` by every input, exact to rounding, for analytic programs."""
    columns = []
    for k in range(len(point)):
        x = np.array(point, complex)
        x[k] += 1e-30j
        columns.append(np.imag(run(g, outputs, x)) / 1e-30)
    return np.array(columns).T


def between_factor() -> tuple[Graph, list[int], dict[int, dict[int, int]]]:
    """SE(3) between factor on cached rotation matrices: 6 residuals, 12 seeds.

    Inputs: translation, quaternion and rotation matrix of two poses, measured translation and
    quaternion, the 21 entries of an upper triangular whitening matrix.
    """
    from arael.manifolds import linear, quaternion

    g = Graph()
    kind = parameter_type("quaternion")
    seeds: dict[int, dict[int, int]] = {}

    def pose(name: str, base: int) -> tuple[list[int], list[int], linear.Matrix]:
        t, q, r = inputs(g, 3, name + ".t"), inputs(g, 4, name + ".q"), inputs(g, 9, name + ".R")
        seeds.update({node: {base + k: g.const(1.0)} for k, node in enumerate(t)})
        of_r = kind.cache_tangents(g, q, {"R": r})["R"]
        for node, entries in zip([*q, *r], [*kind.tangent(g, q, {}), *of_r], strict=True):
            seeds[node] = {base + 3 + k: entry for k, entry in entries.items()}
        return t, q, linear.matrix(r, 3, 3)

    (ta, qa, ra), (tb, qb, _) = pose("a", 0), pose("b", 6)
    tm, qm, u = inputs(g, 3, "tm"), inputs(g, 4, "qm"), iter(inputs(g, 21, "U"))
    whitening = [[g.const(0.0) if j < i else next(u) for j in range(6)] for i in range(6)]
    offset = linear.matvec(g, linear.transpose(ra), linear.sub(g, tb, ta))
    turn = quaternion.product(
        g, quaternion.conj(g, qm), quaternion.product(g, quaternion.conj(g, qa), qb)
    )
    flip = g.op("lt", turn[0], g.const(0.0))
    vector = [g.op("select", flip, g.op("neg", x), x) for x in turn[1:]]
    error = [*linear.sub(g, offset, tm), *linear.scale(g, g.const(2.0), vector)]
    return g, linear.matvec(g, whitening, error), seeds
