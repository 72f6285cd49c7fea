"""Sums over rows term by term: machine, kernels and differences, against the same written out."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import arael
from arael.cli.formulas import formulas
from arael.cli.outline import programs
from arael.compiler import compiler
from arael.diagnostics.records import AraelError, Findings, Source
from arael.face.native import SlowFunctionWarning
from arael.runtime import unrolled
from arael.runtime.failures import SolveError
from arael.runtime.layout import from_json, to_json
from arael.runtime.problem import Problem
from tests.compiler.test_kernels import check_against_differences, check_against_oracle
from tests.compiler.test_sums import model_of

CRANE = """
struct Load {
    param mass: real
    arm: real
    prior mass ~ normal(1, 1)
}
struct Beam {
    param pivot: real = 0.2
    seen: real = 1
    loads: list of Load
    prior pivot ~ normal(0, 1)
    constraint levelLOSS { (sum(x in loads) { x.mass * sin(x.arm - pivot) } - seen) / 0.5 }
}
root Crane : PRECISION { beams: list of Beam }
"""

# Sums of several lists, of other rows, of sums; rotations; refs of rows; all that may stand around.
MIXED = """
struct Anchor { param at: vec3; weight: real = 1.5; prior at ~ normal(0, 3) }
struct Leg {
    param turn: euler
    d: vec3
    anchor: ref Anchor in root.anchors
    extra: real?
    parts: list of Part
    prior turn ~ normal(0, 2)
}
struct Part { w: real }
struct Rope { param len: real = 1; stiff: real; prior len ~ normal(1, 1) }
struct Net {
    param base: vec3
    k: real = 0.8
    legs: list of Leg
    ropes: list of Rope
    friend: ref Net in root.nets
    prior base ~ normal(0, 2)
    constraint pull when base.z + sum(x in legs) { x.turn.x * base.x } < root.limit loss cauchy(2) {
        let span = sum(x in legs) {
            let v = rotation_matrix(x.turn) * x.d + x.anchor.at - base
            norm(v) * x.anchor.weight * (if x.extra then x.extra else k)
        }
        let tension = sum(r in ropes) { exp(-r.stiff * r.len * root.g) * span }
        [span / 10 - tension,
         root.g * cos(sum(x in legs) { sum(y in x.parts) { y.w } * x.turn.z + sin(k * base.x) }),
         sum(r in friend.ropes) { sqrt(1 + r.len^2 * base.y^2) }]
    }
}
root Nets : PRECISION {
    param g: real = 0.7
    limit: real = 50
    anchors: list of Anchor
    nets: list of Net
}
"""


def crane(folder: Path, counts: tuple[int, ...], loss: str = "", **options: Any) -> Any:
    text = CRANE.replace("LOSS", f" loss {loss}" if loss else "")
    model = model_of(folder, text, **options)
    random = np.random.default_rng(3)
    for n in counts:
        loads = [{"mass": random.normal(1), "arm": random.normal()} for _ in range(n)]
        model.beams.append(pivot=random.normal(), loads=loads)
    return model


def levels(model: Any) -> np.ndarray:
    """Residuals of all beams by hand."""
    return np.array(
        [
            sum(x.mass.value * np.sin(x.arm - b.pivot.value) for x in b.loads) - b.seen
            for b in model.beams
        ]
    )


def nets(folder: Path, precision: str = "f64", **options: Any) -> Any:
    model = model_of(folder, MIXED, precision, **options)
    random = np.random.default_rng(4)
    model.anchors.extend(at=random.normal(size=(3, 3)))
    for i, (legs, ropes) in enumerate([(2, 3), (0, 1), (3, 0), (18, 2), (17, 2), (0, 0)]):
        model.nets.append(
            base=random.normal(size=3),
            friend=max(i - 1, 0),
            legs=[
                {
                    "turn": random.normal(size=3) / 3,
                    "d": random.normal(size=3),
                    "anchor": int(random.integers(3)),
                    "extra": 0.5 if k % 2 else None,
                    "parts": [{"w": 0.1 * j} for j in range(k % 3)],
                }
                for k in range(legs)
            ],
            ropes=[{"len": random.uniform(0.5, 2), "stiff": 0.3 + k} for k in range(ropes)],
        )
    return model


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-11), ("f32", 5e-5)])
def test_all_that_may_stand_in_a_term(precision: str, tolerance: float, tmp_path: Path) -> None:
    model = nets(tmp_path, precision)
    check_against_oracle(model, tolerance)
    if precision == "f64":
        check_against_differences(model)
        assert all(check.agrees for check in model.check_gradients())


def test_residuals_are_those_of_the_formula(tmp_path: Path) -> None:
    model = crane(tmp_path, (3, 0, 5, 1, 18, 17, 3, 40), loss="cauchy(1)", interpret=True)
    found = model.residual_values("Beam.level")
    assert found.rows == tuple(f"beams[{k}]" for k in range(8))
    np.testing.assert_allclose(found.raw[:, 0], levels(model), rtol=1e-12)
    np.testing.assert_allclose(found.whitened[:, 0], 2 * levels(model), rtol=1e-12)
    table = model.cost_table()
    assert table.instances["Beam.level"] == 8
    assert table["Beam.level"] == pytest.approx((found.robust**2).sum(), rel=1e-12)
    (check,) = (c for c in model.check_gradients() if c.label == "Beam.level")
    assert check.agrees
    assert check.instances == 7  # one has no rows, and no derivative
    assert model.jacobian().matrix.shape[0] == 8 + 8 + 87


def test_it_is_the_model_with_lists_of_refs(tmp_path: Path) -> None:
    refs = (
        CRANE.replace("loads: list of Load", "loads: [ref Load in root.loads; 4]")
        .replace("beams: list of Beam }", "loads: list of Load; beams: list of Beam }")
        .replace("LOSS", "")
    )
    mine = crane(tmp_path, (4, 4, 4), interpret=True)
    other = model_of(tmp_path, refs, interpret=True)
    other.loads.extend(
        mass=[x.mass.value for b in mine.beams for x in b.loads],
        arm=[x.arm for b in mine.beams for x in b.loads],
    )
    for k, beam in enumerate(mine.beams):
        other.beams.append(pivot=beam.pivot.value, loads=list(range(4 * k, 4 * k + 4)))
    order = [other.parameter_names().index(name) for name in names_there(mine)]
    np.testing.assert_allclose(mine.gradient(), other.gradient()[order], rtol=1e-12, atol=1e-13)
    hessian = other.hessian()[np.ix_(order, order)]
    np.testing.assert_allclose(mine.hessian(), hessian, rtol=1e-12, atol=1e-13)
    block = mine.hessian_block(mine.beams[1].loads[0], mine.beams[1].loads[3])
    assert np.abs(block).max() > 1e-3
    assert mine.solve().cost == pytest.approx(other.solve().cost, rel=1e-9)


def names_there(model: Any) -> list[str]:
    """Names of the parameters in the model with refs: loads of all beams in one list."""
    found = []
    for name in model.parameter_names():
        beam, _, load = name.partition(".loads[")
        if not load:
            found.append(name)
            continue
        k, _, rest = load.partition("]")
        found.append(f"loads[{4 * int(beam[6:-1]) + int(k)}]{rest}")
    return found


def test_edits_of_rows_in_a_session(tmp_path: Path) -> None:
    model = crane(tmp_path, (2, 0, 17), interpret=True)

    def check() -> None:
        solved = model.solve(max_iters=4)
        expected = levels(model)
        found = model.residual_values("Beam.level").raw[:, 0]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
        assert solved.cost == pytest.approx(model.cost(), rel=1e-12)

    check()
    counts = model._session.counts
    problems, analyses = counts.problems, counts.analyses
    model.beams[0].loads[1].arm = 0.4
    check()
    assert (counts.problems, counts.analyses) == (problems, analyses)
    model.beams[2].loads.append(mass=1, arm=0.3)  # 18 rows: in the group of 17
    check()
    model.beams[1].loads.append(mass=2, arm=-0.3)
    check()
    model.beams[0].loads.clear()
    check()
    model.beams[2].loads.pop()
    model.beams.append(pivot=0.1, loads=[{"mass": 1, "arm": 0.1 * k} for k in range(7)])
    check()
    np.testing.assert_allclose(model.solve().cost, pickle.loads(pickle.dumps(model)).cost())
    assert model.copy().cost() == model.cost()


def test_appending_a_row_reuses_programs_of_known_lengths(tmp_path: Path) -> None:
    model = crane(tmp_path, (2, 5), interpret=True)
    before = model._problem().layout.groups
    model.beams.append(pivot=0.3, loads=[{"mass": 1, "arm": k} for k in range(5)])
    assert model._problem().layout.groups is before


@pytest.mark.parametrize("interpret", [True, False])
def test_data_alone_in_a_term_that_does_not_separate(interpret: bool, tmp_path: Path) -> None:
    text = """
