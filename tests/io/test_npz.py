"""NPZ: columns by path; archives that lie are found out before they cost memory."""

import io as std_io
import pickle
import tracemalloc
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.io import files
from arael.runtime.store import Store
from tests.hand_layouts import odds, slam
from tests.io.cases import layout_of


def columns() -> dict[str, Any]:
    return {
        "gamma": 2.0,
        "poses.pos": np.arange(6.0).reshape(2, 3),
        "poses.pos.fixed": np.array([True, False]),
        "poses.ea": np.zeros((2, 3)),
        "poses.info.delta_pos": np.zeros((2, 3), np.float32),
        "poses.info.tilt_roll": np.array([1, 2]),
        "poses.info.gps": np.array([False, True]),
        "poses.info.gps.pos": np.array([[np.nan] * 3, [1, 2, 3]]),
        "poses.info.gps.cov_r": np.stack([np.eye(3)] * 2),
        "poses.info.features.offsets": np.array([0, 2, 3]),
        "poses.info.features.pixel": np.zeros((3, 2)),
        "landmarks.pos": np.zeros((2, 3)),
        "landmarks.name": np.array(["tree", "sign"]),
        "landmarks.frines.offsets": np.array([0, 1, 2]),
        "landmarks.frines.pose": np.array([0, 1]),
        "landmarks.frines.feature": np.array([1, 0]),
    }


def load(path: Path, arrays: dict[str, Any], layout: Any = slam) -> Store:
    np.savez(path, **arrays)
    store = Store(layout())
    io.read(store, path)
    return store


def test_columns_are_read_by_path(tmp_path: Path) -> None:
    store = load(tmp_path / "a.npz", columns())
    poses = store.tables["poses"]
    assert poses.column("pos").tolist() == [[0, 1, 2], [3, 4, 5]]
    assert poses.fixed("pos").tolist() == [True, False]
    assert poses.present("info.gps").tolist() == [False, True]
    assert store.tables["landmarks.frines"].target_rows("feature").tolist() == [1, 2]
    assert store.tables["landmarks"].column("name").tolist() == ["tree", "sign"]
    assert store.root.column("gamma").tolist() == [2.0]


@pytest.mark.parametrize(
    ("name", "value", "code", "words"),
    [
        ("poses.pso", np.zeros(2), "E0701", "poses.pso"),
        ("poses.ea", None, "E0702", "poses.ea"),
        ("poses.ea", np.zeros((2, 5)), "E0704", "poses.ea"),
        ("poses.ea", np.zeros((3, 3)), "E0704", "expected 2 rows, found shape (3, 3)"),
        ("poses.ea", np.array([["a"] * 3] * 2), "E0703", "poses.ea"),
        ("poses.ea", np.zeros((2, 3), bool), "E0703", "poses.ea"),
        ("poses.ea", np.array([[0, 0, 0], [0, np.inf, 0]]), "E0705", "poses.ea row 1"),
        ("poses.info.gps", np.array([1, 0]), "E0704", "expected 2 bools"),
        ("poses.pos.fixed", np.array([True]), "E0704", "poses.pos.fixed"),
        ("poses.info.features.offsets", np.array([0, 2]), "E0704", "expected 3 integers"),
        ("poses.info.features.offsets", np.array([0, 2, 1]), "E0704", "never decrease"),
        ("poses.info.features.offsets", np.array([0, 0, 2**60]), "E0704", "more rows than"),
        ("poses.info.features.offsets", None, "E0702", "offsets"),
        ("landmarks.frines.pose", np.array([0, 2]), "E0708", "index 2 is out of range"),
        ("landmarks.frines.pose", np.array([0, -1]), "E0707", "index -1 is negative"),
        ("landmarks.frines.pose", np.array([0.0, 1.0]), "E0704", "expected 2 integers"),
        ("landmarks.frines.pose", None, "E0702", "landmarks.frines.pose"),
        ("landmarks.name", np.array(["a", 3], dtype=object), "E0703", "Python objects"),
    ],
)
def test_each_mistake_is_named(
    tmp_path: Path, name: str, value: Any, code: str, words: str
) -> None:
    arrays = {**columns(), name: value}
    if value is None:
        del arrays[name]
    with pytest.raises(AraelError) as error:
        load(tmp_path / "a.npz", arrays)
    assert [d.code for d in error.value.diagnostics] == [code]
    assert words in str(error.value) and "a.npz" in str(error.value)


def archive(path: Path, member: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("gamma.npy", member)
    return path


def npy(head: str, body: bytes) -> bytes:
    text = head.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + body


@pytest.mark.parametrize(
    ("member", "code"),
    [
        (
            npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,)}", b"12"),
            "E0711",
        ),
        (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}", b""), "E0711"),
        (npy("{'descr': '|O', 'fortran_order': False, 'shape': ()}", pickle.dumps(3)), "E0703"),
        (npy("__import__('os')", b""), "E0711"),
        (npy("[" * 100, b""), "E0711"),
        (b"hello", "E0711"),
        (b"", "E0711"),
    ],
)
def test_archives_that_lie_are_refused(tmp_path: Path, member: bytes, code: str) -> None:
    path = archive(tmp_path / "a.npz", member)
    with pytest.raises(AraelError) as error:
        io.read(Store(slam()), path)
    assert [d.code for d in error.value.diagnostics] == [code]


