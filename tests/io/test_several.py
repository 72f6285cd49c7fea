"""Several data files for one model."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.io.several import split
from arael.runtime.store import Store
from tests.io.cases import layout_of

MODEL = """
struct Pose { name: string; param x: real; key name }
struct Scan { range: real; pose: ref Pose in root.poses; constraint c { pose.x - range } }
root Map { scans: list of Scan; poses: list of Pose; scale: real = 2 }
"""
POSES = "name,x\na,1\nb,2\n"
SCANS = "range,pose\n0.5,b\n1.5,a\n"
WHOLE = '{"poses": [{"name": "z", "x": 5}], "scans": [], "scale": 3}'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("poses.csv", POSES), ("scans.csv", SCANS), ("map.json", WHOLE)):
        (tmp_path / name).write_text(text)
    return tmp_path


def store() -> Store:
    return Store(layout_of(MODEL))


@pytest.mark.parametrize("paths", [["poses.csv", "scans.csv"], ["scans.csv", "poses.csv"]])
@pytest.mark.usefixtures("folder")
def test_each_file_fills_the_collection_of_its_name(paths: list[str]) -> None:
    # The scans refer to poses by name: poses are read first, in whatever order they are given.
    found = store()
    io.read_several(found, paths)
    assert found.tables["poses"].column("x").tolist() == [1, 2]
    assert found.tables["scans"].target_rows("pose").tolist() == [1, 0]


def test_names_map_files_to_collections(folder: Path) -> None:
    (folder / "day2.csv").write_text(SCANS)
    found = store()
    io.read_several(found, {"poses": "poses.csv", "scans": "day2.csv"})
    assert found.tables["scans"].size == 2
    again = store()
    io.read_several(again, ["poses.csv", ("scans", "day2.csv")])
    assert again.tables["scans"].size == 2


@pytest.mark.usefixtures("folder")
def test_the_whole_model_is_read_first() -> None:
    found = store()
    io.read_several(found, ["scans.csv", "map.json", "poses.csv"])
    assert found.root.column("scale").tolist() == [3]
    assert found.tables["poses"].column("x").tolist() == [1, 2]
    assert found.tables["scans"].size == 2


@pytest.mark.parametrize(
    ("second", "words"),
    [
        ("poses.tsv", "the file holds the collection `poses`, as does poses.csv"),
        ("poses=scans.csv", "the file holds the collection `poses`, as does poses.csv"),
    ],
)
def test_two_files_of_one_collection_are_named(folder: Path, second: str, words: str) -> None:
    (folder / "poses.tsv").write_text("name\tx\nc\t3\n")
    with pytest.raises(AraelError, match="E0727") as failure:
        io.read_several(store(), ["poses.csv", split(second)])
    assert words in str(failure.value)


def test_two_files_of_the_whole_model_are_named(folder: Path) -> None:
    (folder / "other.json").write_text(WHOLE)
    with pytest.raises(AraelError, match=r"E0727.*the whole model, as does map.json"):
        io.read_several(store(), ["map.json", "other.json"])
    with pytest.raises(AraelError, match=r"E0713.*whole model, not the collection `poses`"):
        io.read_several(store(), {"poses": "map.json"})


def test_nothing_changes_after_an_error(folder: Path) -> None:
    found = store()
    io.read_several(found, ["map.json"])
    (folder / "scans.csv").write_text("range,pose\n0.5,absent\n")
    with pytest.raises(AraelError, match=r"E0708.*"):
        io.read_several(found, ["poses.csv", "scans.csv"])
    assert found.tables["poses"].column("x").tolist() == [5]


def test_an_unknown_collection_is_named(folder: Path) -> None:
    (folder / "posse.csv").write_text(POSES)
    with pytest.raises(AraelError, match=r"E0713") as failure:
        io.read_several(store(), ["posse.csv", "scans.csv"])
    assert "did you mean `poses`?" in str(failure.value)


def test_arguments_are_split_at_the_sign(folder: Path) -> None:
    assert split("scans=a=b.csv") == ("scans", "a=b.csv")
    assert split("./x=1.csv") == (None, "./x=1.csv")
    (folder / "x=1.csv").write_text(SCANS)
    assert split("x=1.csv") == (None, "x=1.csv")  # a file of this name exists
    assert split("plain.csv") == (None, "plain.csv")
