"""Parquet, Arrow and HDF5: round trips, other writers, messages."""

from __future__ import annotations

import re
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.io.losses import differences
from arael.io.packages import EXTRAS
from arael.runtime.store import Store
from tests.io.cases import layout_of
from tests.optional import PARTS, needs, require

MODEL = """
struct Fix { at: vec2; sigma: real = 1 }
struct Scan { range: real [m]; from: ref Pose in root.poses; other: ref Pose in root.poses? }
struct Pose {
    name: string
    key name
    param t: vec3 [m]
    param q: quaternion
    count: int = 3
    good: bool = true
    fix: Fix?
    weight: real?
    constraint origin { t }
}
root Map { poses: list of Pose; scans: list of Scan; scale: real = 2 }
"""


def parquet() -> Any:
    """The module of pyarrow that reads and writes Parquet."""
    require("pyarrow")
    return import_module("pyarrow.parquet")


def filled() -> Store:
    store = Store(layout_of(MODEL))
    store.tables["poses"].extend(
        3,
        name=["a", "b", "ü"],
        t=np.arange(9.0).reshape(3, 3) / 7,
        q=[[1, 0, 0, 0], [0, 1, 0, 0], [0.6, 0, 0.8, 0]],
        count=[1, 2**62, -5],
        good=[True, False, True],
        **{
            "fix": np.array([True, False, True]),
            "fix.at": np.arange(6.0).reshape(3, 2),
            "weight": np.array([1.5, 0, 0]),
            "weight?": np.array([True, False, False]),
            "t.fixed": np.array([False, True, False]),
        },
    )
    store.tables["scans"].extend(2, **{"range": [1.5, 2.5], "from": [0, 2], "other": [-1, 1]})
    return store


@pytest.mark.parametrize("ending", ["parquet", "arrow", "feather"])
@pytest.mark.parametrize("collection", ["poses", "scans"])
@needs("pyarrow")
def test_a_collection_written_and_read_again_is_the_same(
    tmp_path: Path, ending: str, collection: str
) -> None:
    store, again = filled(), filled()
    path = tmp_path / f"{collection}.{ending}"
    io.write(store, path)
    again.tables[collection].clear()
    if collection == "poses":
        again.tables["scans"].clear()
        store.tables["scans"].clear()
    io.read(again, path)
    assert differences(store, again) == []


@needs("pyarrow")
def test_columns_are_those_of_csv_and_others_read_them(tmp_path: Path) -> None:
    pq = parquet()
    store = filled()
    io.write(store, tmp_path / "poses.parquet")
    io.write(store, tmp_path / "poses.csv")
    table = pq.read_table(tmp_path / "poses.parquet")
    head = (tmp_path / "poses.csv").read_text().splitlines()[0]
    assert table.column_names == head.split(",")
    assert table.column("t.y").to_pylist() == store.tables["poses"].column("t")[:, 1].tolist()
    assert table.column("weight").to_pylist() == [1.5, None, None]
    feather = import_module("pyarrow.feather")
    io.write(store, tmp_path / "poses.feather")
    assert feather.read_table(tmp_path / "poses.feather").equals(table)


@needs("pyarrow")
def test_what_pyarrow_writes_is_read(tmp_path: Path) -> None:
    pa, pq = require("pyarrow"), parquet()
    columns = {
        "range": pa.array([1, 2, 3], pa.int32()),
        "from": pa.array(["a", "b", "ü"]).dictionary_encode(),
        "other": pa.array([None, 0, 1], pa.int64()),
    }
    store = filled()
    pq.write_table(pa.table(columns), tmp_path / "scans.parquet", row_group_size=2)
    io.read(store, tmp_path / "scans.parquet")
    scans = store.tables["scans"]
    assert scans.column("range").tolist() == [1, 2, 3]
    assert scans.target_rows("from").tolist() == [0, 1, 2]
    assert scans.target_rows("other").tolist() == [-1, 0, 1]


WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({"range": [1.0]}, "E0702", "`from` is missing"),
    ({"range": [1.0], "from": [0], "rnge": [1.0]}, "E0701", "no field `rnge`"),
    ({"range": [float("nan")], "from": [0]}, "E0705", "scans.parquet: range row 0"),
    ({"range": ["x"], "from": [0]}, "E0703", "range"),
    ({"range": [1.0], "from": [3]}, "E0708", "scans.parquet: "),
    ({"range": [None], "from": [0]}, "E0703", "range"),
    ({"range": [[1.0, 2.0]], "from": [0]}, "E0703", "found list<"),
]


