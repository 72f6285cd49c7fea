"""Hostile models end in a diagnostic, in bounded time and memory, and without a traceback."""

from __future__ import annotations

import contextlib
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from arael.check.check import check
from arael.check.report import MAX_ERRORS, MAX_WARNINGS
from arael.cli.outline import outline
from arael.compiler.compiler import derive, emit
from arael.diagnostics.records import AraelError, Findings, Source
from arael.syntax.fmt import format_source
from arael.syntax.parser import parse
from tests.check.models import MODELS, codes, diagnostics


def chain(template: str, n: int) -> str:
    return "\n".join(template.format(i=i, j=i - 1) for i in range(1, n))


FUNCTIONS_DEEP = (
    "fn f0(x) = x\n" + chain("fn f{i}(x) = 1 + f{j}(x)", 300) + "\n"
    "root R { param a: real\n constraint c { f299(a) } }"
)
FUNCTIONS_WIDE = (
    "fn f0(x) = [x, x]\n" + chain("fn f{i}(x) = [f{j}(x), f{j}(2 * x)]", 25) + "\n"
    "root R { param a: real\n constraint c { f24(a) } }"
)
FUNCTIONS_DOUBLING = (
    "fn f0(x) = x * x + 1\n" + chain("fn f{i}(x) = f{j}(sin(x)) * f{j}(x / 2)", 14) + "\n"
    "root R { param a: real\n constraint c { f13(a) } }"
)
FUNCTIONS_DOUBLING_TWICE = (
    "fn f0(x) derivs [2 * x] = x * x + 1\n"
    + chain("fn f{i}(x) derivs [f{j}(cos(x)) + f{j}(x)] = f{j}(sin(x)) * f{j}(x / 2)", 14)
    + "\nroot R { param a: real\n constraint c { f13(a) } }"
)
MATRICES = "root R { param a: real; m: mat<64,64>\n constraint c { a * (m * m * m)[0, 0] } }"
BY_VALUE = (
    "struct S0 { param x: real }\n"
    + chain("struct S{i} {{ a: S{j}; b: S{j}; c: S{j}; d: S{j} }}", 30)
    + "\nroot R { s: S29; param a: real\n constraint c { a } }"
)
COLLECTIONS = (
    "struct S0 { x: real }\n"
    + chain("struct S{i} {{ a: list of S{j}; b: list of S{j} }}", 30)
    + "\nroot R { s: list of S29; param a: real\n constraint c { a } }"
)
REFS = (
    "struct T { param x: real; constraint c { x } }\nstruct G { ts: list of T }\nstruct L {\n"
    + "r0: ref T in root.ts\n"
    + chain("r{i}: ref T in r{j}.parent.ts", 60)
    + "\n}\nroot R { ts: list of T; ls: list of L }"
)
CONSTANTS = "const c0 = 1\n" + "\n".join(f"const c{i} = c{i + 1}" for i in range(1, 300))
CONSTANTS += "\nconst c300 = 1\nroot R { param a: real\n constraint c { a * c1 } }"


@pytest.mark.sweep(slow=("functions wide", "by value"))
@pytest.mark.parametrize(
    ("text", "code"),
    [
        pytest.param(FUNCTIONS_DEEP, "E0607", id="functions deep"),
        pytest.param(FUNCTIONS_WIDE, "E0606", id="functions wide"),
        pytest.param(FUNCTIONS_DOUBLING, "E0606", id="functions doubling"),
        pytest.param(FUNCTIONS_DOUBLING_TWICE, "E0606", id="functions doubling, with derivatives"),
        pytest.param(MATRICES, "E0606", id="matrices"),
        pytest.param(BY_VALUE, "E0412", id="by value"),
        pytest.param(COLLECTIONS, "E0412", id="collections"),
        pytest.param(REFS, "E0406", id="refs"),
        pytest.param(CONSTANTS, "E0213", id="constants"),
    ],
)
def test_explosions_are_refused(text: str, code: str) -> None:
    start = time.process_time()
    assert code in codes(text)
    assert time.process_time() - start < 20


def test_lets_that_double_are_cheap_because_they_are_shared() -> None:
    text = (
        "root R { param a: real\n constraint c {\n let x0 = a\n"
        + chain("let x{i} = x{j} + x{j}", 200)
        + "\n x199 } }"
    )
    assert codes(text) == []


LONG_SUM = "root R { param a: real\n constraint c { a + " + " + ".join(
    f"{i} * a^2" for i in range(1, 700)
) + " } }"  # fmt: skip
LONG_PRODUCT = "root R { param a: vec2\n constraint c { " + " * ".join(["a.x"] * 700) + " } }"
DATA_SUM = (
    "root R : f32 { param a: real; d: real\n constraint c { a * (d" + " + d * a^0 - d^2" * 400
)
DATA_SUM += ") } }"
LETS_DEEP = (
    "root R { param a: real\n constraint c {\n let x0 = a\n"
    + chain("let x{i} = sin(x{j})", 700)
    + "\n x699 } }"
)
TRANSFORMS_DEEP = (
    "root R { param a: transform\n constraint c {\n let x0 = a\n"
    + chain("let x{i} = x{j}.inverse() * a", 30)
    + "\n x29.log() } }"
)


@pytest.mark.sweep(slow=("transforms", "sum of data", "product"))
@pytest.mark.parametrize(
    "text",
    [
        pytest.param(LONG_SUM, id="sum"),
        pytest.param(LONG_PRODUCT, id="product"),
        pytest.param(DATA_SUM, id="sum of data"),
        pytest.param(LETS_DEEP, id="lets"),
        pytest.param(TRANSFORMS_DEEP, id="transforms"),
    ],
)
def test_long_chains_compile(text: str) -> None:
    """No stage before the kernels recurses over a chain: its length is bounded by operations."""
    model = check(parse(Source("model.arael", text)), findings=Findings())
    program = derive(model, "model.arael")
    assert len(emit(program, "hash")) > 5_000
    assert format_source(Source("model.arael", text))
    assert outline(model)


def test_errors_and_warnings_are_bounded_in_number() -> None:
    wrong = "root R { param a: real\n" + chain("constraint c{i} {{ missing{i} }}", 400) + "\n}"
    assert len(diagnostics(wrong)) == MAX_ERRORS
    unused = chain("struct S{i} {{ x: real }}", 400)
    found = diagnostics(unused + "\nroot R { param a: real\n constraint c { a } }")
    assert len(found) == MAX_WARNINGS
    assert found[-1].notes == ("further warnings are not shown",)


WORDS = """
pos ea info gps gamma root parent self value pose feature prev real vec3 mat3 Pose Path when if then
else and or not list of ref in param let constraint struct 1 0.5 [ ] ( ) { } . , + - * / ' ^ < > = :
? .* sin norm rotation_matrix transpose
"""


@pytest.mark.slow
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_mutated_models_never_crash(data: st.DataObject) -> None:
    text = (MODELS / "slam.arael").read_text()
    tokens = text.split(" ")
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(tokens) - 1))
        tokens[at] = data.draw(st.sampled_from(WORDS.split())) if data.draw(st.booleans()) else ""
    with contextlib.suppress(AraelError):
        diagnostics(" ".join(tokens))


def test_refs_that_double_at_each_step_are_refused() -> None:
    text = (
        "struct T {\nparam x: real\nq0: ref T in root.ts\n"
        + chain("q{i}: ref T in q{j}.q{j}.parent.ts", 40)
        + "\nconstraint c { x } }\nroot R { ts: list of T }"
    )
    assert set(codes(text)) == {"E0406"}