struct Item { a: real; seen: real }
root R {
    param p: real = 0.5
    items: list of Item
    constraint wave { sum(x in items) { log(1 + exp(x.a * p)) - x.seen } }
}
"""
    model = model_of(tmp_path, text, interpret=interpret)
    a = np.linspace(-1, 2, 300)
    model.items.extend(a=a, seen=np.log(1 + np.exp(0.9 * a)))
    assert model.solve().converged
    assert model.p.value == pytest.approx(0.9, abs=1e-9)


def test_other_parts_of_the_interface(tmp_path: Path) -> None:
    model = crane(tmp_path, (3, 2, 20), loss="huber(1)", interpret=True)
    serial, threads = (crane(tmp_path, (3, 2, 20), loss="huber(1)", interpret=True) for _ in "ab")
    assert serial.solve(num_threads=1).cost == pytest.approx(threads.solve(num_threads=2).cost)
    model.solve()
    assert model.covariance().marginal(model.beams[0]).shape == (4, 4)
    problem = model.problem()
    assert problem.cost(np.zeros(problem.size)) == pytest.approx(model.cost())
    model.residuals.add("beams[0].pivot - beams[2].loads[1].mass", label="tie")
    assert "tie" in model.cost_table()
    assert model.residual_values("tie").raw.shape == (1, 1)
    assert model.solve().converged
    assert model.beams[0].loads[0].mass.optimize
    held = model.beams[2].loads[3].mass.value
    model.solve(freeze="Load.mass")
    assert model.beams[2].loads[3].mass.value == held


def test_a_layout_is_the_same_after_the_cache(tmp_path: Path) -> None:
    model = crane(tmp_path, (3, 1), interpret=True)
    layout = model._compiled.layout
    again = from_json(to_json(layout))
    assert again.groups[0].row_sums == layout.groups[0].row_sums
    model._store.layout = again
    assert Problem(again, model._store).cost() == pytest.approx(model.cost(), rel=1e-14)


def test_named_blocks_and_triplets(tmp_path: Path) -> None:
    text = CRANE.replace("constraint level", "hb: block Beam\n constraint level into [hb, root.t]")
    text = text.replace("beams: list of Beam }", "beams: list of Beam; t: triplets }")
    model = model_of(tmp_path, text.replace("LOSS", ""), interpret=True)
    model.beams.append(pivot=0.4, loads=[{"mass": 1, "arm": 1}, {"mass": 2, "arm": 0.5}])
    hessian = model.hessian()
    names = model.parameter_names()
    first = names.index("beams[0].pivot")
    assert model.beams[0].hb[0, 0] == pytest.approx(hessian[first, first])
    found = model.t.toarray()
    expected = np.triu(hessian, 1)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("term", "expected"),
    [("log(x.arm) * pivot", "`log` of (0) is -inf"), ("log(x.mass - 1)", "in `log(x.mass - 1)`")],
)
def test_a_term_that_is_not_finite_is_named(term: str, expected: str, tmp_path: Path) -> None:
    text = CRANE.replace("sin(x.arm - pivot)", term).replace("LOSS", "")
    model = model_of(tmp_path, text, interpret=True)
    model.beams.append(loads=[{"mass": 2, "arm": 1}, {"mass": 1, "arm": 0}])
    with pytest.raises(SolveError) as caught:
        model.solve()
    notes = caught.value.diagnostics[0].notes
    assert any(expected in note for note in notes)
    assert "in the term of `beams[0].loads[1]`" in notes


def test_a_sum_within_a_sum_that_must_be_written_out_is_refused() -> None:
    text = """
