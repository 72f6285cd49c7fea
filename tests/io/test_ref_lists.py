"""Lists of refs of fixed length in data files, data frames and Python."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.cli.info import describe
from arael.diagnostics.records import AraelError
from arael.model import Model
from tests.optional import needs

TEXT = """
struct Knot { name: string = ""; param c: real; key name }
struct Sample {
    seen: real
    knots: [ref Knot in root.knots; 3]
    subs: list of Sub
    constraint near { sum(k in knots) { k.c } - seen }
}
struct Sub { pair: [ref Knot in root.knots; 2] }
root Curve { knots: list of Knot; samples: list of Sample; ends: [ref Knot in root.knots; 2] }
"""
INDEX = np.array([[0, 1, 2], [3, 3, 1]])


@pytest.fixture(scope="module")
def curve() -> type[Model]:
    return arael.loads(TEXT, interpret=True)


@pytest.fixture
def model(curve: type[Model]) -> Any:
    found = curve()
    found.knots.extend(name=["a", "b", "c", "d"], c=np.arange(4.0))
    found.samples.extend(seen=[1, 2], knots=INDEX)
    found.samples[1].subs.append(pair=["d", "a"])
    found.ends = [found.knots[0], found.knots[3]]
    return found


def same(one: Any, other: Any) -> None:
    np.testing.assert_array_equal(one.samples.knots.index, other.samples.knots.index)
    np.testing.assert_array_equal(one.samples.subs.pair.index, other.samples.subs.pair.index)
    np.testing.assert_array_equal(one.ends.index, other.ends.index)


HDF5 = pytest.param("h5", marks=needs("h5py"))


@pytest.mark.parametrize("form", ["json", "npz", HDF5])
def test_files_keep_lists(form: str, model: Any, curve: type[Model], tmp_path: Path) -> None:
    model.write(tmp_path / f"data.{form}")
    again = curve()
    again.read(tmp_path / f"data.{form}")
    same(model, again)
    if form == "json":
        rows = json.loads((tmp_path / "data.json").read_text())["samples"]
        assert [row["knots"] for row in rows] == [["a", "b", "c"], ["d", "d", "b"]]
    elif form == "npz":
        arrays = np.load(tmp_path / "data.npz")
        np.testing.assert_array_equal(arrays["samples.knots"], INDEX)
        np.testing.assert_array_equal(arrays["samples.subs.pair"], [[3, 0]])


def test_an_archive_may_have_a_column_for_each_element(
    model: Any, curve: type[Model], tmp_path: Path
) -> None:
    model.write(tmp_path / "data.npz")
    arrays = dict(np.load(tmp_path / "data.npz"))
    whole = arrays.pop("samples.knots")
    np.savez(
        tmp_path / "data.npz", **arrays, **{f"samples.knots.{k}": whole[:, k] for k in range(3)}
    )
    again = curve()
    again.read(tmp_path / "data.npz")
    same(model, again)


def test_csv_has_a_column_for_each_element(model: Any, curve: type[Model], tmp_path: Path) -> None:
    path = tmp_path / "samples.csv"
    model.write(path)
    assert path.read_text().splitlines()[:2] == ["seen,knots.0,knots.1,knots.2", "1.0,a,b,c"]
    before = model.samples.knots.index
    path.write_text("seen,knots.0,knots.1,knots.2\n1,0,1,2\n2,d,d,b\n")
    model.read(path)
    np.testing.assert_array_equal(model.samples.knots.index, before)


@pytest.mark.parametrize("ending", ["parquet", "arrow"])
@needs("pyarrow")
def test_tables_of_arrow_have_a_column_for_each_element(
    ending: str, model: Any, curve: type[Model], tmp_path: Path
) -> None:
    model.write(tmp_path / f"samples.{ending}")
    again = curve()
    again.knots.extend(name=["a", "b", "c", "d"], c=np.zeros(4))
    again.read(tmp_path / f"samples.{ending}")
    np.testing.assert_array_equal(again.samples.knots.index, INDEX)
    np.testing.assert_array_equal(again.samples.seen, [1, 2])


def test_data_frames_keep_lists(model: Any, curve: type[Model]) -> None:
    frame = model.samples.to_pandas()
    assert list(frame.columns) == ["seen", "knots.0", "knots.1", "knots.2"]
    before = model.samples.knots.index
    model.samples.clear()
    model.samples.extend(frame)
    np.testing.assert_array_equal(model.samples.knots.index, before)


def test_copies_keep_lists(model: Any) -> None:
    for again in (model.copy(), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        same(model, again)
        assert again.samples[0].knots[0] == again.knots[0]


def test_reading_and_assigning_in_python(model: Any) -> None:
    a, b, c, d = model.knots
    row = model.samples[0]
    assert list(row.knots) == [a, b, c]
    assert row.knots[-1] == c
    assert row.knots[1:] == [b, c]
    assert len(row.knots) == 3
    assert repr(row.knots) == "<samples[0].knots: knots[0], knots[1], knots[2]>"
    assert "knots=[knots[0], knots[1], knots[2]]" in repr(row)
    row.knots = [d, d, a]
    assert row.knots.index.tolist() == [3, 3, 0]
    row.knots[1] = b
    row.knots[2] = "c"
    assert row.knots.rows.tolist() == [3, 1, 2]
    model.samples.append(seen=1, knots=[a, "b", 2])
    assert model.samples[2].knots.index.tolist() == [0, 1, 2]
    assert model.samples.knots[0].index.tolist() == [3, 3, 0]
    model.samples.knots = INDEX[:1].repeat(3, axis=0)
    assert model.samples.knots.index.tolist() == [[0, 1, 2]] * 3
    model.samples[1].knots = model.samples[0].knots
    model.samples.extend(seen=[1, 2], knots=[[a, b, c], model.samples[0].knots])
    model.samples.extend(seen=[1, 2], knots=[c, b, a])
    assert model.samples.knots.rows[3:].tolist() == [[0, 1, 2]] * 2 + [[2, 1, 0]] * 2
    model.samples[3:5].knots = model.samples[5:7].knots
    assert model.samples.knots.index[3:].tolist() == [[2, 1, 0]] * 4
    assert model.ends.index.tolist() == [0, 3]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([0, 1], r"samples\[0\]\.knots: error\[E0704\]: expected 3 refs to Knot, found 2"),
        (3, r"samples\[0\]\.knots: error\[E0703\]: expected a list of 3 refs, found int"),
        ([0, 1, 7], r"samples\[0\]\.knots\.2: error\[E0708\]: index 7 is out of range"),
        ([0, 1, "x"], r"\[E0708\]: no `Knot` .*\"x\"|\[E0708\]"),
        (None, r"E0707"),
        ([0, 1, None], r"E0707"),
    ],
)
def test_messages_in_python(value: Any, message: str, model: Any) -> None:
    with pytest.raises(AraelError, match=message):
        model.samples[0].knots = value
    assert model.samples[0].knots.index.tolist() == [0, 1, 2]


@pytest.mark.parametrize("at", [1.5, slice(0, 2), None, True, (0, 1)])
def test_elements_are_assigned_by_whole_numbers(at: Any, model: Any) -> None:
    before = model.samples.knots.index.copy()
    with pytest.raises(
        AraelError, match=r"samples\[0\].knots: error\[E0703\]: expected the number"
    ):
        model.samples[0].knots[at] = model.knots[3]
    np.testing.assert_array_equal(model.samples.knots.index, before)


def test_messages_of_many_rows_name_the_row(model: Any) -> None:
    with pytest.raises(AraelError, match=r"expected 3 refs to Knot, found 2 in row 1"):
        model.samples.extend(seen=[0, 0], knots=[[0, 1, 2], [0, 1]])
    with pytest.raises(AraelError, match=r"expected 3 refs to Knot, found 4"):
        model.samples.extend(seen=[0, 0], knots=np.zeros((2, 4), int))
    with pytest.raises(IndexError, match=r"samples\[0\]\.knots\[3\]: there are 3 refs"):
        model.samples[0].knots[3]
    assert len(model.samples) == 2


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([0, 1], "samples[1].knots: error[E0704]: expected an array of 3 refs to `Knot`"),
        (None, "samples[1].knots: error[E0707]"),
        (5, "error[E0703]: expected an array of 3 refs to `Knot`, found the number 5"),
        ([0, 1, 9], "samples[1].knots[2]: error[E0708]: index 9 is out of range"),
        ([0, 1, True], "samples[1].knots[2]: error[E0703]"),
        ({"0": 1}, "found an object"),
        ("left out", "samples[1]: error[E0702]: `knots` is missing"),
    ],
)  # fmt: skip
def test_messages_of_json_name_the_row(
    value: Any, message: str, model: Any, tmp_path: Path
) -> None:
    path = tmp_path / "data.json"
    model.write(path)
    data = json.loads(path.read_text())
    data["samples"][1]["knots"] = value
    if value == "left out":
        del data["samples"][1]["knots"]
    path.write_text(json.dumps(data))
    with pytest.raises(AraelError) as caught:
        model.read(path)
    assert message in str(caught.value)
    if "E0708" in message:
        assert "declared as `knots[2]: ref Knot in root.knots`" in str(caught.value)


@pytest.mark.parametrize("array", [np.zeros((2, 4), int), np.zeros(2, int), np.zeros((2, 3))])
def test_messages_of_archives(array: Any, model: Any, tmp_path: Path) -> None:
    path = tmp_path / "data.npz"
    model.write(path)
    arrays = dict(np.load(path))
    arrays["samples.knots"] = array
    np.savez(path, **arrays)
    with pytest.raises(AraelError, match=r"samples\.knots: .*E0704.*shape \(rows, 3\)"):
        model.read(path)


def test_lists_are_described_as_declared(model: Any, curve: type[Model]) -> None:
    lines = list(describe(curve.compiled.layout))
    assert "  knots  [ref Knot in root.knots; 3]" in lines
    assert "  ends  [ref Knot in root.knots; 2]" in lines
    assert "[ref Knot; 2]" in model._sheet().html()
    assert "not set" in curve()._sheet().html()
    assert "[knots[3], knots[3], knots[1]]" in model.samples._sheet().html()


def test_a_stale_element_is_named(curve: type[Model], model: Any) -> None:
    model.knots.pop()
    with pytest.raises(AraelError, match=r"samples\[1\]\.knots\.0 is stale"):
        model.solve()


def test_runtime_formulas_read_elements(model: Any) -> None:
    model.residuals.add("2 * samples[0].knots[1].c - 3")
    assert model.cost() == pytest.approx((3 - 1) ** 2 + (3 + 3 + 1 - 2) ** 2 + (2 - 3) ** 2)
    with pytest.raises(AraelError, match=r"index 3 is outside"):
        model.residuals.add("samples[0].knots[3].c")
    with pytest.raises(AraelError, match=r"E0612"):
        model.residuals.add("sum(k in samples[0].knots) { k.c }")


NESTED = """
struct Knot { param c: real }
struct Spline { knots: list of Knot; samples: list of Sample }
struct Info {
    pair: [ref Knot in parent.parent.knots; 2]
    w: real
    constraint c { sum(k in pair) { k.c } - w }
}
struct Held { two: [ref Knot in parent.parent.knots; 2] }
struct Sample {
    info: Info?
    held: Held
    constraint m when info { info.pair[1].c - 2 * info.pair[0].c }
    constraint n { sum(i, k in held.two) { (1 + i) * k.c } }
}
root R { splines: list of Spline }
"""


@pytest.mark.parametrize("form", ["json", "npz"])
def test_lists_within_structs_held_by_value(form: str, tmp_path: Path) -> None:
    curves = arael.loads(NESTED, interpret=True)
    model: Any = curves()
    for first in (0.0, 1.0):
        spline = model.splines.append()
        spline.knots.extend(c=np.arange(4.0) + first)
        spline.samples.append(held={"two": [0, 1]}, info={"pair": [1, 2], "w": 3})
        spline.samples.append(held={"two": [spline.knots[3]] * 2}, info=None)
    rows = [[0, 1], [3, 3], [4, 5], [7, 7]]
    assert model.splines.samples.held.two.rows.tolist() == rows
    expected = [(c[1] + c[2] - 3, c[2] - 2 * c[1], c[0] + 2 * c[1], 3 * c[3])
                for c in (np.arange(4.0), np.arange(4.0) + 1)]  # fmt: skip
    assert model.cost() == pytest.approx(np.square(expected).sum())
    model.write(tmp_path / f"data.{form}")
    again: Any = curves()
    again.read(tmp_path / f"data.{form}")
    assert again.splines.samples.held.two.rows.tolist() == rows
    assert again.splines.samples.info.pair.rows.tolist() == [[1, 2], [-1, -1], [5, 6], [-1, -1]]
    assert again.cost() == pytest.approx(model.cost())
    again.splines[0].samples[1].info = {"pair": [2, 3], "w": 1}
    assert again.splines[0].samples[1].info.pair.index.tolist() == [2, 3]
    with pytest.raises(AraelError, match=r"held\.two\.0: .*is not in `parent\.parent\.knots`"):
        again.splines[0].samples[0].held.two = [again.splines[1].knots[0]] * 2
