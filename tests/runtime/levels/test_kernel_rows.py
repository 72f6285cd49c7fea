"""Rows from kernels: edits in place, the pattern, constants, terms, expressions."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from arael.runtime.machine.tape import Tape
from tests.runtime.levels.test_sketch_rows import dense

Array = NDArray[Any]

# Compiled in tests of kernels only; as small as can be.
MODEL = """
struct Point { param pos: vec2 }
struct Scalar { param value: real }
struct Distance {
    a: ref Point in root.points
    b: ref Point in root.points
    value: real
    weight: real = 1
    constraint holds { weight * (norm(b.pos - a.pos) - value) }
}
struct Turned {
    p: ref Point in root.points
    r: ref Scalar in root.scalars
    angle: real = 0.5
    constraint holds { [p.pos.x - r.value * cos(angle), p.pos.y - r.value * sin(angle)] }
}
struct Difference {
    a: ref Scalar in root.scalars
    b: ref Scalar in root.scalars
    constraint holds { a.value - b.value }
}
root Rows {
    points: list of Point
    scalars: list of Scalar
    distances: list of Distance
    turned: list of Turned
    differences: list of Difference
}
"""
UNKNOWNS = 41


@functools.cache
def compiled(interpret: bool) -> Any:
    return from_text(MODEL, interpret)


def from_text(text: str, interpret: bool = True) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.arael")
        path.write_text(text, encoding="utf-8")
        return load_compiled(path, interpret=interpret)


def rows_of(interpret: bool = True, n: int = UNKNOWNS) -> KernelRows:
    model = compiled(interpret)
    return KernelRows(model.layout, model.kernels, n)


def unknowns(seed: int = 0) -> Array:
    return np.random.default_rng(seed).normal(size=UNKNOWNS)


def expected(struct: str, uses: Any, data: dict[str, float], x: Array) -> tuple[Array, Array]:
    """Residuals and dense Jacobian of one instance."""
    j = np.zeros((2 if struct == "Turned" else 1, len(x)))
    if struct == "Distance":
        a, b = uses
        d = x[b : b + 2] - x[a : a + 2]
        w, size = data.get("weight", 1.0), np.hypot(*d)
        j[0, b : b + 2] += w * d / size
        j[0, a : a + 2] -= w * d / size
        return np.array([w * (size - data["value"])]), j
    if struct == "Turned":
        p, r = uses
        c, s = np.cos(data["angle"]), np.sin(data["angle"])
        j[0, p] = j[1, p + 1] = 1
        j[0, r] -= c
        j[1, r] -= s
        return np.array([x[p] - x[r] * c, x[p + 1] - x[r] * s]), j
    a, b = uses
    j[0, a] += 1
    j[0, b] -= 1
    return np.array([x[a] - x[b]]), j


@pytest.mark.sweep(2)
@pytest.mark.parametrize("interpret", [True, False])
def test_random_edits_leave_the_rows_of_what_is_there(interpret: bool) -> None:
    """Also: rows of instances that are not touched stay bit-identical, at the same numbers."""
    rng = np.random.default_rng(1)
    rows, x = rows_of(interpret), unknowns()
    there: dict[int, Any] = {}
    before: dict[int, Any] = {}
    for step in range(300):
        what = rng.choice(["add", "add", "remove", "data", "on", "uses"])
        chosen = int(rng.choice(list(there))) if there else -1
        if what == "add" or not there:
            struct = str(rng.choice(["Distance", "Turned", "Difference"]))
            uses, data = drawn(rng, struct)
            chosen = rows.add(struct, uses, data)
            assert chosen not in there
            there[chosen] = [struct, uses, data, True]
        elif what == "remove":
            rows.remove(chosen)
            del there[chosen]
        elif what == "data":
            struct, _, data, _ = there[chosen]
            field = {"Distance": "value", "Turned": "angle"}.get(struct)
            if field:
                data[field] = float(rng.uniform(1, 2))
                rows.set_data(chosen, field, data[field])
        elif what == "on":
            there[chosen][3] = not there[chosen][3]
            rows.set_on(chosen, there[chosen][3])
            assert rows.is_on(chosen) == there[chosen][3]
        else:
            there[chosen][1], _ = drawn(rng, there[chosen][0])
            rows.set_uses(chosen, there[chosen][1])
            assert list(rows.uses(chosen)) == there[chosen][1]
        residuals, _ = rows.jacobian(x)
        jacobian = dense(rows, x)
        filled = np.zeros(rows.m, dtype=bool)
        for row, (struct, uses, data, on) in there.items():
            r, j = expected(struct, uses, data, x)
            at = slice(row, row + len(r))
            filled[at] = True
            assert rows.struct(row) == struct
            assert residuals[at] == pytest.approx(r * on, abs=1e-14)
            assert jacobian[at] == pytest.approx(j * on, abs=1e-14)
            now = residuals[at].tobytes() + jacobian[at].tobytes()
            if row != chosen and row in before:
                assert now == before[row], f"step {step} touched row {row}"
            before[row] = now
        assert not residuals[~filled].any()
        assert not np.diff(rows.indptr)[~filled].any()
        before = {row: before[row] for row in there}
        assert sorted(there) == list(rows.instances())


def drawn(rng: np.random.Generator, struct: str) -> tuple[list[int], dict[str, float]]:
    """Targets, now and then the same one twice, at even and odd offsets; and data."""
    uses = [int(one) for one in rng.choice(UNKNOWNS - 2, size=2, replace=False)]
    if struct == "Difference" and rng.random() < 0.1:
        uses[1] = uses[0]
    while struct == "Distance" and abs(uses[0] - uses[1]) < 2:
        uses = [int(one) for one in rng.choice(UNKNOWNS - 2, size=2, replace=False)]
    data = {
        "Distance": {"value": float(rng.uniform(1, 2)), "weight": float(rng.uniform(1, 2))},
        "Turned": {"angle": float(rng.uniform(1, 2))},
        "Difference": {},
    }
    return uses, data[struct]


def test_kernels_and_expression_machine_agree() -> None:
    found = []
    for interpret in (True, False):
        rows = rows_of(interpret)
        rng = np.random.default_rng(4)
        for struct in ["Distance", "Turned", "Difference"] * 30:
            rows.add(struct, *drawn(rng, struct))
        found.append((rows.evaluate(unknowns()), dense(rows, unknowns())))
    assert found[0][0] == pytest.approx(found[1][0], abs=1e-14)
    assert found[0][1] == pytest.approx(found[1][1], abs=1e-14)


def test_the_last_unknown_can_be_used() -> None:
    rows, x = rows_of(), unknowns()
    rows.add("Turned", [UNKNOWNS - 2, UNKNOWNS - 1], {"angle": 0})
    assert rows.evaluate(x) == pytest.approx([x[-2] - x[-1], x[-1]])


def test_constants_have_no_entries() -> None:
    rows, x = rows_of(), unknowns()
    fixed = rows.constant([3.0, 4.0])
    others = [rows.constant([float(k)]) for k in range(40)]  # the memory of constants grows
    row = rows.add("Distance", [0, fixed], [1.0])
    assert list(rows.indices[rows.indptr[row] : rows.indptr[row + 1]]) in ([0, 1], [1, 0])
    assert rows.evaluate(x)[row] == pytest.approx(np.hypot(3 - x[0], 4 - x[1]) - 1)
    rows.set_constant(fixed, [0.0, 1.0])
    assert rows.evaluate(x)[row] == pytest.approx(np.hypot(x[0], 1 - x[1]) - 1)
    both = rows.add("Difference", [others[5], others[7]])
    assert rows.evaluate(x)[both] == -2
    assert rows.indptr[both] == rows.indptr[both + 1]
    rows.release_constant(others[5])
    assert rows.constant([9.0]) == others[5]


def test_rows_of_removed_instances_are_used_again_and_others_keep_their_numbers() -> None:
    rows = rows_of()
    first, second, third = (rows.add("Turned", [2 * k, 30 + k]) for k in range(3))
    assert [first, second, third] == [0, 2, 4]
    rows.remove(second)
    assert rows.m == 6
    single = rows.add("Difference", [0, 1])  # of another number of rows: not between the others
    assert single == 6
    assert rows.add("Turned", [8, 20]) == second


def test_the_pattern_changes_once_for_a_block_of_edits() -> None:
    rows = rows_of()
    before = rows.pattern_version
    with rows.edit():
        kept = rows.add("Difference", [0, 1])
        rows.add("Difference", [1, 2])
        rows.remove(kept)
        rows.extend("Difference", np.c_[np.arange(30), np.arange(30) + 5])
        assert not np.diff(rows.indptr).any()  # as before, and empty rows
        with pytest.raises(RuntimeError, match="while they are being edited"):
            rows.evaluate(unknowns())
    assert rows.pattern_version == before + 1
    rows.set_data(rows.add("Distance", [0, 2], [1.0]), "value", 2.0)
    assert rows.pattern_version == before + 2


def test_many_instances_at_a_time() -> None:
    rows, x = rows_of(), unknowns()
    uses = np.array([[k, k + 5] for k in range(20)])
    added = rows.extend("Distance", uses, np.c_[np.arange(20.0)])
    again = rows.extend("Distance", uses, {"value": np.arange(20.0)})
    r = rows.evaluate(x)
    assert (r[added] == r[again]).all()
    assert [rows.data(int(k), "value") for k in added] == list(range(20))
    rows.set_data(added, "value", 3.0)
    assert rows.data(int(added[7])) == pytest.approx([3, 1])


def test_more_unknowns_than_there_were() -> None:
    rows = rows_of(n=4)
    row = rows.add("Distance", [0, 2], [0.0])
    rows.resize(1000)
    far = rows.add("Difference", [999, 0])
    x = np.arange(1000.0)
    assert rows.evaluate(x)[[row, far]] == pytest.approx([np.sqrt(8), 999])
    with pytest.raises(ValueError, match="uses an unknown beyond 500"):
        rows.resize(500)


def test_a_row_that_is_not_finite_is_reported() -> None:
    rows, x = rows_of(), unknowns()
    rows.add("Difference", [0, 1])
    rows.add("Distance", [4, 4], [0.0])  # of a point from itself: no derivative
    r, entries = rows.jacobian(x)
    assert np.isfinite(r).all()
    assert not np.isfinite(entries).all()


def test_the_slack_of_an_inequality_is_a_term() -> None:
    rows, x = rows_of(), unknowns()
    row = rows.add("Distance", [0, 2], [1.0])
    other = rows.add("Difference", [7, 8])
    plain, jacobian = rows.evaluate(x), dense(rows, x)
    rows.add_term(row, 40, -1.0)
    rows.add_term(other, 7, 2.0)
    rows.add_term(row, 0, 0.5)  # also one that the row has
    jacobian[row, 40] -= 1
    jacobian[row, 0] += 0.5
    jacobian[other, 7] += 2
    plain += [0.5 * x[0] - x[40], 2 * x[7]]
    assert rows.evaluate(x) == pytest.approx(plain)
    assert dense(rows, x) == pytest.approx(jacobian)
    rows.set_on(row, False)
    assert rows.evaluate(x)[row] == 0
    rows.set_on(row, True)
    assert rows.evaluate(x) == pytest.approx(plain)
    rows.remove_terms(row)
    assert rows.evaluate(x) == pytest.approx(plain - [0.5 * x[0] - x[40], 0])


def product_tape() -> Tape:
    """Inputs q0, q1, u, n: value n q0 q1 + u^2 and its derivatives by q0, q1 and u."""
    return Tape(
        ops=("input", "input", "input", "input", "mul", "mul", "mul", "mul", "add", "mul", "mul",
             "add"),
        args=((0,), (1,), (2,), (3,), (3, 0), (4, 1), (2, 2), (3, 1), (5, 6), (3, 0), (2, 2),
              (2, 2)),
        constants=(),
        outputs=(8, 7, 9, 11),
    )  # fmt: skip


def test_an_expression_over_quantities_follows_the_chain_rule() -> None:
    rows, x = rows_of(), unknowns()
    row = rows.add("Distance", [0, 2], [0.0])
    one = rows.add("Distance", [4, 6], [0.0], quantity=True)
    two = rows.add("Distance", [6, 0], [0.0], quantity=True)
    assert rows.indptr[one] == rows.indptr[one + 1]
    assert rows.evaluate(x)[one] == 0
    rows.add_expression(row, product_tape(), [one, two], unknowns=[9], numbers=[3.0])

    def value(x: Array) -> float:
        def size(a: int, b: int) -> float:
            return float(np.hypot(*(x[b : b + 2] - x[a : a + 2])))

        return size(0, 2) - (number * size(4, 6) * size(6, 0) + x[9] ** 2)

    number = 3.0
    assert rows.evaluate(x)[row] == pytest.approx(value(x))
    assert dense(rows, x)[row] == pytest.approx(slope(value, x), abs=1e-8)
    number = -0.5
    rows.set_numbers(row, [number])
    assert dense(rows, x)[row] == pytest.approx(slope(value, x), abs=1e-8)
    assert rows.quantity(one) == pytest.approx([np.hypot(*(x[6:8] - x[4:6]))])
    with pytest.raises(ValueError, match="is read by an expression"):
        rows.remove(one)
    rows.remove_expression(row)
    assert rows.evaluate(x)[row] == pytest.approx(np.hypot(*(x[2:4] - x[0:2])))
    rows.remove(one)


def slope(value: Any, x: Array) -> Array:
    steps = 1e-6 * np.eye(len(x))
    return np.array([(value(x + s) - value(x - s)) / 2e-6 for s in steps])


def test_removing_a_row_removes_its_expression_and_terms() -> None:
    rows, x = rows_of(), unknowns()
    row = rows.add("Distance", [0, 2], [0.0])
    one = rows.add("Distance", [4, 6], [0.0], quantity=True)
    rows.add_expression(row, product_tape(), [one, one], unknowns=[9], numbers=[3.0])
    rows.add_term(row, 3, 1.0)
    rows.remove(row)
    rows.remove(one)
    again = rows.add("Distance", [0, 2], [0.0])
    assert rows.evaluate(x)[again] == pytest.approx(np.hypot(*(x[2:4] - x[0:2])))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda r: r.add("Circle", [0]), "expected one of Distance, Turned, Difference"),
        (lambda r: r.add("Difference", [0]), r"expected offsets of shape \(N, 2\).*a, b"),
        (lambda r: r.add("Difference", [0, UNKNOWNS]), "`b` of Difference refers to 41"),
        (lambda r: r.add("Turned", [UNKNOWNS - 1, 0]), "`p` of Turned refers to 40"),
        (lambda r: r.add("Difference", [0, -1]), "`b` of Difference refers to -1"),
        (lambda r: r.add("Distance", [0, 2]), "expected values of value"),
        (lambda r: r.add("Distance", [0, 2], {"size": 1}), "expected one of value, weight"),
        (lambda r: r.add("Distance", [0, 2], [1, 2, 3]), "expected data of shape"),
        (lambda r: r.remove(0), "no instance begins at row 0"),
        (lambda r: r.set_data(r.add("Difference", [0, 1]), "value", 1), "found 'value'"),
        (lambda r: r.add_term(0, 0, 1.0), "row 0 is not a row of an equation"),
        (lambda r: r.set_constant(-7, [1.0]), "expected 0 constants at offset -7"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(edit: Any, message: str) -> None:
    rows = rows_of()
    with pytest.raises(ValueError, match=message):
        edit(rows)
    kept = rows.add("Difference", [0, 1])
    assert rows.evaluate(unknowns())[kept] == unknowns()[0] - unknowns()[1]


@pytest.mark.parametrize(
    ("constraint", "message"),
    [
        ("constraint holds when value > 0 { a.pos.x - value }", "has a guard"),
        ("constraint holds { a.pos.x - root.offset * value }", "reads more than its own data"),
        (
            "constraint holds { a.pos.x - a.weight * value }",
            "reads the data `weight` through a ref",
        ),
    ],
)
def test_models_that_rows_cannot_hold_are_refused(constraint: str, message: str) -> None:
    text = f"""
        struct Point {{ param pos: vec2 weight: real }}
        struct At {{
            a: ref Point in root.points
            value: real
            {constraint}
        }}
        root Model {{ offset: real = 1; points: list of Point; ats: list of At }}
    """.replace("vec2 weight", "vec2; weight")
    model = from_text(text)
    with pytest.raises(ValueError, match=message):
        KernelRows(model.layout)