struct Sub { z: real }
struct Item { subs: list of Sub }
struct Row { param p: real; items: list of Item
    constraint c { sum(x in items) { sum(y in x.subs) { sin(y.z * p) } } } }
root R { rows: list of Row }
"""
    with pytest.raises(AraelError, match="sum over rows within a sum over rows") as caught:
        arael.loads(text, interpret=True)
    assert caught.value.diagnostics[0].code == "E0621"


@pytest.mark.parametrize(
    ("limit", "what"), [("MAX_PRODUCTS", "products"), ("MAX_OPERATIONS", "operations")]
)
def test_a_list_that_is_too_long_is_refused(
    limit: str, what: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(unrolled, limit, 10)
    model = crane(tmp_path, (30,), interpret=True)
    with pytest.raises(SolveError, match=f"sums over 29 or more rows .* {what}") as caught:
        model.solve()
    assert caught.value.diagnostics[0].code == "E1017"


def test_groups_of_lengths() -> None:
    assert [unrolled.bounds(n) for n in (0, 1, 16)] == [(0, 0), (1, 1), (16, 16)]
    assert unrolled.bounds(17) == unrolled.bounds(18) == (17, 18)
    assert unrolled.bounds(33) == unrolled.bounds(36) == (33, 36)
    for n in range(1, 3000):
        low, high = unrolled.bounds(n)
        assert low <= n <= high <= max(n, 1.13 * n)
        assert unrolled.bounds(low) == unrolled.bounds(high) == (low, high)


def test_rows_of_a_list_that_leave_without_their_owner_are_refused(tmp_path: Path) -> None:
    model = crane(tmp_path, (3, 2), interpret=True)
    model.solve()
    with pytest.raises(AraelError, match=r"of `beams\[0\]`, which stays, sums over a row"):
        model.marginalise(model.beams[0].loads[1])
    model.marginalise(model.beams[0])
    assert len(model.beams) == 1
    assert model.solve().converged


def test_a_null_owner_is_named(tmp_path: Path) -> None:
    text = """
