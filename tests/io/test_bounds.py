"""Bounds of rows and components fixed by the data, in files and data frames."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.io.losses import beside, differences
from tests.optional import needs, require

TEXT = """
struct Pose {
    param pos: vec3 = [0, 0, 0]
    param ea: euler = [0, 0, 0]
    param gain: real in 0 .. 5 = 1
    param q: quaternion = [1, 0, 0, 0]
    constraint c { [pos - [1, 2, 3], ea, rotation_vector(q)] }
    constraint d { gain - 9 }
}

root R {
    param k: real in 0 .. 10 = 1
    param v: vec<5> = [0, 0, 0, 0, 0]
    poses: list of Pose
    constraint e { k - 20 }
    constraint f { v - [1, 2, 3, 4, 5] }
}
"""
KIND: Any = arael.loads(TEXT, interpret=True)


def _part(name: str) -> Any:
    require("pyarrow")
    return import_module(f"pyarrow.{name}")


def filled() -> Any:
    m = KIND()
    m.poses.extend(gain=[1, 1])
    m.k.high = None
    m.v.fixed = [True, False, False, False, False]
    m.v.low[2] = -2
    m.poses[1].pos = {"value": [0, 0, 0], "fixed": [True, False, True], "low": [-1, None, 0]}
    m.poses[1].pos.high = 5
    m.poses[0].q.fixed = True
    m.poses.ea.x.fixed = [False, True]
    m.poses.gain.high = [4, np.inf]
    return m


def state(m: Any, root: bool = True) -> list[Any]:
    poses = m.poses
    found = [poses.pos.low, poses.pos.high, poses.pos.fixed, poses.ea.fixed, poses.q.fixed]
    found += [poses.gain.low, poses.gain.high]
    if root:
        found += [m.k.low, m.k.high, m.v.low, m.v.high, m.v.fixed]
    return [np.asarray(one).tolist() for one in found]


HDF5 = pytest.param("data.h5", marks=needs("h5py"))


@pytest.mark.parametrize("name", ["data.json", "data.npz", "data.json.gz", HDF5])
def test_whole_models(name: str, tmp_path: Path) -> None:
    m, other = filled(), KIND()
    m.write(tmp_path / name)
    other.read(tmp_path / name)
    assert state(other) == state(m)
    other.write(tmp_path / f"again-{name}")
    again = KIND()
    again.read(tmp_path / f"again-{name}")
    assert state(again) == state(m)
    other.solve()
    assert np.round(other.poses.gain.value, 6).tolist() == [4, 9]
    assert np.round(other.poses.pos.value, 6).tolist() == [[1, 2, 3], [0, 2, 0]]


def test_csv(tmp_path: Path) -> None:
    m, other = filled(), KIND()
    m.write(tmp_path / "poses.csv")
    header, _, second = (tmp_path / "poses.csv").read_text().splitlines()
    assert "pos.x.fixed,pos.y.fixed,pos.z.fixed,pos.x.low" in header and "-inf" in second
    other.read(tmp_path / "poses.csv")
    assert state(other, root=False) == state(m, root=False)


@pytest.mark.parametrize("ending", ["parquet", "arrow"])
@needs("pyarrow")
def test_tables_of_arrow(ending: str, tmp_path: Path) -> None:
    """Flags of components and bounds were left out, without a word."""
    m, other = filled(), KIND()
    m.write(tmp_path / f"poses.{ending}")
    other.read(tmp_path / f"poses.{ending}")
    assert state(other, root=False) == state(m, root=False)
    table = _part("feather").read_table if ending == "arrow" else _part("parquet").read_table
    frame = table(tmp_path / f"poses.{ending}")
    assert frame.column("pos.x.low").to_pylist() == [None, -1]
    assert frame.column("pos.x.fixed").to_pylist() == [False, True]


@needs("pyarrow")
def test_messages_about_arrow(tmp_path: Path) -> None:
    m = KIND()
    m.poses.extend(2)
    m.write(tmp_path / "poses.parquet")
    whole = _part("parquet").read_table(tmp_path / "poses.parquet")
    for title, values, code in [
        ("pos.x.low", [0, np.nan], "E0705"),
        ("pos.x.low", [1.0, -np.inf], ""),
        ("gain.low", [6.0, 0], "E0730"),
        ("pos.x.fixed", [True, None], "E0703"),
        ("q.fixed", [True, None], "E0703"),
        ("q.fixed", ["a", "b"], "E0703"),
        ("q.low", [0.0, 1.0], "E0701"),
    ]:
        table = whole.append_column(title, [values])
        _part("parquet").write_table(table, tmp_path / "poses.parquet")
        if not code:
            m.read(tmp_path / "poses.parquet")
            continue
        with pytest.raises(AraelError) as caught:
            m.read(tmp_path / "poses.parquet")
        assert caught.value.diagnostics[0].code == code, (title, values)
        assert title.split(".")[0] in str(caught.value)
        assert "poses.parquet: poses" in str(caught.value) or code == "E0705"


def test_a_frame_that_fixes_rows_and_components_fixes_both() -> None:
    frame = pd.DataFrame({"pos.fixed": [True, False], "pos.x.fixed": [False, True]})
    assert KIND(poses=frame).poses.pos.fixed.tolist() == [[True] * 3, [True, False, False]]


@pytest.mark.parametrize("what", ["low", "high", "fixed"])
def test_differences_name_bounds_and_flags(what: str) -> None:
    m, other = KIND(), KIND()
    for one in (m, other):
        one.poses.extend(2)
    assert differences(m._store, other._store) == []
    m.poses[1].pos = {"value": [0, 0, 0], what: [True, False, False] if what == "fixed" else 0}
    assert differences(m._store, other._store) == [f"`poses.pos.{what}`"]


def test_what_is_beside_a_collection_is_listed_with_bounds_and_flags() -> None:
    m = filled()
    lost = beside(m._store, m._store.tables["poses"], ["pos", "pos.low", "gain"])
    assert "`k.high` (1 row)" in lost and "`v.fixed` (1 row)" in lost and "`v.low` (1 row)" in lost
    assert "`poses.pos.fixed` (1 row)" in lost and "`poses.pos.high` (1 row)" in lost
    assert "`poses.gain.high` (2 rows)" in lost and "`poses.ea.fixed` (1 row)" in lost
    assert not any("pos.low" in one for one in lost)


def test_bounds_of_a_frame_that_leave_no_value_are_refused() -> None:
    with pytest.raises(AraelError, match=r"poses row 1: gain.*6 \.\. 5 leave no value") as caught:
        KIND(poses=pd.DataFrame({"gain": [1.0, 1.0], "gain.low": [np.nan, 6]}))
    assert caught.value.diagnostics[0].code == "E0730"


def test_data_frames() -> None:
    m = filled()
    frame = m.poses.to_pandas()
    assert np.isnan(frame["pos.x.low"][0]) and frame["pos.y.low"][1] == -np.inf
    assert state(KIND(poses=frame), root=False) == state(m, root=False)


def test_what_is_not_set_is_not_written(tmp_path: Path) -> None:
    m = KIND()
    m.poses.append()
    assert m.poses.gain.high.tolist() == [5]  # now a column
    m.poses.pos.fixed = [[True, False, False]]
    m.poses.pos.fixed = False
    for name in ("data.json", "poses.csv"):
        m.write(tmp_path / name)
        text = (tmp_path / name).read_text()
        assert "high" not in text and "fixed" not in text
    m.write(tmp_path / "data.npz")
    assert not [n for n in np.load(tmp_path / "data.npz") if "high" in n or "fixed" in n]


def test_reading_replaces_bounds(tmp_path: Path) -> None:
    m = filled()
    (tmp_path / "data.json").write_text('{"poses": [{"pos": {"value": [0, 0, 0], "low": -1}}]}')
    m.read(tmp_path / "data.json")
    assert m.k.high == 10 and m.v.fixed is False
    assert m.poses.pos.low.tolist() == [[-1] * 3] and m.poses.gain.high.tolist() == [5]


def test_nan_set_through_a_view_is_not_written(tmp_path: Path) -> None:
    m = filled()
    m.poses.gain.high[1] = np.nan
    for name in ("data.json", "data.npz", "poses.csv"):
        with pytest.raises(AraelError, match=r"poses\[1\].gain.high is NaN"):
            m.write(tmp_path / name)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ('{"k": {"value": 1, "low": "x"}}', "E0703", 'k.low: error[E0703]: expected numbers, '),
        ('{"k": {"value": 1, "low": 5, "high": 2}}', "E0730", "bounds 5 .. 2 leave no value"),
        ('{"k": {"value": 1, "low": 20}}', "E0730", "the bounds 20 .. 10 leave no value"),
        ('{"k": {"value": 1, "low": [1, 2]}}', "E0704", "expected a number, found shape (2,)"),
        ('{"k": {"value": 1, "lo": 1}}', "E0701", "only `value`, `fixed`, `low` and `high`"),
        ('{"v": {"value": [0, 0, 0, 0, 0], "fixed": [true]}}', "E0704", "expected 5 of true"),
        ('{"v": {"value": [0, 0, 0, 0, 0], "low": [0, 0, 0, 0, "a"]}}', "E0703", "v.low"),
        ('{"poses": [{"q": {"value": [1, 0, 0, 0], "low": 0}}]}', "E0703", "poses[0].q.low"),
        ('{"poses": [{"q": {"value": [1, 0, 0, 0], "fixed": [true]}}]}', "E0703", "q.fixed"),
        ('{"poses": [{}, {"ea": {"value": [0, 0, 0], "low": 0}}]}', "E0703", "poses[1].ea.low"),
    ],
)  # fmt: skip
def test_messages_about_json(text: str, code: str, words: str, tmp_path: Path) -> None:
    m = filled()
    (tmp_path / "data.json").write_text(text)
    with pytest.raises(AraelError) as caught:
        m.read(tmp_path / "data.json")
    assert caught.value.diagnostics[0].code == code and words in str(caught.value)
    assert state(m) == state(filled())


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("gain,gain.low,gain.high\n1,,\n1,4,2\n", "E0730", "poses.csv:3: gain"),
        ("gain,gain.low\n1,a\n", "E0703", 'expected a number or inf, found "a"'),
        ("gain,gain.low\n1,nan\n", "E0703", "poses.csv:2: gain.low"),
        ("q.w,q.x,q.y,q.z,q.w.low\n1,0,0,0,1\n", "E0703", "q.w.low: error[E0703]: only plain"),
        ("pos.x,pos.y,pos.z,pos.x.fixed\n1,2,3,x\n", "E0703", "pos.x.fixed"),
    ],
)
def test_messages_about_csv(text: str, code: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text(text)
    with pytest.raises(AraelError) as caught:
        KIND().read(tmp_path / "poses.csv")
    assert caught.value.diagnostics[0].code == code and words in str(caught.value)


def test_numbered_columns_of_csv(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("pos[0],pos[1],pos[2],pos[1].low,pos[2].fixed\n1,2,3,0,1\n")
    m = KIND()
    m.read(tmp_path / "poses.csv")
    assert m.poses.pos.low.tolist() == [[-np.inf, 0, -np.inf]]
    assert m.poses.pos.fixed.tolist() == [[False, False, True]]


@pytest.mark.parametrize(
    ("arrays", "code", "words"),
    [
        ({"k": 1.0, "k.low": np.nan}, "E0705", "k.low: error[E0705]: a bound is NaN"),
        ({"k": 1.0, "k.low": 3.0, "k.high": 1.0}, "E0730", "the bounds 3 .. 1 leave no value"),
        ({"k.low": np.zeros(3)}, "E0704", "found shape (3,)"),
        ({"v.fixed": np.array([True] * 4)}, "E0704", "v.fixed"),
        ({"k.lows": 1.0}, "E0701", "did you mean `k.low`?"),
        ({"poses.gain": np.ones(2), "poses.gain.low": np.array([1, 6])}, "E0730", "gain row 1"),
        ({"poses.q.low": np.zeros((0, 4))}, "E0703", "poses.q.low"),
    ],
)
def test_messages_about_archives(
    arrays: dict[str, Any], code: str, words: str, tmp_path: Path
) -> None:
    np.savez(tmp_path / "data.npz", **arrays)
    with pytest.raises(AraelError) as caught:
        KIND().read(tmp_path / "data.npz")
    assert caught.value.diagnostics[0].code == code and words in str(caught.value)