def test_a_bomb_and_a_broken_archive_are_refused(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.npz", b"\0" * 50_000_000)
    assert path.stat().st_size < 100_000
    with pytest.raises(AraelError, match="E0714"):
        io.read(Store(slam()), path, limit=1_000_000)
    np.savez_compressed(path, **columns())
    whole = path.read_bytes()
    for cut in (whole[:-30], whole[:100] + b"x" * 40 + whole[140:], b"PK\x03\x04"):
        path.write_bytes(cut)
        with pytest.raises(AraelError, match="E0711"):
            io.read(Store(slam()), path)


def test_rows_made_in_any_order_are_written_by_parent(tmp_path: Path) -> None:
    store = load(tmp_path / "a.npz", columns())
    store.tables["poses.info.features"].append(0, pixel=[7, 8])
    store.tables["landmarks.frines"].append(0, pose=0, feature=2)
    io.write(store, tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as found:
        assert found["poses.info.features.offsets"].tolist() == [0, 3, 4]
        assert found["poses.info.features.pixel"][2].tolist() == [7, 8]
        assert found["landmarks.frines.feature"].tolist() == [1, 2, 0]
    again = Store(slam())
    io.read(again, tmp_path / "b.npz")
    rows = again.tables["landmarks.frines"].target_rows("feature")
    pixels = again.tables["poses.info.features"].column("pixel")[rows]
    assert pixels.tolist() == [[0, 0], [7, 8], [0, 0]]


def test_nested_of_nested_and_optional_values(tmp_path: Path) -> None:
    store = Store(odds())
    store.root.set_values("n", 0, 1, "n")
    cameras, bolts = store.tables["cameras"], store.tables["cameras.mount.bolts"]
    for i in range(3):
        mount = {"mount.t": [i, i, i]} if i else {}
        weight = {"weight": float(i)} if i == 1 else {}
        cameras.append(name=f"c{i}", q=[1, 0, 0, 0], th=0.0, **mount, **weight)
    bolts.extend(3, [2, 1, 2], size=[1.0, 2.0, 3.0])
    io.write(store, tmp_path / "a.npz")
    assert zipfile.ZipFile(std_io.BytesIO((tmp_path / "a.npz").read_bytes())).testzip() is None
    again = Store(odds())
    io.read(again, tmp_path / "a.npz")
    assert again.tables["cameras.mount.bolts"].column("size").tolist() == [2, 1, 3]
    assert again.tables["cameras.mount.bolts"].parent_rows().tolist() == [1, 2, 2]
    assert again.tables["cameras"].present("weight").tolist() == [False, True, False]
    assert again.tables["cameras"].present("twin").tolist() == [False] * 3


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"ps.count": np.array(10**9)}, "1000000000 rows"),
        ({"ps.x": np.zeros((10**9, 0))}, "1000000000 rows"),
        ({"ps.x": np.zeros(2), "ps.qs.offsets": np.array([0, 5, 10**12])}, "offsets declare"),
    ],
)
def test_announced_rows_are_checked_against_the_file(
    tmp_path: Path, arrays: dict[str, Any], words: str
) -> None:
    """Before any memory is reserved for them: 10^9 rows would take 32 GB."""
    model = """
        struct Q { y: real = 0 }
        struct P { x: real = 0; qs: list of Q }
        root R { ps: list of P }
    """
    np.savez_compressed(tmp_path / "a.npz", **arrays)
    assert (tmp_path / "a.npz").stat().st_size < 1000
    tracemalloc.start()
    try:
        with pytest.raises(AraelError, match=words):
            io.read(Store(layout_of(model)), tmp_path / "a.npz")
        assert tracemalloc.get_traced_memory()[1] < 10_000_000
    finally:
        tracemalloc.stop()


def test_rows_of_defaults_may_be_counted(tmp_path: Path) -> None:
    store = Store(layout_of("struct P { x: real = 3 }\nroot R { ps: list of P }"))
    np.savez_compressed(tmp_path / "a.npz", **{"ps.count": np.array(1000)})
    io.read(store, tmp_path / "a.npz")
    assert store.tables["ps"].column("x").tolist() == [3.0] * 1000


def test_an_archive_that_unpacks_beyond_the_limit(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", **{"poses.pos": np.zeros((100_000, 3))})
    assert (tmp_path / "a.npz").stat().st_size < 10_000
    with pytest.raises(AraelError) as failure:
        io.read(Store(slam()), tmp_path / "a.npz", limit=1_000_000)
    assert [d.code for d in failure.value.diagnostics] == ["E0714"]


@pytest.mark.parametrize("second", ["gamma.npy", "gamma"])
def test_a_column_twice_is_refused(tmp_path: Path, second: str) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name, value in (("gamma.npy", 1.0), (second, 2.0)):
            memory = std_io.BytesIO()
            np.save(memory, np.array(value))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # zipfile warns of the second
                archive.writestr(name, memory.getvalue())
    with pytest.raises(AraelError, match="`gamma` twice") as failure:
        io.read(Store(slam()), tmp_path / "a.npz")
    assert failure.value.diagnostics[0].code == "E0718"


@pytest.mark.parametrize(
    ("units", "code"),
    [([0xD800, 65], "E0703"), ([0x110000, 65], "E0711"), ([2**32 - 1, 0], "E0711")],
)
def test_text_that_is_no_text(tmp_path: Path, units: list[int], code: str) -> None:
    model = "struct P { name: string }\nroot R { ps: list of P }"
    names = np.array(units, np.uint32).view("<U2")
    np.savez(tmp_path / "a.npz", **{"ps.name": names})
    with pytest.raises(AraelError) as failure:
        io.read(Store(layout_of(model)), tmp_path / "a.npz")
    assert [d.code for d in failure.value.diagnostics] == [code]


def test_reading_reserves_memory_for_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"gamma": 2}')
    tracemalloc.start()
    try:
        assert files.read_bytes(tmp_path / "a.json") == b'{"gamma": 2}'
        assert tracemalloc.get_traced_memory()[1] < 10_000_000
    finally:
        tracemalloc.stop()