struct Item { param a: real }
struct Row { other: ref Row in root.rows?; items: list of Item
    constraint c when other { sum(x in other.items) { x.a } - 1 } }
root R { rows: list of Row }
"""
    model = model_of(tmp_path, text, interpret=True)
    model.rows.append(items=[{"a": 1}, {"a": 3}])
    model.rows.append(other=0)
    assert model.residual_values("Row.c").rows == ("rows[1]",)
    np.testing.assert_allclose(model.residual_values("Row.c").raw, [[3]])


def test_constraint_index_of_instances(tmp_path: Path) -> None:
    text = CRANE.replace("seen: real", "n: constraint_index\n seen: real").replace("LOSS", "")
    text = text.replace("prior pivot ~ normal(0, 1)", "")
    model = model_of(tmp_path, text, interpret=True)
    for count in (2, 0, 2, 1):
        model.beams.append(loads=[{"mass": 1, "arm": k} for k in range(count)])
    jacobian = model.jacobian()
    level = jacobian.labels.index("Beam.level")
    expected = jacobian.constraint[jacobian.label_of == level]
    assert sorted(beam.n for beam in model.beams) == sorted(expected)


def test_stages_show_the_terms() -> None:
    findings = Findings()
    source = CRANE.replace("PRECISION", "f64").replace("LOSS", "")
    tree = compiler.syntax(Source("crane.arael", source))
    program = compiler.derive(compiler.types(tree, findings), "crane.arael")
    text = programs(program)
    assert "term of sum1, over loads" in text
    assert "d r0 / d sum1[0] = t" in text
    assert "d v0 / d loads.mass = t" in text
    stages = formulas(compiler.types(tree, Findings()), None, None)
    assert "r0 = " in stages
    assert "d r0 / d sum1[0] = " in stages
    assert msgspec.json.decode(to_json(program.layout))["groups"][0]["row_sums"]["sums"]


def test_stored_values_of_rows(tmp_path: Path) -> None:
    text = """