@pytest.mark.parametrize(("columns", "code", "words"), WRONG, ids=[w[2] for w in WRONG])
@needs("pyarrow")
def test_wrong_tables_are_named_and_change_nothing(
    tmp_path: Path, columns: dict[str, Any], code: str, words: str
) -> None:
    pa, pq = require("pyarrow"), parquet()
    pq.write_table(pa.table(columns), tmp_path / "scans.parquet")
    store = filled()
    with pytest.raises(AraelError) as failure:
        io.read(store, tmp_path / "scans.parquet")
    text = str(failure.value)
    assert failure.value.diagnostics[0].code == code and words in text and "scans.parquet" in text
    assert differences(store, filled()) == []


@needs("pyarrow")
def test_a_column_twice_is_refused(tmp_path: Path) -> None:
    pa, pq = require("pyarrow"), parquet()
    table = pa.Table.from_arrays([pa.array([1.0]), pa.array([2.0])], names=["range", "range"])
    pq.write_table(table, tmp_path / "scans.parquet")
    with pytest.raises(AraelError, match="E0718"):
        io.read(filled(), tmp_path / "scans.parquet")


@needs("pyarrow")
def test_a_small_file_with_many_rows_is_refused(tmp_path: Path) -> None:
    pa, pq = require("pyarrow"), parquet()
    rows = 2_000_000  # some kilobytes, since all values are equal
    pq.write_table(pa.table({"range": np.zeros(rows)}), tmp_path / "scans.parquet")
    assert (tmp_path / "scans.parquet").stat().st_size < 1_000_000
    with pytest.raises(AraelError, match="E0714"):
        io.read(filled(), tmp_path / "scans.parquet", limit=10_000_000)


