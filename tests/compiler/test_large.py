"""Constraints too large for one function: parts, products by loops, wide rows, many residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.compiler import compiler
from arael.compiler.emit.large import jacobian_runs
from arael.compiler.parts import base, cut
from arael.diagnostics.records import AraelError, Findings, Source
from arael.loading import load
from arael.model import Model
from arael.runtime.assembly.compiled import shared_rows
from arael.runtime.machine.tape import PRIMITIVES, Tape
from arael.runtime.parallel.frames import frame_of
from arael.runtime.problem import Problem
from arael.syntax.parser import parse
from tests.compiler.test_emit import emitted
from tests.compiler.test_kernels import (
    check_against_differences,
    check_against_oracle,
    problems,
)
from tests.oracle import evaluate

# Two rows of one entity, rows that many instances share, scalars of the root, a loss, a guard over
# parameters, residuals that are data, parameters and constants.
TEXT = """
struct Node { param p: vec3; param q: quaternion }
struct Seen { x: vec3; w: real }
struct Edge {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    k: real
    seen: list of Sight
    constraint ahead when dot(a.q.rotate([1, 0, 0]), b.p - a.p) > -0.5 and k > 0.2
        loss cauchy(2) { a.q.conj().rotate(b.p - a.p) * (k * root.s) }
    constraint plain { [b.p.x, 3, k, a.p.y - 2 * b.p.y, -a.p.z, root.t.y * sin(b.p.z)] }
}
struct Sight {
    n: ref Node in root.nodes
    z: vec3
    constraint near { n.p .* root.t - z }
    constraint point { n.q.conj().rotate(parent.b.p - n.p) .* root.t - z }
}
root R { param s: real; param t: vec3; nodes: list of Node; edges: list of Edge }
"""


def filled(model: Model) -> Model:
    """Give a model of `TEXT` nodes and edges: more than a block of lanes of each kind."""
    rng = np.random.default_rng(0)
    model.s.value = 0.8
    model.t.value[...] = [1.1, 0.7, -0.4]
    q = rng.normal(size=(5, 4))
    model.nodes.extend(p=rng.normal(size=(5, 3)), q=q / np.linalg.norm(q, axis=1, keepdims=True))
    for i in range(9):
        edge = model.edges.append(
            a=model.nodes[i % 5], b=model.nodes[(2 * i + 1) % 5], k=rng.uniform(0, 2)
        )
        for j in range(20):
            edge.seen.append(n=model.nodes[(i + j) % 5], z=rng.normal(size=3))
    return model


def large_everywhere(monkeypatch: pytest.MonkeyPatch, part: int) -> None:
    """Let every constraint be compiled in parts of at most so many operations."""
    monkeypatch.setattr("arael.compiler.products.UNROLLED_TARGETS", 0)
    monkeypatch.setattr("arael.compiler.parts.PART", part)


def written(folder: Path, text: str) -> Path:
    path = folder / "model.arael"
    path.write_text(text)
    return path


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("precision", "part"), [("f64", 9), ("f32", 31)])
def test_kernels_in_parts_against_interpreter_and_differences(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, precision: str, part: int
) -> None:
    large_everywhere(monkeypatch, part)
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    if precision == "f32":
        monkeypatch.setenv("CFLAGS", "-O1")  # the optimiser has its turn in f64
    loaded = load(written(tmp_path, TEXT), precision=precision)  # type: ignore[arg-type]
    layout = loaded.compiled.layout  # type: ignore[attr-defined]
    assert all(group.workspace for group in layout.groups)
    assert any(group.moving_guard is not None for group in layout.groups)
    assert all(group.lead for group in layout.groups)
    model = filled(loaded())
    (near,) = (k for k, group in enumerate(layout.groups) if group.label == "Sight.near")
    assert len(layout.groups[near].lead) == 2  # the node and the root
    placed = Problem(layout, model._store).structure.placements[near].rows
    lanes = 8 if precision == "f64" else 16
    node = np.sort(placed[:, layout.groups[near].lead[0]])
    blocks = node[: len(node) // lanes * lanes].reshape(-1, 1, lanes)
    shared = shared_rows(np.ascontiguousarray(blocks), [0], len(node))
    assert 0 < shared.sum() < len(shared), "blocks of lanes that share the node, and others"
    check_against_oracle(model, 1e-12 if precision == "f64" else 5e-6)
    if precision == "f64":
        check_against_differences(model)


def test_a_large_constraint_calls_native_functions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    large_everywhere(monkeypatch, 2)
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    text = (
        "extern fn double_of(x) derivs [2]\nstruct D { x: real }\n"
        "root R { param a: real; data: list of D\n"
        "    fit data as e { sin(double_of(a * e.x)) + double_of(e.x) }\n}\n"
    )
    with pytest.warns(Warning, match="Python function"):
        model = load(written(tmp_path, text), functions={"double_of": lambda x: 2 * x})()
    model.a.value = 0.3
    model.data.extend(x=np.linspace(-1, 1, 11))
    expected = np.sin(2 * 0.3 * model.data.x) + 2 * model.data.x
    assert model.cost() == pytest.approx(float(expected @ expected), rel=1e-12)


@pytest.mark.slow
def test_a_row_of_many_parameters(tmp_path: Path) -> None:
    """J'J of a wide row takes no statement per entry."""
    n = 40
    text = (
        f"struct S {{ x: vec<{n}>; y: real }}\nroot R {{ param c: vec<{n}>; data: list of S\n"
        "    fit data as s { dot(c, s.x) - s.y }\n}\n"
    )
    model = load(written(tmp_path, text))()
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(51, n)), rng.normal(size=51)
    model.data.extend(x=x, y=y)
    model.c.value = np.zeros(n)
    compiled, _ = problems(model)
    np.testing.assert_allclose(compiled.gradient(), -2 * x.T @ y, rtol=1e-11)
    np.testing.assert_allclose(compiled.hessian(), 2 * x.T @ x, rtol=1e-11, atol=1e-12)
    model.solve()
    np.testing.assert_allclose(model.c.value, np.linalg.lstsq(x, y, rcond=None)[0], rtol=1e-7)


