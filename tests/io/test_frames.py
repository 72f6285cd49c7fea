"""Data frames: to pandas and xarray, and back, nothing lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Gps { at: vec3; sigma: real = 1 }
struct Pose {
    param pos: vec3 [m]
    param att: quaternion
    gps: Gps?
    weight: real?
    skip name: string = "p"
    good: bool = true
    count: int = 0
    m: mat2 = [1, 0, 0, 1]
    prev: ref Pose in root.poses?
    marks: list of Mark
    constraint near { pos - [1, 2, 3] }
}
struct Mark { at: real; pose: ref Pose in root.poses }
root Path { poses: list of Pose; param scale: real = 2 }
"""


@pytest.fixture
def path() -> arael.Model:
    found = arael.loads(TEXT, interpret=True)()
    q = [0.5, 0.5, 0.5, 0.5]
    a = found.poses.append(pos=[1, 2, 3], att=q, gps={"at": [7, 8, 9]}, weight=2, name="a")
    b = found.poses.append(pos=[4, 5, 6], att=q, prev=a, good=False, count=3)
    a.marks.append(at=1.5, pose=b)
    b.marks.extend(at=[2.5, 3.5], pose=[0, 1])
    found.poses[1].pos.fixed = True
    return found


def test_columns_are_named_as_in_csv_files(path: arael.Model) -> None:
    frame = path.poses.to_pandas()
    assert list(frame.columns) == [
        *("pos.x", "pos.y", "pos.z", "pos.fixed", "att.w", "att.x", "att.y", "att.z"),
        *("weight", "name", "good", "count", "m[0][0]", "m[0][1]", "m[1][0]", "m[1][1]"),
        *("prev", "gps.at.x", "gps.at.y", "gps.at.z", "gps.sigma"),
    ]
    assert frame["pos.y"].tolist() == [2, 5]
    assert frame["pos.fixed"].tolist() == [False, True]
    assert frame["gps.at.z"][0] == 9 and np.isnan(frame["gps.at.z"][1])
    assert frame["prev"].isna().tolist() == [True, False] and frame["prev"][1] == 0
    assert frame["name"].tolist() == ["a", "p"]


def test_a_frame_is_a_copy(path: arael.Model) -> None:
    frame = path.poses.to_pandas()
    frame.loc[0, "pos.x"] = 100.0
    assert path.poses[0].pos.value[0] == 1


def test_what_goes_out_comes_in(path: arael.Model) -> None:
    other = type(path)()
    other.poses.extend(path.poses.to_pandas())
    other.poses.marks.extend(path.poses.marks.to_pandas())
    for one, two in ((path, other), (other, path)):
        pd.testing.assert_frame_equal(one.poses.to_pandas(), two.poses.to_pandas())
        pd.testing.assert_frame_equal(one.poses.marks.to_pandas(), two.poses.marks.to_pandas())
    assert other.poses[0].gps is not None and other.poses[1].gps is None
    assert other.poses[0].weight == 2 and other.poses[1].weight is None
    assert other.poses[1].prev == other.poses[0] and other.poses[0].prev is None
    assert [len(p.marks) for p in other.poses] == [1, 2]


def test_a_selection_keeps_its_row_numbers(path: arael.Model) -> None:
    frame = path.poses[1:].to_pandas()
    assert frame.index.tolist() == [1] and frame["pos.x"].tolist() == [4]
    assert path.poses[1].marks.to_pandas()["at"].tolist() == [2.5, 3.5]
    assert path.poses[1].marks.to_pandas()["parent"].tolist() == [1, 1]


def test_a_model_is_made_from_frames_or_arrays() -> None:
    text = "struct P { x: real; y: real }\nroot Line { param a: real = 0; ps: list of P\n"
    line = arael.loads(text + "constraint c { a - 1 } }", interpret=True)
    frame = pd.DataFrame({"x": [0, 1, 2], "y": [1.0, 3, 5]})
    for data in (frame, {"x": [0, 1, 2], "y": [1, 3, 5]}, frame.to_dict("records")):
        made = line(ps=data)
        assert made.ps.y.tolist() == [1, 3, 5] and made.ps.x.tolist() == [0, 1, 2]


class Plain:
    """Columns as polars has them: without an index, missing values as None."""

    def __init__(self, **columns: Any) -> None:
        self._columns = {k: np.asarray(v) for k, v in columns.items()}
        self.columns = list(columns)
        self.shape = (len(next(iter(self._columns.values()))), len(columns))

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]


