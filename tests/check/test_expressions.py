"""Types of expressions: what each operator and function gives."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.check.typed import Apply, Read, Select, Typed
from arael.check.walk import postorder
from tests.check.models import checked, codes

FIELDS = """
    param p: vec3
    param ea: euler
    param rot: rotation
    param th: angle
    param x: real
    n: int
    on: bool
    u: vec2
    v: vec3
    w: vec<4>
    m: mat2
    r: mat3
    k: mat<2,3>
    q: quat
"""


def type_of(expression: str) -> str:
    """Type of an expression, from a constraint that reads it component by component."""
    text = f"root Fit {{ {FIELDS}\n constraint c {{ let t = {expression}\n use }} }}"
    found = {}
    for use, kind in (
        ("x * t", "scalar"),
        ("[x, t]", "vector"),
        ("x * trace(t * transpose(t))", "matrix"),
        ("x * conj(t).w", "quaternion"),
        ("if t then x else 2 * x", "bool"),
    ):
        if not [c for c in codes(text.replace("use", use)) if c[0] == "E"]:
            found[kind] = use
    if "quaternion" in found:
        return "quat"
    if "bool" in found:
        return "bool"
    if "scalar" in found and "vector" in found and "matrix" not in found:
        model = checked(text.replace("use", "[x, t]"))
        return str(model.constraints[0].residual[1].type)
    return "matrix " + str(_matrix(text).type)


def _matrix(text: str) -> Typed:
    model = checked(text.replace("use", "x * trace(t * transpose(t))"))
    (product,) = (
        n
        for n in postorder(model.constraints[0].residual)
        if isinstance(n, Apply) and n.name == "trace"
    )
    inner = product.args[0]
    assert isinstance(inner, Apply)
    return inner.args[0]


@pytest.mark.parametrize(
    ("expression", "type_"),
    [
        ("x + 1", "real"),
        ("n / 2", "real"),
        ("x ^ 2", "real"),
        ("-v", "vec3"),
        ("2 * v", "vec3"),
        ("v / 2", "vec3"),
        ("v .* p", "vec3"),
        ("u ./ u", "vec2"),
        ("r * v", "vec3"),
        ("k * v", "vec2"),
        ("u * k", "vec3"),
        ("k'", "matrix mat<3,2>"),
        ("k * r", "matrix mat<2,3>"),
        ("m * k", "matrix mat<2,3>"),
        ("2 * r", "matrix mat3"),
        ("q * q", "quat"),
        ("q.conj()", "quat"),
        ("inverse(q)", "quat"),
        ("q.vec", "vec3"),
        ("q.rotate(v)", "vec3"),
        ("q.log()", "vec3"),
        ("exp(v)", "quat"),
        ("exp(x)", "real"),
        ("q.rotation_matrix()", "matrix mat3"),
        ("ea.rotation_matrix()", "matrix mat3"),
        ("th.rotation_matrix()", "matrix mat2"),
        ("rotation_matrix(v)", "matrix mat3"),
        ("rot.rotation_matrix()", "matrix mat3"),
        ("rot", "quat"),
        ("ea - ea.value", "vec3"),
        ("th - th.value", "real"),
        ("euler_angles(r)", "vec3"),
        ("q.euler_angles()", "vec3"),
        ("rotation_vector(r)", "vec3"),
        ("r.row(1)", "vec3"),
        ("k.col(2)", "vec2"),
        ("k.row(0)", "vec3"),
        ("k[1, 2]", "real"),
        ("w[3]", "real"),
        ("w.z", "real"),
        ("r.inverse()", "matrix mat3"),
        ("det(m)", "real"),
        ("trace(r)", "real"),
        ("skew(v)", "matrix mat3"),
        ("vee(r)", "vec3"),
        ("identity3", "matrix mat3"),
        ("identity2", "matrix mat2"),
        ("dot(v, p)", "real"),
        ("cross(v, p)", "vec3"),
        ("norm(u)", "real"),
        ("w.norm2()", "real"),
        ("unit(v)", "vec3"),
        ("perp(u)", "vec2"),
        ("starship(v, 3)", "vec3"),
        ("starship(x, 3)", "real"),
        ("sqrt(w)", "vec<4>"),
        ("min(x, n, 3)", "real"),
        ("clamp(x, 0, 1)", "real"),
        ("[x, v, u]", "vec<6>"),
        ("if on then v else p", "vec3"),
        ("if on then n else x", "real"),
        ("x < 1 and not on", "bool"),
        ("pi * e", "real"),
    ],
)
def test_types(expression: str, type_: str) -> None:
    assert type_of(expression) == type_


@pytest.mark.parametrize(
    ("expression", "code"),
    [
        ("v * p", "E0301"),
        ("v + 1", "E0301"),
        ("r * u", "E0301"),
        ("q * v", "E0301"),
        ("v < p", "E0301"),
        ("r ^ 2", "E0301"),
        ("v'", "E0301"),
        ("on + 1", "E0307"),
        ("not x", "E0307"),
        ("v.w", "E0204"),
        ("q.v", "E0204"),
        ("v[n]", "E0305"),
        ("w.value", "E0308"),
        ("det(k)", "E0302"),
        ("cross(u, u)", "E0302"),
        ("rotate(v, q)", "E0302"),
        ("atan2(x)", "E0303"),
        ("v.norm(1)", "E0303"),
        ("identity3(1)", "E0303"),
        ("sin", "E0304"),
        ("[]", "E0312"),
        ('"text"', "E0304"),
    ],
)
def test_wrong(expression: str, code: str) -> None:
    text = f"root Fit {{ {FIELDS}\n constraint c {{ let t = {expression}\n [x, t] }} }}"
    assert [c for c in codes(text) if c[0] == "E"] == [code]


def test_one_mistake_is_told_once() -> None:
    text = f"""
    root Fit {{ {FIELDS}
        constraint c {{
            let wrong = sine(x) + missing
            let more = wrong * v + rot
            [more, wrong.y, more.norm()]
        }}
    }}
    """
    assert [c for c in codes(text) if c[0] == "E"] == ["E0205", "E0201"]


def test_a_let_read_twice_is_one_node() -> None:
    model = checked("root Fit { param x: real\n constraint c { let s = sin(x)\n [s * s, s + 1] } }")
    sines = [n for n in postorder(model.constraints[0].residual) if isinstance(n, Apply)]
    assert [n.name for n in sines].count("sin") == 1


def test_functions_are_written_out() -> None:
    model = checked(
        """
        const HALF = 0.5
        fn lerp(a, b) = a + HALF * (b - a)
        fn far(a, b) = norm(lerp(a, b))
        root Fit { param p: vec3; v: vec3; constraint c { [far(p, v), lerp(p.x, 2)] } }
        """
    )
    names = {n.name for n in postorder(model.constraints[0].residual) if isinstance(n, Apply)}
    assert names == {"norm", "add", "mul", "sub"}


def test_conditionals_select() -> None:
    model = checked("root F { param x: real\n constraint c { if x < 0 then -x else x } }")
    (residual,) = model.constraints[0].residual
    assert isinstance(residual, Select)
    assert isinstance(residual.otherwise, Read)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 5), st.integers(1, 5), st.integers(1, 5), st.integers(1, 5))
def test_products_need_matching_inner_sizes(a: int, b: int, c: int, d: int) -> None:
    text = f"""
    root Fit {{
        param x: real
        l: mat<{a},{b}>
        r: mat<{c},{d}>
        constraint k {{ x * (l * r)[0, 0] }}
    }}
    """
    assert codes(text) == ([] if b == c else ["E0301"])