@pytest.mark.slow
def test_a_constraint_of_many_residuals(tmp_path: Path) -> None:
    """340 residuals were a RecursionError in Cython."""
    n = 340
    text = f"root R {{ param p: vec<{n}>; z: vec<{n}>\n    constraint c {{ p - z }}\n}}\n"
    z = np.random.default_rng(1).normal(size=n)
    model = load(written(tmp_path, text))(z=z, p=np.zeros(n))
    assert model.cost() == pytest.approx(float(z @ z), rel=1e-12)
    model.solve()
    np.testing.assert_allclose(model.p.value, z, rtol=0, atol=1e-12)


def drawn_tape(rng: np.random.Generator, nodes: int) -> Tape:
    """A random program with inputs, constants, negations, and results of every kind."""
    ops, args = ["input"] * 3 + ["const"], [(0,), (1,), (2,), (0,)]
    for at in range(4, nodes):
        op = str(rng.choice(["add", "mul", "sub", "neg", "sin"]))
        ops.append(op)
        arity = PRIMITIVES[op][0]
        # Mostly near operands, some from far back.
        far = [int(rng.integers(0, at)) if rng.random() < 0.2 else at - 1 for _ in range(arity)]
        args.append(tuple(far))
    outputs = [*rng.integers(0, nodes, size=8), 0, 3, nodes - 1, nodes - 1]
    return Tape(tuple(ops), tuple(args), (0.5,), tuple(int(o) for o in outputs))


@pytest.mark.parametrize("seed", range(20))
def test_parts_compute_what_the_program_computes(seed: int) -> None:
    """Run the parts on one workspace, in which columns are used again."""
    rng = np.random.default_rng(seed)
    tape = drawn_tape(rng, int(rng.integers(6, 80)))
    leading = 3
    found = cut(tape, leading, 3, limit=int(rng.integers(1, 9)))
    inputs = rng.normal(size=3)
    work = np.full(found.width, np.nan)

    def value(node: int, own: dict[int, float]) -> float:
        op, operands = tape.ops[node], tape.args[node]
        if op == "neg":
            return -value(operands[0], own)
        if op in ("input", "const"):
            return float(inputs[operands[0]]) if op == "input" else tape.constants[operands[0]]
        return own[node] if node in own else float(work[found.columns[node][0]])

    expected = [float(evaluate(tape, list(inputs))[o]) for o in tape.outputs]
    for number, part in enumerate(found.parts):
        own: dict[int, float] = {}
        for node in part.nodes:
            function = PRIMITIVES[tape.ops[node]][1]
            assert function is not None
            own[node] = float(function(*(np.float64(value(a, own)) for a in tape.args[node])))
            for column in found.columns.get(node, ()):
                work[column] = own[node]
        for column, node in part.stores:
            work[column] = value(node, own)
        if number + 1 == found.leading:
            np.testing.assert_array_equal(work[3 : 3 + leading], expected[:leading])
    np.testing.assert_array_equal(work[3 : 3 + len(expected)], expected)


