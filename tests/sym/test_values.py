"""Scalars, vectors, matrices, quaternions and transforms; evaluation; hostile text."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from arael import sym
from arael.check.builtins import FUNCTIONS
from arael.diagnostics.records import AraelError
from arael.symbolic.scalars import SCALARS

ANGLES = st.lists(st.floats(-1.4, 1.4), min_size=3, max_size=3)


def test_every_function_of_the_language_is_there() -> None:
    assert {*SCALARS, *FUNCTIONS} <= set(dir(sym))
    arguments = sym.symbols("x y z")
    for name, scalar in SCALARS.items():
        value = getattr(sym, name)
        if scalar.arity:
            f = value(*arguments[: scalar.arity])
            call = f"{name}({', '.join('xyz'[: scalar.arity])})"
            assert f == sym.parse(sym.text(f)) == sym.parse(call)
            assert value.__doc__.startswith(scalar.value)
        else:
            assert sym.eval(value) == {"pi": math.pi, "e": math.e}.get(name, 2.0**-52)
    with pytest.raises(AttributeError, match="nothing"):
        sym.nothing  # noqa: B018


def test_importing_arael_does_not_import_sympy() -> None:
    script = (
        "import sys, arael; assert 'sym' in dir(arael); assert 'arael.sym' not in sys.modules;"
        "assert 'sympy' not in sys.modules; arael.sym.parse('x').diff('x')"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_eval_on_arrays_and_compiled() -> None:
    f = sym.parse("a * exp(-b * x) + c")
    x = np.linspace(0, 1, 5)
    expected = 2 * np.exp(-3 * x) + 1
    np.testing.assert_allclose(sym.eval(f, a=2, b=3, c=1, x=x), expected, rtol=1e-15)
    fast = sym.compiled(f, ["x", "a", sp.Symbol("b"), "c"])
    np.testing.assert_allclose(fast(x, 2, 3, 1), expected, rtol=1e-15)
    assert fast.names == ("x", "a", "b", "c")
    assert 0 < fast.operations < 6
    assert sym.eval(sp.Matrix([f, 1]), a=2, b=3, c=1, x=x).shape == (5, 2)
    assert sym.eval(sym.parse("[a, 2]"), {sp.Symbol("a"): 1}).tolist() == [1, 2]
    assert sym.eval(3) == 3.0
    with pytest.raises(AraelError, match="expected 4 values"):
        fast(1)


def test_conditions() -> None:
    f = sym.parse("if 0 < x and x <= y then x else -y")
    assert [sym.eval(f, x=a, y=b) for a, b in ((1, 2), (1, 0.5), (-1, 3))] == [1.0, -0.5, -3.0]
    assert sym.eval(sym.parse("x < y"), x=1, y=2) is True
    assert sym.eval(sym.parse("x < 0 or not x != y"), x=1, y=2) is False
    assert list(sym.eval(sym.parse("x < y"), x=np.array([1, 3]), y=2)) == [True, False]
    with pytest.raises(AraelError, match="E0307"):
        sym.parse("(x < y) + 1")


def test_missing_values_are_named() -> None:
    with pytest.raises(AraelError) as caught:
        sym.eval(sym.parse("gamma * x + y"), gama=1.0, x=2.0)
    (found,) = caught.value.diagnostics
    assert found.code == "E0650"
    assert "gamma" in found.message
    assert found.help == ("did you mean `gamma` by `gama`?",)
    with pytest.raises(AraelError, match="E0650"):
        sym.compiled(sym.parse("x + y"), ["x"])


def test_substitution_is_simultaneous() -> None:
    f = sym.parse("x + 2 * y")
    x, y = sym.symbols("x y")
    assert sym.subs(f, {"x": y, y: x}) == y + 2 * x
    assert sym.subs(f, x=1, y=x * x) == 1 + 2 * x**2
    assert sym.subs(f, q=3) == f
    assert sym.subs(sym.parse("x^2 * y").diff("x"), x=3) == 6 * y
    assert sym.subs(sym.parse("[sin(x + y), y]"), {x + y: 7}) == sp.Matrix([sp.sin(7), y])


def test_dotted_variables() -> None:
    f = sym.parse("L0.length * 2 + p.x")
    assert sym.free_vars(f) == ("L0.length", "p.x")
    assert sym.eval(f, {"L0.length": 2, "p.x": 1}) == 5.0
    assert sym.parse("p.x + p[1]", names={"p": [3, 4]}) == 7
    assert sym.parse("L0.length", names={"L0.length": 4}) == 4
    for wrong in ("2x", "", "a b", "x" * 300):
        with pytest.raises(AraelError, match="E0651"):
            sym.symbol(wrong)


def test_vectors_and_matrices() -> None:
    u = sym.vector("u", 3)
    names = {"u": u, "v": [1, 2, 3]}
    at = {"u.x": 0.5, "u.y": -1.0, "u.z": 2.0}
    w = np.array([0.5, -1.0, 2.0])

    def value(text: str) -> object:
        return sym.eval(sym.parse(text, names=names), at)

    assert value("dot(u, v)") == pytest.approx(w @ [1, 2, 3])
    np.testing.assert_allclose(value("u.cross(v)"), np.cross(w, [1, 2, 3]))
    np.testing.assert_allclose(value("2 * u - v / 2"), 2 * w - np.array([1, 2, 3]) / 2)
    assert value("norm(u)") == pytest.approx(np.linalg.norm(w))
    names["m"] = m = sp.Matrix([[u[0], 1, 0], [0, u[1], 2], [1, 0, u[2]]])
    a = sym.eval(m, at)
    assert a.shape == (3, 3)
    np.testing.assert_allclose(value("m * v"), a @ [1, 2, 3])
    np.testing.assert_allclose(value("m * m'"), a @ a.T)
    np.testing.assert_allclose(value("inverse(m)"), np.linalg.inv(a))
    assert value("m.det()") == pytest.approx(np.linalg.det(a))
    assert sym.parse("m[0, 0]", names=names) == u[0]
    assert sym.parse("m.row(1)", names=names) == sp.Matrix([0, u[1], 2])
    assert sym.parse("R.row(0)", names={"R": np.eye(2)}) == sp.Matrix([1, 0])
    assert sym.vector("s", 5)[4].name == "s._4"
    with pytest.raises(AraelError, match="E0301"):
        sym.parse("m * [1, 2]", names=names)


@settings(max_examples=20)
@given(ANGLES)
def test_rotations(angles: list[float]) -> None:
    from scipy.spatial.transform import Rotation

    r = sym.rotation_matrix(angles)
    oracle = Rotation.from_euler("xyz", angles).as_matrix()
    np.testing.assert_allclose(sym.eval(r), oracle, atol=1e-14)
    np.testing.assert_allclose(sym.eval(sym.euler_angles(r)), angles, atol=1e-12)
    q = sym.exp(angles)
    assert isinstance(q, sp.Quaternion)
    oracle = Rotation.from_rotvec(angles).as_matrix()
    np.testing.assert_allclose(sym.eval(sym.rotation_matrix(q)), oracle, atol=1e-14)
    np.testing.assert_allclose(sym.eval(sym.log(q)), angles, atol=1e-12)
    np.testing.assert_allclose(sym.eval(sym.rotate(q, [1, 2, 3])), oracle @ [1, 2, 3])
    unit = sym.parse("q * q.conj()", names={"q": q})
    np.testing.assert_allclose(sym.eval(unit), [1, 0, 0, 0], atol=1e-15)


def test_quaternions_have_parts() -> None:
    q = sym.quaternion("q")
    assert sym.text(q) == "quat(q.w, q.x, q.y, q.z)"
    assert sym.parse("q.w + q.vec.y", names={"q": q}) == q.a + q.c
    a, b = sym.quaternion("a"), sym.quaternion("b")
    assert sym.parse("a * b", names={"a": a, "b": b}) == a * b, "as SymPy multiplies them"
    turn = sym.exp([0.1, 0.2, 0.3])
    np.testing.assert_allclose(sym.eval(sym.quaternion(sym.mat3(turn))), sym.eval(turn), rtol=1e-14)


def test_rows_of_rows_and_slices() -> None:
    m = sym.parse("[[1, x], [3, 4]]")
    assert m == sp.Matrix([[1, sp.Symbol("x")], [3, 4]])
    assert sym.parse("M[0, :]", names={"M": m}) == sp.Matrix([1, sp.Symbol("x")])
    assert sym.parse("M[:, 1:2]", names={"M": m}) == sp.Matrix([sp.Symbol("x"), 4])
    assert sym.parse("[1, 2, 3][1:]") == sp.Matrix([2, 3])
    with pytest.raises(AraelError, match="E0312"):
        sym.parse("[[1, 2], [3]]")


@settings(max_examples=10)
@given(ANGLES, ANGLES)
def test_transforms(phi: list[float], t: list[float]) -> None:
    from scipy.spatial.transform import Rotation

    q = sym.exp(phi)
    names = {"T": sym.transform(t, q), "S": sym.similarity(t, q, 2.0)}

    def value(text: str) -> object:
        return sym.eval(sym.parse(text, names=names))

    r = Rotation.from_rotvec(phi).as_matrix()
    oracle = np.block([[r, np.array([t]).T], [np.zeros((1, 3)), np.ones((1, 1))]])
    np.testing.assert_allclose(value("T.matrix()"), oracle, atol=1e-14)
    np.testing.assert_allclose(value("T * [1, 2, 3]"), r @ [1, 2, 3] + t, atol=1e-13)
    np.testing.assert_allclose(value("(T.inverse() * (T * T)).matrix()"), oracle, atol=1e-13)
    np.testing.assert_allclose(value("exp(T.log()).matrix()"), oracle, atol=1e-12)
    np.testing.assert_allclose(value("S * [1, 2, 3]"), 2 * r @ [1, 2, 3] + t, atol=1e-13)
    assert sym.parse("S.scale", names=names) == 2
    assert isinstance(names["T"], sym.Transform)
    for wrong in ("T + T", "-T"):
        with pytest.raises(AraelError, match="E0301"):
            sym.parse(wrong, names=names)


def test_parse_gives_values_of_every_kind() -> None:
    assert sym.parse("[x, y]").shape == (2, 1)
    assert sym.parse("skew([x, y, z])'").shape == (3, 3)
    assert sym.parse("identity3()") == sp.eye(3) == sym.identity3()
    assert sym.eval(sym.parse("min(x, 2, y)"), x=3, y=1) == 1.0
    assert sym.parse("true and x < 1") == (sp.Symbol("x") < 1)
    assert sym.parse("v[i]", names={"v": [5, 6], "i": 1}) == 6
    with pytest.raises(AraelError, match="`parse` reads formulas"):
        sym.text("x")


@pytest.mark.sweep(slow=("text10",))
@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "x.__class__",
        "().__class__.__bases__",
        "lambda: 1",
        'open("f")',
        "eval(1)",
        "x" * 500,
        "(" * 5000 + ")" * 5000,
        "-" * 100_000 + "1",
        "+".join(["x"] * 60_000),
        "+".join(f"x{i}" for i in range(20_000)),
        "sin(" * 60 + "x" + ")" * 60,
        "1e999",
        "x\u202e+1",
        "[" + "1," * 60_000 + "1]",
        "f" * 99 + "(1)",
    ],
)
def test_hostile_text_is_refused_or_harmless(text: str) -> None:
    try:
        value = sym.parse(text)
    except AraelError:
        return
    assert value.is_Symbol or text.startswith("sin")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: sym.parse(3), "a formula is text, found int"),  # type: ignore[arg-type]
        (lambda: sym.vector("p", -1), "expected a length from 1 to 4096, found -1"),
        (lambda: sym.vector("p", 10**9), "expected a length from 1 to 4096, found 1000000000"),
    ],
)
def test_arguments_of_another_kind_are_reported(call: Callable[[], object], text: str) -> None:
    with pytest.raises(AraelError, match="E0652") as raised:
        call()
    assert text in str(raised.value)