@pytest.mark.parametrize("ending", ["parquet", "arrow", "h5"])
def test_any_cut_of_a_file_is_refused(tmp_path: Path, ending: str) -> None:
    require("h5py" if ending == "h5" else "pyarrow")
    store = filled()
    io.write(store, tmp_path / f"poses.{ending}")
    content = (tmp_path / f"poses.{ending}").read_bytes()
    path = tmp_path / f"cut.{ending}"
    options: dict[str, Any] = {} if ending == "h5" else {"collection": "poses"}
    for end in range(1, len(content) - 1, max(1, len(content) // 60)):
        path.write_bytes(content[:end])
        with pytest.raises(AraelError) as failure:
            io.read(store, path, **options)
        assert failure.value.diagnostics[0].code in ("E0711", "E0712")
    assert differences(store, filled()) == []


@pytest.mark.parametrize("ending", ["parquet", "arrow", "h5"])
def test_changed_bytes_are_read_or_refused(tmp_path: Path, ending: str) -> None:
    require("h5py" if ending == "h5" else "pyarrow")
    io.write(filled(), tmp_path / f"poses.{ending}")
    content = bytearray((tmp_path / f"poses.{ending}").read_bytes())
    rng = np.random.default_rng(0)
    path = tmp_path / f"changed.{ending}"
    options: dict[str, Any] = {} if ending == "h5" else {"collection": "poses"}
    for place in rng.integers(0, len(content), 60).tolist():
        changed = bytearray(content)
        changed[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(changed)
        try:
            io.read(filled(), path, **options)
        except AraelError as failure:
            assert failure.diagnostics


# --- HDF5 ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["h5", "hdf5"])
@needs("h5py")
def test_a_model_written_as_hdf5_and_read_again_is_the_same(tmp_path: Path, ending: str) -> None:
    store, again = filled(), Store(layout_of(MODEL))
    io.write(store, tmp_path / f"map.{ending}")
    io.read(again, tmp_path / f"map.{ending}")
    assert differences(store, again) == []
    assert (tmp_path / f"map.{ending}").read_bytes().startswith(b"\x89HDF")
    (tmp_path / "nameless").write_bytes((tmp_path / f"map.{ending}").read_bytes())
    io.read(again, tmp_path / "nameless")


@needs("h5py")
def test_h5py_reads_columns_and_units(tmp_path: Path) -> None:
    h5py = require("h5py")
    store = filled()
    io.write(store, tmp_path / "map.h5")
    with h5py.File(tmp_path / "map.h5") as file:
        assert file["poses.t"][()].tolist() == store.tables["poses"].column("t").tolist()
        assert file["poses.t"].attrs["units"] == "m"
        assert file["poses.name"].asstr()[()].tolist() == ["a", "b", "ü"]
        assert file["poses.t.fixed"][()].tolist() == [False, True, False]


def written(tmp_path: Path, **arrays: Any) -> Path:
    h5py = require("h5py")
    path = tmp_path / "map.h5"
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name.replace("__", "/")] = array
    return path


def test_groups_are_paths(tmp_path: Path) -> None:
    path = written(
        tmp_path, scale=5.0, poses__name=["a"], poses__t=[[1, 2, 3]], poses__q=[[1.0, 0, 0, 0]]
    )
    store = Store(layout_of(MODEL))
    io.read(store, path)
    assert store.root.column("scale").tolist() == [5]
    assert store.tables["poses"].column("t").tolist() == [[1, 2, 3]]


@pytest.mark.parametrize(
    ("arrays", "code", "words"),
    [
        ({"scale": [np.nan]}, "E0705", "scale"),
        ({"scle": [1.0]}, "E0701", "did you mean `scale`"),
        ({"scale": [[1.0, 2.0]]}, "E0704", "scale"),
        ({"poses__t": [[1.0, 2.0, 3.0]]}, "E0702", "poses.q"),
        ({"scale": np.array([1 + 2j])}, "E0703", "complex128"),
        ({"scale": [1.0], "poses__t": [1.0], "poses.t": [1.0]}, "E0718", "twice"),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_wrong_data_sets_are_named(
    tmp_path: Path, arrays: dict[str, Any], code: str, words: str
) -> None:
    store = filled()
    with pytest.raises(AraelError, match=code) as failure:
        io.read(store, written(tmp_path, **arrays))
    assert words in str(failure.value)
    assert differences(store, filled()) == []


def test_links_are_not_followed(tmp_path: Path) -> None:
    h5py = require("h5py")
    for link in (h5py.SoftLink("/other"), h5py.ExternalLink("other.h5", "/scale")):
        path = written(tmp_path, other=2.0)
        with h5py.File(path, "a") as file:
            file["scale"] = link
        with pytest.raises(AraelError, match=r"E0703.*not followed"):
            io.read(filled(), path)


def test_a_loop_of_groups_is_refused(tmp_path: Path) -> None:
    h5py = require("h5py")
    path = tmp_path / "loop.h5"
    with h5py.File(path, "w") as file:
        group = file.create_group("a")
        group["b"] = group  # a hard link to itself
    with pytest.raises(AraelError, match=r"E0711.*nested more than"):
        io.read(filled(), path)


def test_a_small_hdf5_file_with_large_content_is_refused(tmp_path: Path) -> None:
    h5py = require("h5py")
    path = tmp_path / "large.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("scale", shape=(10**12,), dtype="f8", chunks=(10**6,))
    with pytest.raises(AraelError, match="E0714"):
        io.read(filled(), path)


# --- without the packages ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "extra"),
    [
        ("poses.parquet", b"PAR1", "arrow"),
        ("poses.arrow", b"ARROW1", "arrow"),
        ("map.h5", b"\x89HDF\r\n\x1a\n", "hdf5"),
    ],
)
def test_messages_without_the_package_name_the_command(
    tmp_path: Path, name: str, content: bytes, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("pyarrow", "h5py"):
        monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / name).write_bytes(content)
    for act in (io.read, io.write):
        with pytest.raises(AraelError, match="E0725") as failure:
            act(filled(), tmp_path / name)
        assert f"pip install 'arael[{extra}]'" in str(failure.value)


@pytest.mark.parametrize(("package", "extra"), EXTRAS.items())
def test_the_extras_are_the_same_everywhere(package: str, extra: str) -> None:
    root = Path(__file__).parents[2]
    found = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    (requirement,) = found["optional-dependencies"][extra]
    assert requirement.startswith(package)
    assert f"pip install 'arael[{extra}]'" in (root / "docs" / "data.md").read_text()
    assert f'"{requirement}"' in (root / "noxfile.py").read_text()
    (extras,) = re.findall(r"<\(requirements_of ([^)]*)\)", (root / ".ci" / "run").read_text())
    assert extra in extras.split()
    assert f'"{package}", "{extra}"' in (root / "arael" / "cli" / "doctor.py").read_text()
    assert f"arael[{extra}]" in PARTS[package].install