def test_columns_of_values_are_used_again() -> None:
    """A chain of a thousand operations in parts of ten hands on one value at a time."""
    ops = ("input", *["sin"] * 1000)
    tape = Tape(ops, tuple((max(k - 1, 0),) for k in range(1001)), (), (1000,))
    found = cut(tape, 1, 0, limit=10)
    assert len(found.parts) == 100
    assert found.width <= 1 + 2


def test_base_looks_through_negations() -> None:
    tape = Tape(("input", "neg", "neg"), ((0,), (0,), (1,)), (), (2,))
    assert base(tape, 2) == 0


def test_runs_of_the_jacobian() -> None:
    jacobian = [(0, 0, 0), (0, 0, 1), (0, 1, 2), (2, 0, 3), (2, 0, 5)]
    runs, ends = jacobian_runs(jacobian, 4)
    assert runs == [(0, 0, 0, 2), (1, 2, 2, 1), (0, 3, 3, 1), (0, 5, 4, 1)]
    assert ends == [0, 2, 2, 4, 4]


def test_results_of_one_formula_are_one_loop() -> None:
    """Of ``p - z`` twenty results, then their derivatives, each the constant 1."""
    n = 20
    ops = ("input",) * (2 * n) + ("sub",) * n + ("const",)
    args = (
        *((k,) for k in range(2 * n)),
        *((k, n + k) for k in range(n)),
        (0,),
    )
    outputs = (*range(2 * n, 3 * n), *[3 * n] * n)
    tape = Tape(ops, args, (1.0,), outputs)
    found = cut(tape, n, 0)
    assert [(r.first, r.count, r.steps) for p in found.parts for r in p.runs] == [
        (0, n, (1, 1)),
        (n, n, ()),
    ]
    assert not any(part.nodes or part.stores for part in found.parts)
    assert found.leading == 1


@pytest.mark.slow
def test_long_vectors_make_short_source() -> None:
    """The same few lines for 200 and for 1000 parameters and residuals."""
    text = "root R {{ param p: vec<{n}>; z: vec<{n}>\n    constraint c {{ p .* p - z }}\n}}\n"
    lengths = []
    for n in (200, 1000):
        code = [line for line in emitted(text.format(n=n)).splitlines() if "# " not in line]
        lengths.append(len(code))
    assert lengths[0] == lengths[1] < 200


@pytest.mark.slow
def test_products_without_end_are_refused() -> None:
    """Four vectors of a thousand scalars in one residual: eight million products."""
    params = "; ".join(f"param p{k}: vec<1000>" for k in range(4))
    total = " + ".join(f"norm2(p{k})" for k in range(4))
    with pytest.raises(AraelError, match="takes 8002000 multiplications") as caught:
        emitted(f"root R {{ {params}\n    constraint c {{ {total} }}\n}}\n")
    assert caught.value.diagnostics[0].code == "E0620"


def test_stack_of_a_large_kernel_grows_with_its_workspace() -> None:
    """J'J is formed in place: 200 parameters take no stack for 20 000 products."""
    text = (
        "struct S { x: vec<200>; y: real }\nroot R { param c: vec<200>; data: list of S\n"
        "    fit data as s { dot(c, s.x) - s.y }\n}\n"
    )
    model = compiler.types(parse(Source("model.arael", text)), Findings())
    layout = compiler.derive(model, "model.arael").layout
    (group,) = layout.groups
    columns = 200 + 1 + 200  # parameters, residual, Jacobian; nothing is carried far
    assert columns <= group.workspace <= columns + 250
    assert 64 * (group.workspace + 200) < frame_of(group, layout.entities) < 400_000