def test_other_frames_do_as_well(path: arael.Model) -> None:
    frame = Plain(
        **{"pos.x": [1, 2], "pos.y": [3, 4], "pos.z": [5, 6]},
        **{"att.w": [1, 1], "att.x": [0, 0], "att.y": [0, 0], "att.z": [0, 0]},
        weight=np.array([None, 4.0], dtype=object),
    )
    path.poses.extend(frame)
    assert path.poses[2].weight is None and path.poses[3].weight == 4
    assert path.poses[3].pos.value.tolist() == [2, 4, 6]


@pytest.mark.parametrize(
    ("change", "code", "text"),
    [
        (lambda f: f.rename(columns={"pos.x": "pos.u"}), "E0702", "`pos.x` is missing"),
        (lambda f: f.assign(weigth=1.0), "E0701", "did you mean `weight`"),
        (lambda f: f.assign(**{"pos.x": [np.nan, 1]}), "E0705", "pos"),
        (lambda f: f.assign(**{"att.w": [9.0, 1]}), "E0721", "att"),
        (lambda f: f.assign(count=["a", "b"]), "E0703", "count"),
        (lambda f: f.assign(prev=[5, 0]), "E0708", "prev"),
        (lambda f: f.assign(prev=[0.5, None]), "E0703", "`prev` must be row numbers, found 0.5"),
        (lambda f: f.assign(weight=[[1], [2]]), "E0703", "`weight` must be numbers"),
        (lambda f: pd.concat([f, f[["good"]]], axis=1), "E0718", "`good` is given twice"),
    ],
)
def test_a_wrong_frame_is_reported_and_changes_nothing(
    path: arael.Model, change: Any, code: str, text: str
) -> None:
    with pytest.raises(AraelError, match=code) as raised:
        path.poses.extend(change(path.poses.to_pandas()))
    assert text in str(raised.value)
    assert len(path.poses) == 2


@pytest.mark.parametrize(
    ("parents", "code"), [(["a", 0], "E0703"), ([0, 0.5], "E0703"), ([0, None], "E0424")]
)
def test_a_wrong_parent_is_reported(path: arael.Model, parents: list[Any], code: str) -> None:
    with pytest.raises(AraelError, match=code):
        path.poses.marks.extend(pd.DataFrame({"at": [1.0, 2.0], "pose": 0, "parent": parents}))
    assert len(path.poses.marks) == 3


def test_datasets_have_dimensions_and_units(path: arael.Model) -> None:
    data = path.poses.to_xarray()
    assert isinstance(data, xr.Dataset)
    assert data["pos"].dims == ("row", "pos_i") and data["pos"].attrs == {"units": "m"}
    assert data["att"].sel(att_i="w").values.tolist() == [0.5, 0.5]
    assert data["m"].shape == (2, 2, 2) and data["prev"].values.tolist() == [-1, 0]
    assert np.isnan(data["gps.at"].values[1]).all()


def test_refs_have_indices(path: arael.Model) -> None:
    assert path.poses.marks.pose.index.tolist() == [1, 0, 1]
    assert path.poses.prev.index.tolist() == [-1, 0]
    assert path.poses.marks.refs.index.tolist() == [0, 0, 1]


def test_without_pandas_the_message_says_how_to_get_it(
    path: arael.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(AraelError, match="E0868") as raised:
        path.poses.to_pandas()
    assert "pip install 'arael[frames]'" in str(raised.value)


def test_parameters_calculate_as_their_values(path: arael.Model) -> None:
    assert float(path.scale) == 2.0
    assert path.scale * 3 == 6.0 and 1 - path.scale == -1.0 and -path.scale == -2.0
    assert path.scale > 1.5 and path.scale == 2
    assert f"{path.scale:.2f}" == "2.00"
    assert np.sqrt(path.scale) == pytest.approx(2**0.5)
    np.testing.assert_array_equal(path.poses.pos[:, 0] + 1, [2, 5])
    np.testing.assert_array_equal(path.poses.pos - path.poses[0].pos, [[0, 0, 0], [3, 3, 3]])
    path.scale = path.scale * 2
    assert path.scale.value == 4.0
    with pytest.raises(TypeError):
        float(path.poses.pos)