struct Item { param a: real; prior a ~ normal(2, 1) }
struct Row { param p: real; items: list of Item
    constraint c { sum(x in items) { x.a.value * p + sin(x.a.value - p) } - 1 } }
root R { rows: list of Row }
"""
    model = model_of(tmp_path, text, interpret=True)
    model.rows.append(p=0.3, items=[{"a": 0.5}, {"a": 0.7}])

    def check() -> None:
        row = model.rows[0]
        p, a = row.p.value, np.array([x.a.value for x in row.items])
        expected = (a * p + np.sin(a - p)).sum() - 1
        np.testing.assert_allclose(model.residual_values("Row.c").raw, [[expected]])

    check()
    model.solve()
    check()
    assert model.rows[0].items[0].a.value == pytest.approx(2)


def test_an_owner_leaves_with_its_rows_and_a_prior_stays(tmp_path: Path) -> None:
    text = """
struct Anchor { param at: vec2; prior at ~ normal(0, 3) }
struct Leg { param len: real; d: vec2; anchor: ref Anchor in root.anchors
    prior len ~ normal(1, 1) }
struct Net { legs: list of Leg
    constraint pull { sum(x in legs) { x.len^2 * x.d + x.anchor.at } - [3, 1] } }
root R { anchors: list of Anchor; nets: list of Net }
"""
    model = model_of(tmp_path, text, interpret=True)
    model.anchors.extend(at=np.zeros((3, 2)))
    for pair in ([0, 1], [1, 2], [2, 0]):
        model.nets.append(legs=[{"len": 1, "d": [1, k], "anchor": k} for k in pair])
    cost = model.solve(gradient_tolerance=1e-10).cost
    before, sigma = model.anchors.at.value.copy(), model.covariance().marginal(model.anchors[0])
    model.marginalise(model.nets[1])
    assert len(model.nets) == 2
    assert model.solve(gradient_tolerance=1e-10).cost == pytest.approx(cost, rel=1e-8)
    np.testing.assert_allclose(model.anchors.at.value, before, atol=1e-6)
    np.testing.assert_allclose(model.covariance().marginal(model.anchors[0]), sigma, rtol=1e-5)


def test_a_native_function_in_a_term(tmp_path: Path) -> None:
    text = """
extern fn f(x) derivs [cos(x)]
struct Item { param a: real; prior a ~ normal(1, 1) }
root R { items: list of Item
    constraint c { sum(x in items) { f(x.a * 2) } - 1 } }
"""
    path = tmp_path / "m.arael"
    path.write_text(text)
    with pytest.warns(SlowFunctionWarning):
        model = arael.load(path, interpret=True, functions={"f": np.sin})()
    model.items.extend(a=[0.1, 0.2])
    (check,) = (c for c in model.check_gradients() if c.label == "R.c")
    assert check.agrees
    found = model.residual_values("R.c").raw
    np.testing.assert_allclose(found, [[np.sin([0.2, 0.4]).sum() - 1]])
