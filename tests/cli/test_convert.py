"""`arael convert`: whole or not at all, with a listing of what has no place in the target."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael as package
from arael import io
from arael.io.losses import differences
from tests.cli.conftest import Arael
from tests.io.test_bundles import bal, bundler, colmap
from tests.optional import require

GRAPH = """\
VERTEX_SE2 3 0 0 0
VERTEX_SE2 5 1.1 0.1 0.2
VERTEX_SE2 9 2 0.3 0.1
EDGE_SE2 3 5 1 0 0.5 100 1 2 110 3 400
EDGE_SE2 5 9 1 0 0 100 0 0 100 0 400
"""
TUM = "0.5 1 2 3 0 0 0 1\n1.5 2 2 3 0 0 0.6 0.8\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graph.g2o").write_text(GRAPH)
    (tmp_path / "path.tum").write_text(TUM)
    (tmp_path / "same.bal").write_text(bal())
    (tmp_path / "bundle.out").write_text(bundler())
    return tmp_path


def store(path: str | Path, model: str) -> object:
    instance = package.load(model, precision="f64", interpret=True)()  # type: ignore[call-arg]
    io.read(instance, path)
    return instance._store


@pytest.mark.parametrize("ending", ["json", "json.gz", "npz", "h5", "toro", "g2o"])
@pytest.mark.usefixtures("folder")
def test_a_graph_goes_out_and_back(arael: Arael, ending: str) -> None:
    if ending == "h5":
        require("h5py")
    done = arael("convert", "graph.g2o", f"there.{ending}")
    assert (done.code, done.out) == (0, f"wrote there.{ending}\n"), done.err
    back = arael("convert", f"there.{ending}", "back.g2o", "--model", "pose_graph_2d")
    assert back.code == 0, back.err
    before, after = store("graph.g2o", "pose_graph_2d"), store("back.g2o", "pose_graph_2d")
    assert differences(before, after) == []  # type: ignore[arg-type]


def test_toro_orders_its_information_otherwise(folder: Path, arael: Arael) -> None:
    arael("convert", "graph.g2o", "graph.toro")
    lines = (folder / "graph.toro").read_text().splitlines()
    assert lines[1] == "VERTEX2 5 1.1 0.1 0.2"
    numbers = np.array(lines[3].split()[3:], float)
    assert lines[3].startswith("EDGE2 3 5 ")
    assert numbers == pytest.approx([1, 0, 0.5, 100, 1, 110, 400, 2, 3], rel=1e-12)


def test_what_has_no_place_is_listed_and_nothing_written(folder: Path, arael: Arael) -> None:
    (folder / "poses.csv").write_text("old")
    done = arael("convert", "graph.g2o", "poses.csv")
    assert done.code == 2 and "E0728" in done.err and "`edges` (2 rows)" in done.err
    assert "--lossy" in done.err
    assert (folder / "poses.csv").read_text() == "old"
    done = arael("convert", "graph.g2o", "poses.csv", "--lossy")
    assert done.code == 0 and done.err == "note: left out: `edges` (2 rows)\n"
    head, *rows = (folder / "poses.csv").read_text().splitlines()
    assert head.startswith("t.x,t.y,t.fixed,th") and len(rows) == 3


def test_fixed_poses_have_no_place_in_toro(folder: Path, arael: Arael) -> None:
    (folder / "fixed.g2o").write_text(GRAPH + "FIX 5\n")
    done = arael("convert", "fixed.g2o", "fixed.toro")
    assert done.code == 2 and "E0722" in done.err and "no fixed poses" in done.err
    assert not (folder / "fixed.toro").exists()


def test_fixed_parameters_have_no_place_in_bal(folder: Path, arael: Arael) -> None:
    colmap(folder / "sparse")
    done = arael("convert", "sparse", "out.bal")
    assert done.code == 2 and "`cameras.k2.fixed`" in done.err and "the colours" in done.err
    assert not (folder / "out.bal").exists()
    done = arael("convert", "sparse", "out.bal", "--lossy", "--json")
    assert done.json["left_out"][-1] == "`cameras.k2.fixed`" and done.json["written"] == ["out.bal"]
    assert (done.json["from"], done.json["to"]) == ("colmap", "bal")
    assert store("out.bal", "bundle_adjustment")


def test_what_the_model_has_no_field_for_is_listed_separately(arael: Arael, folder: Path) -> None:
    done = arael("convert", "path.tum", "path.json")
    assert done.code == 2 and "`pose_graph_3d` has no field for times" in done.err
    assert not (folder / "path.json").exists()
    assert arael("convert", "path.tum", "path.json", "--lossy").code == 0


def test_bundler_to_bal(folder: Path, arael: Arael) -> None:
    done = arael("convert", "bundle.out", "out.bal", "--lossy")
    assert done.code == 0 and "note: left out: the colours of 3 points" in done.err
    assert (folder / "out.bal").read_text().startswith("2 3 4\n")


@pytest.mark.usefixtures("folder")
def test_bal_goes_through_json(arael: Arael) -> None:
    assert arael("convert", "same.bal", "same.json").code == 0
    assert arael("convert", "same.json", "back.bal", "--model", "bundle_adjustment").code == 0
    before, after = (store(path, "bundle_adjustment") for path in ("same.bal", "back.bal"))
    assert differences(before, after) == []  # type: ignore[arg-type]


def test_a_trajectory_needs_no_model(folder: Path, arael: Arael) -> None:
    assert arael("convert", "path.tum", "path.euroc").code == 0
    assert arael("convert", "path.euroc", "back.tum").code == 0
    found, expected = io.read_trajectory("back.tum"), io.read_trajectory("path.tum")
    assert found.stamps.tolist() == expected.stamps.tolist() == [500_000_000, 1_500_000_000]  # type: ignore[union-attr]
    assert found.positions.tolist() == expected.positions.tolist()
    done = arael("convert", "path.tum", "path.kitti")
    assert done.code == 2 and "no place for the times of 2 poses" in done.err
    assert arael("convert", "path.tum", "path.kitti", "--lossy").code == 0
    done = arael("convert", "path.kitti", "again.tum")
    assert done.code == 2 and "E0724" in done.err and "--times FILE" in done.err
    (folder / "times.txt").write_text("0.5\n1.5\n")
    assert arael("convert", "path.kitti", "again.tum", "--times", "times.txt").code == 0
    assert io.read_trajectory("again.tum").times.tolist() == [0.5, 1.5]  # type: ignore[union-attr]
    (folder / "times.txt").write_text("0.5\n")
    done = arael("convert", "path.kitti", "again.tum", "--times", "times.txt")
    assert done.code == 2 and "the file has 1 times for 2 poses" in done.err


def test_poses_of_a_graph_are_a_trajectory(folder: Path, arael: Arael) -> None:
    (folder / "times.txt").write_text("0\n1\n2\n")
    arguments = ("convert", "graph.g2o", "graph.tum", "--times", "times.txt")
    done = arael(*arguments)
    assert done.code == 2 and "`edges` (2 rows)" in done.err and "`poses.id`" in done.err
    assert arael(*arguments, "--lossy").code == 0
    found = io.read_trajectory("graph.tum")
    assert found.positions[:, :2].tolist() == [[0, 0], [1.1, 0.1], [2, 0.3]]


MODEL = """\
struct Point { x: real; y: real }
root Line {
    param a: real = 0
    points: list of Point
    fit points as p { a * p.x - p.y }
}
"""


@pytest.mark.parametrize("ending", ["csv", "parquet", "feather"])
def test_tables_are_converted_with_the_model(folder: Path, arael: Arael, ending: str) -> None:
    if ending != "csv":
        require("pyarrow")
    (folder / "line.arael").write_text(MODEL)
    (folder / "points.csv").write_text("x,y\n1,2\n3,4.5\n")
    done = arael("convert", "points.csv", f"there.{ending}")
    assert done.code == 2 and "--model MODEL" in done.err
    assert arael("convert", "points.csv", f"there.{ending}", "--model", "line.arael").code == 0
    assert arael("convert", f"there.{ending}", "back.csv", "--model", "line.arael").code == 0
    assert (folder / "back.csv").read_text() == "x,y\n1.0,2.0\n3.0,4.5\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("graph.g2o", "graph.xyz"), "E0713"),
        (("graph.g2o", "graph.out", "--output-format", "bundler"), "is not one of"),
        (("absent.g2o", "graph.json"), "no such file"),
        (("graph.g2o", "no/graph.json"), "E0853"),
        (("graph.g2o", "graph.bal"), "E0722"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_wrong_arguments(arael: Arael, arguments: tuple[str, ...], words: str) -> None:
    done = arael("convert", *arguments)
    assert done.code == 2 and words in done.err
