"""The language page on `key`, `skip`, `constraint_index`, `fit` and `marginalize`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from tests.language.models import loaded, refusal

# --- key ------------------------------------------------------------------------------------------

KEYED = """
struct Point { key name; name: string; param x: real }
struct Pair {
    a: ref Point in root.points
    b: ref Point in root.points
    d: real
    constraint c { b.x - a.x - d }
}
root R { points: list of Point; pairs: list of Pair }
"""
POINTS = [{"name": "left", "x": 0}, {"name": "right", "x": 5}, {"name": "far", "x": 9}]


def read(folder: Path, text: str, data: Any) -> Any:
    model = loaded(folder, text)()
    (folder / "data.json").write_text(json.dumps(data))
    model.read(folder / "data.json")
    return model


def test_a_ref_in_data_may_be_the_key_or_the_index(tmp_path: Path) -> None:
    pairs = [{"a": "left", "b": "far", "d": 1}, {"a": 1, "b": "left", "d": 2}]
    model = read(tmp_path, KEYED, {"points": POINTS, "pairs": pairs})
    assert [p.a.name for p in model.pairs] == ["left", "right"]
    assert [p.b.name for p in model.pairs] == ["far", "left"]
    model.write(tmp_path / "out.json")
    again = loaded(tmp_path, KEYED)()
    again.read(tmp_path / "out.json")
    assert [p.b.name for p in again.pairs] == ["far", "left"]


@pytest.mark.parametrize(
    ("points", "pair", "said"),
    [
        (POINTS, {"a": "lefft", "b": 1, "d": 0}, "left"),
        ([*POINTS, {"name": "left", "x": 1}], {"a": "left", "b": 1, "d": 0}, "left"),
        (POINTS, {"a": 7, "b": 1, "d": 0}, "7"),
    ],
    ids=["misspelt", "twice", "index"],
)
def test_a_key_that_names_no_one_row(tmp_path: Path, points: Any, pair: Any, said: str) -> None:
    with pytest.raises(arael.AraelError) as caught:
        read(tmp_path, KEYED, {"points": points, "pairs": [pair]})
    found = caught.value.diagnostics[0]
    assert found.code.startswith("E07")
    assert said in f"{found.message} {found.help}"


def test_a_string_for_a_ref_into_rows_without_a_key(tmp_path: Path) -> None:
    with pytest.raises(arael.AraelError) as caught:
        pairs = [{"a": "left", "b": 1, "d": 0}]
        read(tmp_path, KEYED.replace("key name; ", ""), {"points": POINTS, "pairs": pairs})
    assert caught.value.diagnostics[0].code.startswith("E07")


@pytest.mark.parametrize(
    "struct",
    [
        "struct P { key x; param x: real; constraint c { x } }",
        "struct P { key nmae; name: string; param x: real; constraint c { x } }",
    ],
)
def test_a_key_is_a_string_field(tmp_path: Path, struct: str) -> None:
    assert refusal(tmp_path, f"{struct}\nroot R {{ ps: list of P }}").code.startswith("E04")


# --- skip -----------------------------------------------------------------------------------------

SKIPPED = """
struct P {
    param x: real
    skip note: string = ""
    skip raw: vec3 = [0, 0, 0]
    constraint c { BODY }
}
root R { ps: list of P }
"""


def test_skipped_fields_are_carried_along(tmp_path: Path) -> None:
    ps = [{"x": 1, "note": "seen twice", "raw": [1, 2, 3]}, {"x": 2}]
    model = read(tmp_path, SKIPPED.replace("BODY", "x"), {"ps": ps})
    model.solve()
    assert model.ps[0].note == "seen twice"
    model.write(tmp_path / "out.json")
    written = json.loads((tmp_path / "out.json").read_text())["ps"]
    assert [p["note"] for p in written] == ["seen twice", ""]
    assert written[0]["raw"] == [1, 2, 3]


@pytest.mark.parametrize("body", ["x - raw.x", "x - self.raw.x", "if x > 0 then raw.x else x"])
def test_no_constraint_reads_a_skipped_field(tmp_path: Path, body: str) -> None:
    found = refusal(tmp_path, SKIPPED.replace("BODY", body))
    assert found.code.startswith("E0")
    assert "raw" in found.message


# --- constraint_index -----------------------------------------------------------------------------

INDEXED = """
struct P {
    param x: real
    on: bool = true
    row: constraint_index
    other: constraint_index
    constraint c when on { [x - 1, 2 * x] }
    constraint always { x / 10 }
}
root R { ps: list of P; param a: real = 0; constraint first { a } }
"""


def test_the_index_is_that_of_the_instance_in_the_jacobian(tmp_path: Path) -> None:
    model = loaded(tmp_path, INDEXED)(ps=[{"x": 0}, {"x": 1, "on": False}, {"x": 2}])
    model.solve()
    rows = model.ps.row
    assert rows[1] == -1, "its guard is false"
    jacobian = model.jacobian()
    for k in (0, 2):
        mine = [row for row in jacobian.rows if row.constraint == rows[k]]
        assert {row.label for row in mine} == {"P.c"}
        assert len(mine) == 2
        x = model.ps[k].x.value
        np.testing.assert_allclose([row.residual for row in mine], [x - 1, 2 * x])


def test_a_second_field_is_for_the_second_constraint(tmp_path: Path) -> None:
    model = loaded(tmp_path, INDEXED)(ps=[{"x": 0}, {"x": 1, "on": False}, {"x": 2}])
    model.solve()
    by_index = {row.constraint: row.label for row in model.jacobian().rows}
    assert [by_index[k] for k in model.ps.other] == ["P.always"] * 3


def test_data_need_not_give_the_index(tmp_path: Path) -> None:
    model = read(tmp_path, INDEXED, {"ps": [{"x": 0}]})
    model.solve()
    assert model.ps.row.tolist() == [1]


# --- fit ------------------------------------------------------------------------------------------

FIT = """
struct Entry { x: real; y: real; w: real = 1 }
root R {
    param a: real = 0
    param b: real = 0
    data: list of Entry
    FIT
}
"""
X = np.linspace(0, 2, 9)
ENTRIES = [{"x": x, "y": 2 * x + 1 + (-1) ** k * 0.1, "w": k % 3} for k, x in enumerate(X)]


@pytest.mark.parametrize(
    ("fit", "instead"),
    [
        ("fit data as e { a * e.x + b - e.y }", "root.a * x + root.b - y"),
        ("fit data as e { [a * e.x - e.y, b - e.w] }", "[root.a * x - y, root.b - w]"),
        ("fit data as e when e.w > 0 { a * e.x + b - e.y }", "when w > 0"),
        ("fit data as e loss huber(0.05) { a * e.x + b - e.y }", "loss huber(0.05)"),
    ],
)
def test_a_fit_is_a_constraint_on_each_element(tmp_path: Path, fit: str, instead: str) -> None:
    short = loaded(tmp_path, FIT.replace("FIT", fit))(data=ENTRIES, a=1, b=0.5)
    clause = instead if instead.startswith(("when", "loss")) else ""
    body = "root.a * x + root.b - y" if clause else instead
    entry = f"struct Entry {{ x: real; y: real; w: real = 1; constraint c {clause} {{ {body} }} }}"
    text = FIT.replace("FIT", "").split("\n", 2)[2]
    long = loaded(tmp_path, f"{entry}\n{text}")(data=ENTRIES, a=1, b=0.5)
    assert short.cost() == pytest.approx(long.cost(), rel=1e-13)
    np.testing.assert_allclose(short.gradient(), long.gradient(), rtol=1e-12)
    np.testing.assert_allclose(short.hessian(), long.hessian(), rtol=1e-12)


NESTED = """
struct Mark { m: real; CONSTRAINT }
struct Info { marks: list of Mark; w: real }
struct Pose { param x: real; infos: list of Info }
root R { param a: real = 0; poses: list of Pose; FIT }
"""


def test_a_fit_of_a_nested_collection(tmp_path: Path) -> None:
    """It runs over all elements of all rows, which see what holds them."""
    data = [
        {"x": k, "infos": [{"w": w, "marks": [{"m": m} for m in range(w)]} for w in (1, 2)]}
        for k in range(3)
    ]
    body = "{ MARK.parent.w * (MARK.parent.parent.x - root.a) - MARK.m }"
    fit = f"fit poses.infos.marks as e {body.replace('MARK', 'e')}"
    own = f"constraint c {body.replace('MARK', 'self')}"
    models = [
        loaded(tmp_path, NESTED.replace("CONSTRAINT", c).replace("FIT", f))(poses=data)
        for c, f in (("", fit), (own, ""))
    ]
    assert models[0].cost() == pytest.approx(models[1].cost(), rel=1e-13)
    assert models[0].cost() > 1
    np.testing.assert_allclose(models[0].hessian(), models[1].hessian(), rtol=1e-12)


def test_two_fits_of_one_collection_have_labels_of_their_own(tmp_path: Path) -> None:
    fits = "fit data as e { a * e.x - e.y }\n fit data as e { b - e.y }"
    labels = list(loaded(tmp_path, FIT.replace("FIT", fits))(data=ENTRIES).cost_table())
    assert len(set(labels)) == 2


def test_a_fit_is_solved(tmp_path: Path) -> None:
    model = loaded(tmp_path, FIT.replace("FIT", "fit data as e { a * e.x + b - e.y }"))(
        data=ENTRIES
    )
    model.solve(rel_precision=1e-12)
    expected = np.polyfit(X, [e["y"] for e in ENTRIES], 1)
    assert [model.a.value, model.b.value] == pytest.approx(expected, abs=1e-8)


# --- marginalize ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("clause", "code"),
    [
        ("marginalize point", "E0405"),
        ("marginalize gain", "E0403"),
        ("marginalize plain", "E0411"),
    ],
)
def test_what_cannot_be_marginalized(tmp_path: Path, clause: str, code: str) -> None:
    text = """
    struct Point { param x: real; constraint c { x - root.gain } }
    struct Plain { x: real }
    root R { points: list of Point; plain: list of Plain; gain: real = 1; CLAUSE }
    """
    assert refusal(tmp_path, text.replace("CLAUSE", clause)).code == code


def test_a_nested_collection_may_be_marginalized(tmp_path: Path) -> None:
    text = """
    struct Mark { param m: real; constraint c { [m - 1, m - parent.x] } }
    struct Pose { param x: real; marks: list of Mark; constraint c { x - root.gain } }
    root R { poses: list of Pose; gain: real = 3; marginalize poses.marks }
    """
    made = loaded(tmp_path, text)
    assert made.layout.marginalize == ("poses.marks",)
    model = made(poses=[{"x": 0, "marks": [{"m": 0}] * 2}, {"x": 1, "marks": [{"m": 5}]}])
    model.solve(solver="schur", rel_precision=1e-12)
    assert model.poses.x.value == pytest.approx([2, 7 / 3], abs=1e-8)


def test_marginalize_changes_nothing_of_the_solution(tmp_path: Path) -> None:
    text = """
    struct Point { param x: real; z: real; constraint c { [x - z, 3 * (x - root.a) - 1] } }
    root R { param a: real = 0; points: list of Point; constraint c { a - 1 }; CLAUSE }
    """
    points = [{"x": 0, "z": z} for z in (1.0, 2.0, 4.0)]
    found = []
    for clause in ("", "marginalize points"):
        made = loaded(tmp_path, text.replace("CLAUSE", clause))
        model = made(points=points)
        model.solve(solver="schur", rel_precision=1e-12)
        found.append([model.a.value, *model.points.x.value])
        assert made.layout.marginalize == (("points",) if clause else ())
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)
