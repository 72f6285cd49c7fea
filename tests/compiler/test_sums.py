"""Lists of refs and sums: kernels, machine and differences, against the same model written out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.cli.outline import outline, programs
from arael.compiler import compiler
from arael.diagnostics.records import AraelError, Findings, Source
from arael.loading import load
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

SPLINE = """
const N = 3
struct Knot { param c: vec2 }
struct Sample {
    u: real
    seen: vec2
    knots: [ref Knot in root.knots; 4]
    constraint near {
        let v = 1 - u
        let B = [v^3, 3 * u^3 - 6 * u^2 + 4, 3 * v^3 - 6 * v^2 + 4, u^3] / 6
        sum(i, k in self.knots) { B[i] * k.c } - seen
    }
    constraint bend { 0.1 * (knots[0].c - 2 * knots[N - 2].c + knots[2].c) .* knots[N].c }
}
root Spline : PRECISION {
    knots: list of Knot
    samples: list of Sample
}
"""
WRITTEN_OUT = (
    SPLINE.replace(
        "knots: [ref Knot in root.knots; 4]",
        "; ".join(f"k{i}: ref Knot in root.knots" for i in range(4)),
    )
    .replace(
        "sum(i, k in self.knots) { B[i] * k.c }",
        " + ".join(f"B[{i}] * k{i}.c" for i in range(4)),
    )
    .replace("knots[0]", "k0")
    .replace("knots[N - 2]", "k1")
    .replace("knots[2]", "k2")
    .replace("knots[N]", "k3")
)  # fmt: skip
BASE = np.array([[0, 1, 2, 3], [2, 3, 4, 5], [1, 2, 3, 4], [3, 3, 1, 3], [5, 5, 5, 5]])

ROWS = """
struct Item {
    a: real
    b: vec2
    extra: real?
    beacon: ref Beacon in root.beacons
    subs: list of Sub
}
struct Sub { z: real }
struct Beacon { w: real = 2 }
struct Row {
    param p: real = 0.3
    param v: vec2 = [1, 2]
    k: real = 1.5
    items: list of Item
    prior p ~ normal(1, 10)
    prior v ~ normal(1, 10)
    constraint c when sum(x in items) { 1 } > 0.5 {
        let s = sum(x in self.items) {
            let d = x.a * p - sin(x.a * k) * root.g
            d^2 * x.beacon.w + (if x.extra then x.extra else p)
        }
        [s, sum(x in items) { x.b .* v / (x.a * p) },
         sin(sum(x in items) { sum(y in x.subs) { y.z } * p })]
    }
}
root Rows : PRECISION { param g: real = 0.7; beacons: list of Beacon; rows: list of Row }
"""


def model_of(folder: Path, text: str, precision: str = "f64", **options: Any) -> Model:
    path = folder / "m.arael"
    path.write_text(text.replace("PRECISION", precision), encoding="utf-8")
    return load(path, **options)()


def fill_spline(model: Model, written_out: bool = False) -> Model:
    random = np.random.default_rng(1)
    model.knots.extend(c=random.normal(size=(6, 2)))
    refs = {f"k{i}": BASE[:, i] for i in range(4)} if written_out else {"knots": BASE}
    model.samples.extend(u=random.uniform(size=5), seen=random.normal(size=(5, 2)), **refs)
    return model


def fill_rows(model: Model, counts: tuple[int, ...] = (3, 0, 5, 1)) -> Model:
    random = np.random.default_rng(2)
    model.beacons.extend(w=[1.0, 2.0, 3.0])
    for n in counts:
        items = [
            {
                "a": random.uniform(0.5, 2),
                "b": random.normal(size=2),
                "beacon": int(random.integers(3)),
                "extra": float(random.normal()) if i % 2 else None,
                "subs": [{"z": 1.0 + j} for j in range(i)],
            }
            for i in range(n)
        ]
        model.rows.append(p=random.uniform(0.5, 1), items=items)
    return model


def by_hand(model: Any) -> np.ndarray:
    """Residuals of the rows that have items."""
    found = []
    for row in model.rows:
        p, v, g = row.p.value, row.v.value, model.g.value
        if not len(row.items):
            continue
        s = 0.0
        for x in row.items:
            d = x.a * p - np.sin(x.a * row.k) * g
            s += d**2 * x.beacon.w + (p if x.extra is None else x.extra)
        quotients = sum(x.b * v / (x.a * p) for x in row.items)
        last = np.sin(sum(y.z for x in row.items for y in x.subs) * p)
        found.append([s, *quotients, last])
    return np.array(found)


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-12), ("f32", 2e-5)])
def test_kernels_and_machine_of_a_spline(precision: str, tolerance: float, tmp_path: Path) -> None:
    model = fill_spline(model_of(tmp_path, SPLINE, precision))
    check_against_oracle(model, tolerance)
    if precision == "f64":
        check_against_differences(model)


def test_a_list_has_the_derivatives_and_blocks_of_four_refs(tmp_path: Path) -> None:
    one = fill_spline(model_of(tmp_path, SPLINE, interpret=True))
    other = fill_spline(model_of(tmp_path, WRITTEN_OUT, interpret=True), written_out=True)
    np.testing.assert_array_equal(one.gradient(), other.gradient())
    np.testing.assert_array_equal(one.hessian(), other.hessian())
    block = one.hessian_block(one.samples[1].knots[0], one.samples[1].knots[3])
    assert np.abs(block).max() > 1e-4
    assert one.solve().cost == other.solve().cost
    np.testing.assert_array_equal(one.knots.c.value, other.knots.c.value)


@pytest.mark.parametrize("interpret", [True, False])
def test_one_entity_in_all_places_of_a_list(interpret: bool, tmp_path: Path) -> None:
    model = model_of(tmp_path, SPLINE, interpret=interpret)
    model.knots.append(c=[1, -2])
    model.samples.append(u=0.3, seen=[0, 0], knots=[0, 0, 0, 0])
    # B adds up to one, and the second differences vanish.
    np.testing.assert_allclose(model.gradient(), [2, -4], atol=1e-14)
    np.testing.assert_allclose(model.hessian(), 2 * np.eye(2), atol=1e-14)
    assert model.solve().cost < 1e-20


def test_named_blocks_of_elements(tmp_path: Path) -> None:
    text = """
