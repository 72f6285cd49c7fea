"""Random models in the language, with data: what generated kernels are compared on.

Expressions are smooth and stay away from singular points, so that differences mean something.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

HEAD = """
fn head3(v) = [v[0], v[1], v[2]]
fn tail3(v) = [v[3], v[4], v[5]]
struct Node {
    param p: vec3
    param e: euler
    param s: real
    m: mat3
    d: vec3
    w: real
    on: bool
}
struct Turner {
    param q: quaternion
    param r: rotation
    param h: angle
    param v: vec2
    param d: direction
    param T: transform
    param S: similarity
    c: vec3
    between: transform
    more: list of Leaf
}
struct Leaf {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    k: vec3
    weight: real
"""

TAIL = """
}
root Random {
    nodes: list of Node
    turners: list of Turner
    param g: vec2
    scale: real = 0.7
"""

SCALARS = [
    "a.p.x", "a.p.y", "a.s", "b.p.z", "b.s", "b.e.x", "a.e.z", "parent.v.x", "parent.v.y",
    "parent.h", "root.g.x", "root.g.y", "k.x", "k.z", "weight", "root.scale", "a.w", "b.d.y",
    "parent.q.w", "a.p.value.x", "0.5", "1.25", "2", "parent.d.x", "parent.T.translation.y",
    "parent.S.scale", "parent.T.rotation.w", "parent.S.inverse().scale",
]  # fmt: skip
VECTORS = [
    "a.p", "b.p", "k", "a.d", "parent.c", "a.e.rotation_matrix() * b.p",
    "b.e.rotation_matrix()' * (a.p - b.p)", "parent.q.rotate(k)", "b.m * k",
    "parent.r.rotation_matrix() * a.p", "(parent.q * parent.r).vec",
    "euler_angles(a.e.rotation_matrix()' * rotation_matrix(k))", "a.e - a.e.value",
    "unit(b.p + [3, 4, 5])", "parent.q.conj().rotate(b.p)", "parent.d", "parent.T * a.p",
    "parent.T.inverse() * b.p", "parent.S * k", "parent.S.inverse() * (parent.T * a.p)",
    "head3((parent.T.inverse() * parent.between).log())", "cross(parent.d, parent.d.value)",
    "(parent.between * parent.T * parent.T.value).translation", "parent.S.rotation_matrix() * k",
    "tail3((parent.S.value.inverse() * parent.S * exp([0.1 * k, 0.2 * k, k.x])).log())",
    "head3(parent.T.matrix() * [k, 1])", "transform(k, parent.q) * b.p",
]  # fmt: skip
UNARY = ["sin({})", "cos({})", "atan({})", "tanh({})", "exp(0.3 * tanh({}))", "sqrt(2 + sin({}))",
         "starship({}, 2.5)", "-{}", "({})^2", "log(3 + cos({}))", "fast_atan({})"]  # fmt: skip
BINARY = ["({} + {})", "({} - {})", "({} * {})", "({} / (3 + cos({})))", "hypot({} + 5, {} + 7)",
          "atan2({} + 9, {} + 4)", "rad_diff({}, 0.1 * {})"]  # fmt: skip
VECTOR_TO_SCALAR = ["dot({}, {})", "norm({} + {} + [7, 8, 9])", "cross({}, {}).y"]


def scalars(depth: int) -> st.SearchStrategy[str]:
    """Expressions of a number."""
    if depth == 0:
        return st.sampled_from(SCALARS)
    inner = scalars(depth - 1)
    return st.one_of(
        st.sampled_from(SCALARS),
        st.builds(lambda f, a: f.format(a), st.sampled_from(UNARY), inner),
        st.builds(lambda f, a, b: f.format(a, b), st.sampled_from(BINARY), inner, inner),
        st.builds(
            lambda f, a, b: f.format(a, b),
            st.sampled_from(VECTOR_TO_SCALAR),
            vectors(depth - 1),
            vectors(depth - 1),
        ),
        st.builds(
            lambda c, a, b: f"(if {c} > 0.3 then {a} else {b})",
            st.sampled_from(["weight", "k.x", "root.scale"]),
            inner,
            inner,
        ),
    )


def vectors(depth: int) -> st.SearchStrategy[str]:
    """Expressions of a vector of three."""
    if depth == 0:
        return st.sampled_from(VECTORS)
    return st.one_of(
        st.sampled_from(VECTORS),
        st.builds(lambda a, b: f"({a} + {b})", vectors(depth - 1), vectors(depth - 1)),
        st.builds(lambda a, b: f"{b} * ({a})", vectors(depth - 1), scalars(depth - 1)),
        st.builds(lambda a, b: f"cross({a}, {b})", vectors(depth - 1), vectors(depth - 1)),
    )


@dataclass(frozen=True)
class RandomModel:
    """A model's text and the seed of its data."""

    text: str
    seed: int


@st.composite
def models(draw: st.DrawFn, constraints: int = 4) -> RandomModel:
    """Draw a model with several random constraints."""
    lines = []
    for number in range(constraints):
        parts = [draw(scalars(3)), draw(vectors(2))]
        guard = draw(st.sampled_from(["", " when weight > 0.2", " when a.on and weight < 0.9"]))
        body = ", ".join(parts)
        lines.append(
            f"    constraint c{number}{guard} {{\n"
            f"        let z = a.p.x + root.g.x + parent.h\n        [z * 0.1, {body}]\n    }}"
        )
    text = HEAD + "\n".join(lines) + TAIL
    text += "    constraint own { g - [0.3, 0.4] }\n}\n"
    return RandomModel(text, draw(st.integers(0, 2**31)))


def unit(rows: np.ndarray) -> np.ndarray:
    """Rows of length 1."""
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


def fill(model: Any, seed: int) -> None:
    """Give an instance data; `a` and `b` of a leaf sometimes meet in one node."""
    rng = np.random.default_rng(seed)
    nodes, turners, leaves = 5, 3, 21
    model.nodes.extend(
        p=rng.normal(size=(nodes, 3)),
        e=rng.uniform(-0.9, 0.9, (nodes, 3)),
        s=rng.normal(size=nodes),
        m=rng.normal(size=(nodes, 3, 3)),
        d=rng.normal(size=(nodes, 3)),
        w=rng.normal(size=nodes),
        on=rng.random(nodes) < 0.7,
    )
    q, r, t, s, z = (unit(rng.normal(size=(turners, 4))) for _ in range(5))
    model.turners.extend(
        q=q,
        r=r,
        h=rng.uniform(-2, 2, turners),
        v=rng.normal(size=(turners, 2)),
        d=unit(rng.normal(size=(turners, 3))),
        T=np.hstack([rng.normal(size=(turners, 3)), t]),
        S=np.hstack([rng.normal(size=(turners, 3)), s, rng.uniform(0.5, 2, (turners, 1))]),
        between=np.hstack([rng.normal(size=(turners, 3)), z]),
        c=rng.normal(size=(turners, 3)),
    )
    for _ in range(leaves):
        model.turners[int(rng.integers(turners))].more.append(
            a=model.nodes[int(rng.integers(nodes))],
            b=model.nodes[int(rng.integers(nodes))],
            k=rng.normal(size=3),
            weight=rng.random(),
        )
    model.g.value[...] = rng.normal(size=2)
