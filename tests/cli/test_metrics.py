"""`arael metrics`, and trajectories and several files in `arael solve`, `check`, `diagnose`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arael import io, metrics
from tests.cli.conftest import Arael
from tests.metrics.cases import pair
from tests.optional import require

POSES = """\
struct Pose {
    param t: vec3 [m]
    param q: quaternion
    skip time: real [s] = 0
    constraint origin { t - [1, 2, 3] }
    constraint level { (q * q.conj()).vec + q.vec }
}
root Path { poses: list of Pose }
"""
TUM = "0.5 1 2 4 0 0 0 1\n1.5 2 2 3 0 0 0 1\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    reference, estimate = pair(1)
    io.write_trajectory(reference, "ref.tum")
    io.write_trajectory(estimate, "est.euroc")
    (tmp_path / "path.arael").write_text(POSES)
    (tmp_path / "path.tum").write_text(TUM)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_the_table_and_the_json_hold_the_same(arael: Arael) -> None:
    done = arael("metrics", "ref.tum", "est.euroc", "--align", "--scale", "--delta", "5")
    assert done.code == 0
    lines = done.out.splitlines()
    assert lines[2].split() == ["rmse", "mean", "median", "std", "min", "max", "sse"]
    assert [line.split("]")[0] for line in lines[3:]] == [
        "ATE translation [m",
        "ATE angle_deg [deg",
        "RPE translation [m",
        "RPE angle_deg [deg",
    ]
    found = arael("metrics", "ref.tum", "est.euroc", "--align", "--scale", "--delta", "5", "--json")
    reference, estimate = metrics.associate(
        io.read_trajectory("ref.tum"), io.read_trajectory("est.euroc")
    )
    assert lines[0] == f"{len(reference)} of 60 and 42 poses belong together"
    moved, alignment = metrics.align(estimate, reference, scale=True)
    assert found.json["alignment"]["scale"] == alignment.scale
    expected = metrics.rpe(reference, moved, delta=5).statistics.to_dict()
    assert found.json["rpe"]["translation"] == {**expected, "unit": "m"}
    assert f"{expected['rmse']:.6g}" in lines[5]


@pytest.mark.parametrize(
    ("options", "aligned"),
    [((), "none"), (("--origin",), "origin"), (("--scale",), "scale"), (("--align",), "rigid")],
)
@pytest.mark.usefixtures("folder")
def test_each_alignment(arael: Arael, options: tuple[str, ...], aligned: str) -> None:
    found = arael("metrics", "ref.tum", "est.euroc", "--part", "full", "--json", *options).json
    assert (found["alignment"] is None) == (aligned == "none")
    assert list(found["ate"]) == ["full"]
    if aligned == "scale":
        assert found["alignment"]["translation"] == [0, 0, 0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ref.tum", "est.euroc", "--offset", "1000"), "E0729"),
        (("ref.tum", "absent.tum"), "no such file"),
        (("ref.tum", "path.arael"), "E0713"),
        (("ref.tum", "est.euroc", "--origin", "--align"), "--origin excludes"),
        (("ref.tum", "est.euroc", "--delta", "1e9", "--unit", "m"), "no pair of poses"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_wrong_arguments(arael: Arael, arguments: tuple[str, ...], words: str) -> None:
    done = arael("metrics", *arguments)
    assert done.code == 2 and words in done.err and "Traceback" not in done.err


# --- solve ---------------------------------------------------------------------------------------


@pytest.mark.usefixtures("folder")
def test_a_trajectory_is_solved_and_written(arael: Arael) -> None:
    done = arael("solve", "path.arael", "path.tum", "-o", "out.tum", "--interpret")
    assert done.code == 0, done.err
    found = io.read_trajectory("out.tum")
    assert found.positions.ravel().tolist() == pytest.approx([1, 2, 3] * 2, abs=1e-9)
    assert found.times.tolist() == [0.5, 1.5]  # type: ignore[union-attr]
    again = arael("solve", "path.arael", "out.tum", "-o", "out.euroc", "--interpret")
    assert again.code == 0 and io.read_trajectory("out.euroc").times.tolist() == [0.5, 1.5]  # type: ignore[union-attr]


def test_formats_and_fields_are_options(folder: Path, arael: Arael) -> None:
    (folder / "path.arael").write_text(
        POSES.replace("    skip time", "    skip seen: vec3 = [0, 0, 0]\n    skip time")
    )
    (folder / "path.dat").write_text(TUM)
    done = arael(
        "solve", "path.arael", "path.dat", "--format", "tum", "--fields", "position=t,rotation=q",
        "-o", "out.dat", "--output-format", "kitti", "--interpret",
    )  # fmt: skip
    assert done.code == 0, done.err
    assert len((folder / "out.dat").read_text().splitlines()) == 2
    done = arael("solve", "path.arael", "path.tum", "--fields", "position")
    assert done.code == 2 and "expected PART=FIELD" in done.err
    done = arael("solve", "path.arael", "path.tum", "--fields", "position=q", "--interpret")
    assert done.code == 2 and "E0724" in done.err


def test_values_that_a_trajectory_does_not_hold_are_noted(folder: Path, arael: Arael) -> None:
    (folder / "path.arael").write_text(
        POSES.replace("root Path {", "root Path { param s: real = 1; constraint u { s - 2 };")
    )
    done = arael("solve", "path.arael", "path.tum", "-o", "out.kitti", "--interpret")
    assert "note: out.kitti does not hold `s`" in done.err


def test_a_trajectory_gives_a_graph_its_initial_values(folder: Path, arael: Arael) -> None:
    (folder / "graph.g2o").write_text(
        "VERTEX_SE2 4 0 0 0\nVERTEX_SE2 5 7 7 0\nEDGE_SE2 4 5 1 0 0 100 0 0 100 0 400\n"
    )
    (folder / "start.tum").write_text("0 0 0 0 0 0 0 1\n1 1.5 0 0 0 0 0 1\n")
    files = ("graph.g2o", "start.tum", "--init", "file", "--interpret", "--json")
    done = arael("solve", "pose_graph_2d", *files)
    assert done.json["start_cost"] == pytest.approx(0.5**2 * 100)


TWO = """\
struct Pose { name: string; param x: real = 0; key name }
struct Scan { range: real; pose: ref Pose in root.poses; constraint c { pose.x - range } }
root Map { scans: list of Scan; poses: list of Pose }
"""


@pytest.fixture
def two(folder: Path) -> Path:
    (folder / "two.arael").write_text(TWO)
    (folder / "poses.csv").write_text("name\na\nb\n")
    (folder / "scans.csv").write_text("range,pose\n0.5,b\n1.5,a\n")
    (folder / "day2.csv").write_text("range,pose\n2.5,b\n1.5,a\n")
    return folder


@pytest.mark.usefixtures("two")
def test_each_data_file_fills_a_collection(arael: Arael) -> None:
    done = arael("solve", "two.arael", "scans.csv", "poses.csv", "--interpret", "--json",
                 "--show", "poses")  # fmt: skip
    assert done.code == 0, done.err
    assert done.json["data"] == ["scans.csv", "poses.csv"]
    assert [row["x"] for row in done.json["rows"]["poses"]] == pytest.approx([1.5, 0.5])
    done = arael("solve", "two.arael", "poses.csv", "scans=day2.csv", "--interpret", "--json",
                 "--show", "poses")  # fmt: skip
    assert [row["x"] for row in done.json["rows"]["poses"]] == pytest.approx([1.5, 2.5])


@pytest.mark.usefixtures("two")
def test_check_and_diagnose_take_several_files_too(arael: Arael) -> None:
    done = arael("check", "two.arael", "poses.csv", "scans.csv")
    assert done.code == 0 and "poses.csv, scans.csv: fits the model" in done.out
    assert arael("diagnose", "two.arael", "poses.csv", "scans.csv", "--json").code in (0, 1)


@pytest.mark.parametrize(
    ("files", "words"),
    [
        (("poses.csv", "scans.csv", "scans=day2.csv"), "E0727"),
        (("poses.csv", "day2.csv"), "E0713"),
        (("poses.csv", "scan=day2.csv"), "did you mean `scans`?"),
        (("poses.csv", "scans.csv", "--collection", "poses"), "of several write name=path"),
    ],
)
@pytest.mark.usefixtures("two")
def test_conflicts_are_named(arael: Arael, files: tuple[str, ...], words: str) -> None:
    done = arael("solve", "two.arael", *files, "--interpret")
    assert done.code == 2 and words in done.err


def test_a_single_file_may_have_its_collection_named(two: Path, arael: Arael) -> None:
    (two / "data.json").write_text(json.dumps({"scans": []}))
    done = arael("check", "two.arael", "data.json", "poses=poses.csv")
    assert done.code == 0 and "(0 scans, 2 poses)" in done.out
    (two / "second.csv").write_text("name\nc\n")
    done = arael("check", "two.arael", "poses=second.csv")
    assert done.code == 0 and "(0 scans, 1 poses)" in done.out


def test_solved_data_goes_to_tables(two: Path, arael: Arael) -> None:
    require("pyarrow")
    arguments = ("solve", "two.arael", "scans.csv", "poses.csv", "--interpret", "-o")
    done = arael(*arguments, "poses.parquet")
    assert done.code == 0, done.err
    done = arael(*arguments, "scans.parquet")
    assert done.code == 2 and "a Parquet file holds one collection, here `scans`" in done.err
    done = arael("solve", "two.arael", "poses.parquet", "scans.csv", "--interpret", "--json")
    assert done.json["start_cost"] == pytest.approx(0, abs=1e-20)