struct Knot { param c: vec2; hk: block Knot }
struct Pair {
    knots: [ref Knot in root.knots; 2]
    hb: block (knots[1], knots[0])
    constraint c into hb { sum(i, k in knots) { (i + 2) * k.c } }
}
root R { knots: list of Knot; pairs: list of Pair }
"""
    model = model_of(tmp_path, text, interpret=True)
    model.knots.extend(c=[[1, 2], [3, 4]])
    model.pairs.append(knots=[0, 1])
    np.testing.assert_allclose(model.pairs[0].hb, 12 * np.eye(2))
    np.testing.assert_allclose(model.knots.hk, [8 * np.eye(2), 18 * np.eye(2)])


def test_sums_over_refs_in_brackets_and_over_vectors(tmp_path: Path) -> None:
    text = """
struct P { param x: vec2; w: vec3 = [1, 2, 4] }
struct Pair {
    a: ref P in root.ps
    b: ref P in root.ps
    both: [ref P in root.ps; 2]
    constraint c {
        let others = 2
        let all = sum(p in [a, b, parent.ps[0]]) { p.x }
        [all, sum(w in a.w) { w^2 } * a.x.x,
         sum(i, p in [a, b]) { let s = sum(j, q in both) { (1 + others * i + j) * q.x }
             s .* p.x }]
    }
}
root R { ps: list of P; pairs: list of Pair }
""".replace(", parent.ps[0]", "")
    model = model_of(tmp_path, text, interpret=True)
    model.ps.extend(x=[[1, 2], [3, 5], [7, 11]])
    model.pairs.append(a=0, b=1, both=[1, 2])
    x = model.ps.x.value
    terms = [(1 * x[1] + 2 * x[2]) * x[0], (3 * x[1] + 4 * x[2]) * x[1]]
    expected = [*(x[0] + x[1]), 21 * x[0, 0], *np.add(*terms)]
    np.testing.assert_allclose(model.residual_values("Pair.c").whitened[0], expected)
    assert all(check.difference <= check.bound for check in model.check_gradients())


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-12), ("f32", 2e-5)])
def test_kernels_and_machine_of_sums_over_rows(
    precision: str, tolerance: float, tmp_path: Path
) -> None:
    model = fill_rows(model_of(tmp_path, ROWS, precision))
    check_against_oracle(model, tolerance)
    rtol = 1e-12 if precision == "f64" else 1e-4
    np.testing.assert_allclose(model.residual_values("Row.c").raw, by_hand(model), rtol=rtol)
    if precision == "f64":
        check_against_differences(model)


def test_sums_over_rows_follow_edits_of_rows(tmp_path: Path) -> None:
    model = fill_rows(model_of(tmp_path, ROWS, interpret=True))

    def check(count: int) -> None:
        solved = model.solve(max_iters=3)  # in the session of the solves before
        found = model.residual_values("Row.c").whitened
        assert len(found) == count
        np.testing.assert_allclose(found, by_hand(model), rtol=1e-9)
        assert solved.cost == pytest.approx(model.cost(), rel=1e-12)

    check(3)
    model.rows[0].items[1].a = 1.7
    check(3)
    model.rows[1].items.append(a=1, b=[1, 1], beacon=1)
    check(4)
    model.rows[2].items.pop()
    check(4)
    model.rows[0].items.clear()
    model.beacons[1].w = 5
    check(3)


def test_a_sum_over_the_rows_of_the_root(tmp_path: Path) -> None:
    text = """
