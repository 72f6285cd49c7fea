"""Untrusted models: for any text the stages end soon, with source or diagnostics."""

import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from arael.compiler import compiler
from arael.diagnostics.records import AraelError, Findings, Source
from arael.loading import standard_models
from arael.syntax.parser import parse

SECONDS = 60.0
"""Of processor time at most. What grows exponentially takes years; the slowest model below takes 10
on a slow machine that is idle."""


def stages(text: str) -> str:
    """Run every stage up to source; the code of the first error, or the empty string."""
    try:
        model = compiler.types(parse(Source("m.arael", text)), Findings())
        compiler.emit(compiler.derive(model, "m.arael"), "0")
    except AraelError as error:
        assert error.diagnostics
        assert all(d.span or d.origin for d in error.diagnostics)
        return error.diagnostics[0].code
    return ""


DOUBLING = "fn f0(x) = sin(x) + x * x\n" + "".join(
    f"fn f{i}(x) = f{i - 1}(f{i - 1}(x)) + x\n" for i in range(1, 30)
)
DOUBLED_LETS = "let x0 = a\n" + "".join(
    f"let x{i} = x{i - 1} * x{i - 1} + sin(x{i - 1})\n" for i in range(1, 3000)
)
STRUCT_TREE = "".join(f"struct S{i} {{ a: S{i + 1}; b: S{i + 1} }}\n" for i in range(40))
LIST_TREE = "".join(
    f"struct S{i} {{ a: list of S{i + 1}; b: list of S{i + 1} }}\n" for i in range(40)
)

BOMBS = {
    "functions that double": (
        DOUBLING + "root R { param a: real\n constraint c { f29(a) }\n}",
        "E0606",
    ),
    "lets that double": (  # they are shared, so that nothing grows
        f"root R {{ param a: real\n constraint c {{\n{DOUBLED_LETS} x2999 }}\n}}",
        "",
    ),
    "a long sum": (
        "root R { param a: real\n constraint c { "
        + " + ".join(f"sin(a * {i})" for i in range(30000))
        + " }\n}",
        "E0106",
    ),
    "products of large matrices": (
        "root R { param a: vec<64>\n m: mat<64,64>\n constraint c { m * (m * (m * a)) }\n}",
        "E0620",
    ),
    "a tower of powers": (
        "root R { param a: real\n constraint c { " + "(" * 50 + "a" + ")^7" * 50 + " }\n}",
        "",
    ),
    "a tree of structs": (
        STRUCT_TREE
        + "struct S40 { x: real }\nroot R { param p: real; s: S0\n constraint c { p }\n}",
        "E0412",
    ),
    "a tree of lists": (
        LIST_TREE
        + "struct S40 { x: real }\nroot R { param p: real; s: list of S0\n constraint c { p }\n}",
        "E0412",
    ),
    "thousands of constraints": (
        "root R { param p: real\n"
        + "".join(f"constraint c{i} {{ sin(p * {i}) }}\n" for i in range(5000))
        + "}",
        "E0620",
    ),
    "as much source as is made at most": (
        "root R { param p: real\n"
        + "".join(f"constraint c{i} {{ sin(p * {i}) }}\n" for i in range(900))
        + "}",
        "E0620",
    ),
}


@pytest.mark.sweep(
    slow=("lets that double", "thousands of constraints", "as much source as is made at most")
)
@pytest.mark.parametrize("name", BOMBS)
def test_models_that_explode_end_in_a_diagnostic(name: str) -> None:
    text, code = BOMBS[name]
    began = time.process_time()
    assert stages(text) == code
    assert time.process_time() - began < SECONDS


MODELS = [path.read_text() for path in standard_models().values()]
PIECES = st.sampled_from(
    ["{", "}", "(", ")", "[", "]", "'", ".", ",", ":", ";", "\n", "#", '"', "\\", "\x00", "é", "|",
     "param ", "ref ", "list of ", "root", "parent", "let x = ", "1e999", "-", "^", "^0.5", "/0",
     "vec3", "mat<9,9>", "if a then ", " else ", "when ", "in ..", "pos", "gamma", "solve {", "?"]
)  # fmt: skip


@pytest.mark.slow
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    text=st.sampled_from(MODELS),
    edits=st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 12), st.one_of(PIECES, st.text(max_size=4))),
        min_size=1,
        max_size=4,
    ),
)
def test_mutated_models_never_crash(text: str, edits: list[tuple[float, int, str]]) -> None:
    for where, removed, added in edits:
        at = int(where * len(text))
        text = text[:at] + added + text[at + removed :]
    began = time.process_time()
    stages(text)
    assert time.process_time() - began < SECONDS
