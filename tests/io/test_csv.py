"""CSV: one collection, a row a line."""
# ruff: noqa: E501 - a case, or a column, is one line

from pathlib import Path

import numpy as np
import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.runtime.store import Store
from tests.hand_layouts import data, layout, odds, param, slam, table


def line() -> Store:
    model = layout(
        "linear", "LinearModel",
        table("", "LinearModel", "root", param("a", "real"), data("sigma", "real", (0.01,))),
        table("data", "DataEntry", "list", data("x", "real"), data("y", "real"),
              data("p", "vec2", (0.0, 0.0)), data("n", "int", (7,))),
    )  # fmt: skip
    return Store(model)


def put(tmp_path: Path, text: str, name: str = "data.csv") -> Path:
    path = tmp_path / name
    path.write_text(text, newline="")
    return path


@pytest.mark.parametrize(
    "text", ["x,y\n1,2\n3,4e-1\n", "\ufeffx;y\r\n1;2\r\n3;0.4\r\n", "y\tx\n2\t1\n0.4\t3"]
)
def test_rows_are_read_into_the_only_collection(tmp_path: Path, text: str) -> None:
    store = line()
    io.read(store, put(tmp_path, text, "measured.csv"))
    table = store.tables["data"]
    assert table.column("x").tolist() == [1, 3] and table.column("y").tolist() == [2, 0.4]
    assert table.column("n").tolist() == [7, 7]
    io.read(store, put(tmp_path, "x,y,p.x,p.y,n\n1,2,3,4,5\n", "measured.csv"))
    assert table.size == 1 and table.column("p").tolist() == [[3, 4]]
    io.read(store, put(tmp_path, "x,y,p[0],p[1],n\n1,2,3,4,\n"))
    assert table.column("p").tolist() == [[3, 4]] and table.column("n").tolist() == [7]
    assert "a" in store.root.missing


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("x,y\n1,2\n3,abc\n", "E0703", 'data.csv:3: y: error[E0703]: expected a number, found "abc"'),
        ("x,y\n1,1_0\n", "E0703", "data.csv:2: y"),
        ("x,y\n1,2\n\n3,\n", "E0702", "data.csv:4: y: error[E0702]: the cell is empty"),
        ("x,y\n1,nan\n", "E0705", "data.csv:2: y"),
        ("x,y,n\n1,2,3.5\n", "E0703", "expected an integer"),
        ("x,y,n\n1,2,9223372036854775808\n", "E0706", "data.csv:2: n"),
        ("x,y\n1,2,3\n", "E0704", "data.csv:2: row: error[E0704]: expected 2 cells, found 3"),
        ("x,z\n1,2\n", "E0702", "the column `y` is missing"),
        ("x,y,p.x\n1,2,3\n", "E0702", "the column `p.y` is missing"),
        ("x,y,x\n1,2,3\n", "E0718", "`x` is given twice"),
        ('x,y\n1,"2\n', "E0711", "data.csv:2: error[E0711]: not CSV"),
        ("\n", "E0712", "empty"),
    ],
)  # fmt: skip
def test_each_mistake_is_named_and_the_old_rows_stay(
    tmp_path: Path, text: str, code: str, words: str
) -> None:
    store = line()
    store.tables["data"].append(x=9, y=9)
    with pytest.raises(AraelError) as error:
        io.read(store, put(tmp_path, text))
    assert error.value.diagnostics[0].code == code
    assert words in str(error.value)
    assert store.tables["data"].column("x").tolist() == [9]


def test_optionals_refs_keys_and_flags_go_there_and_back(tmp_path: Path) -> None:
    store = Store(odds())
    text = (
        "name,q.w,q.x,q.y,q.z,th,weight,twin,mount.t.x,mount.t.y,mount.t.z,mount.t.fixed\n"
        '"a,1",1,0,0,0,0.5,,,,,,false\n'
        'b,1,0,0,0,0.5,3,"a,1",1,2,3,true\n'
    )
    io.read(store, put(tmp_path, text), collection="cameras")
    cameras = store.tables["cameras"]
    assert cameras.present("weight").tolist() == [False, True]
    assert cameras.target_rows("twin").tolist() == [-1, 0]
    assert cameras.column("mount.t")[1].tolist() == [1, 2, 3]
    assert cameras.free("mount.t").tolist() == [False, False]
    io.write(store, tmp_path / "cameras.csv")
    again = Store(odds())
    io.read(again, tmp_path / "cameras.csv")
    for path in ("name", "q", "weight", "mount.t", "base"):
        assert again.tables["cameras"].column(path).tolist() == cameras.column(path).tolist()
    assert again.tables["cameras"].target_rows("twin").tolist() == [-1, 0]
    io.write(again, tmp_path / "again.csv", collection="cameras")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "cameras.csv").read_bytes()


def test_a_bad_ref_leaves_rows_and_handles_as_they_were(tmp_path: Path) -> None:
    store = Store(slam())
    poses = store.tables["poses"]
    poses.extend(
        2, pos=np.zeros((2, 3)), ea=[0, 0, 0], **{"info.delta_pos": [0, 0, 0], "info.tilt_roll": 0}
    )
    handle = store.tables["pose_pairs"].append(prev=0, cur=1)
    with pytest.raises(AraelError, match="E0708"):
        io.read(store, put(tmp_path, "prev,cur\n0,1\n1,2\n", "pose_pairs.csv"))
    assert store.tables["pose_pairs"].is_valid(handle)
    assert store.tables["pose_pairs"].target_rows("cur").tolist() == [1]


def test_which_collection_must_be_clear(tmp_path: Path) -> None:
    with pytest.raises(AraelError, match="which collection"):
        io.read(Store(slam()), put(tmp_path, "x\n1\n"))
    with pytest.raises(AraelError, match="no collection `pozes`"):
        io.read(Store(slam()), put(tmp_path, "x\n1\n"), collection="pozes")