struct Item { a: real; y: real }
root R {
    param p: real = 0
    param q: real = 0
    items: list of Item
    constraint normal { sum(x in items) { x.a * (p * x.a + q - x.y) } }
    constraint level { sum(x in items) { p * x.a + q - x.y } }
}
"""
    model = model_of(tmp_path, text, interpret=True)
    model.items.extend(a=[1, 2, 3, 4], y=[1, 3, 2, 5])
    model.solve()
    expected = np.polyfit([1, 2, 3, 4], [1, 3, 2, 5], 1)
    np.testing.assert_allclose([model.p.value, model.q.value], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("term", "operation"),
    [("sin(x.a * k)", "sin"), ("1 / (x.a + k)", "div"), ("exp(k + x.a)", "exp")],
)
def test_a_guard_that_is_no_sum_of_products_is_refused(term: str, operation: str) -> None:
    text = f"""
struct Item {{ a: real }}
struct Row {{ param p: real; k: real; items: list of Item; other: ref Row in root.rows
    constraint c when sum(x in other.items) {{ {term} }} > 0 {{ p }} }}
root R {{ rows: list of Row }}
"""
    with pytest.raises(AraelError, match=f"`{operation}` joins data") as caught:
        arael.loads(text, interpret=True)
    assert caught.value.diagnostics[0].code == "E0621"


def test_a_term_of_too_many_products_is_refused() -> None:
    sums = " * ".join(f"(x.a{i} + k^{i + 1} + q^{i + 1})" for i in range(8))
    data = "; ".join(f"a{i}: real" for i in range(8))
    text = f"""
struct Item {{ {data} }}
struct Row {{ param p: real; k: real; q: real; items: list of Item; other: ref Row in root.rows
    constraint c when sum(x in other.items) {{ {sums} }} > 0 {{ p }} }}
root R {{ rows: list of Row }}
"""
    with pytest.raises(AraelError, match="more than 100 products"):
        arael.loads(text, interpret=True)


def test_a_sum_that_is_not_finite_is_named(tmp_path: Path) -> None:
    model = fill_rows(model_of(tmp_path, ROWS, interpret=True))
    model.rows[2].items[0].a = 0
    expected = pytest.raises(AraelError, match=r"the sum over rows\[2\]\.items")
    with np.errstate(invalid="ignore"), expected:
        model.solve()


def test_a_sum_in_a_large_constraint_is_bounded(tmp_path: Path) -> None:
    text = """
struct P { param x: vec<40> }
struct Row { ps: [ref P in root.ps; 32]
    constraint c { sum(p in ps) { sum(q in ps) { exp(norm(p.x - q.x)) * sin(p.x) .* cos(q.x) } } } }
root R { ps: list of P; rows: list of Row }
"""
    with pytest.raises(AraelError) as caught:
        model_of(tmp_path, text, interpret=True)
    assert caught.value.diagnostics[0].code in ("E0606", "E0620")


def test_stages_show_lists_and_sums() -> None:
    findings = Findings()
    tree = compiler.syntax(Source("spline.arael", SPLINE.replace("PRECISION", "f64")))
    assert "RefListType count=4" in outline(tree.items)
    assert "over: Attribute name='knots'" in outline(tree.items)
    typed = compiler.types(tree, findings)
    program = compiler.derive(typed, "spline.arael")
    assert "t0 = knots[0].c.x" in programs(program)
    assert "#     x[0]    knots[0].c.x" in compiler.emit(program, "")
    tree = compiler.syntax(Source("rows.arael", ROWS.replace("PRECISION", "f64")))
    typed = compiler.types(tree, findings)
    assert "Total slot=0 rows=1 collection='rows.items'" in outline(typed.constraints)
    program = compiler.derive(typed, "rows.arael")
    assert "= sum 2 over items" in programs(program)
    assert "sum 2 over items" in compiler.emit(program, "")
