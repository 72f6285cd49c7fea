"""JSON in and out: what is right survives, what is wrong is named with its type and its place."""
# ruff: noqa: E501 - a case, or a column, is one line

import gzip
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.runtime.store import Store
from tests.hand_layouts import odds, slam

EYE = np.eye(3).tolist()


def slam_scene() -> dict[str, Any]:
    def feature(i: int) -> dict[str, Any]:
        return {"pixel": [i, i + 1], "camera": i}

    return {
        "gamma": 2.5,
        "poses": [
            {
                "pos": [0, 0, 0.5],
                "ea": {"value": [0, 0, 0], "fixed": True},
                "info": {
                    "delta_pos": [1, 2, 3],
                    "tilt_roll": 1e-3,
                    "gps": None,
                    "features": [feature(0), feature(1)],
                },
            },
            {
                "pos": {"value": [1, 1, 1]},
                "ea": [0.1, 0.2, 0.3],
                "info": {
                    "delta_pos": [1, 2, 3],
                    "tilt_roll": 2,
                    "gps": {"pos": [4, 5, 6], "cov_r": [list(row) for row in EYE]},
                    "features": [feature(2)],
                },
            },
        ],
        "landmarks": [
            {"pos": [1, 2, 3], "name": "tree", "frines": [{"pose": 1, "feature": 0}]},
            {"pos": [1, 2, 3], "frines": [{"pose": 0, "feature": 1}, {"pose": 0, "feature": 0}]},
        ],
        "pose_pairs": [{"prev": 0, "cur": 1}],
    }


def odds_scene() -> dict[str, Any]:
    camera = {"q": [1, 0, 0, 0], "th": 0.5}
    return {
        "n": 3,
        "global": {"q": [0.1, 0.2, 0.3]},
        "cameras": [
            {"name": "left", **camera, "weight": 2.0},
            {
                "name": "right",
                **camera,
                "twin": "left",
                "mount": {"t": [1, 2, 3], "bolts": [{"size": 5}]},
            },
        ],
        "views": [
            {"camera": "right", "ok": True, "count": 7},
            {"camera": 0, "ok": False, "count": -1},
        ],
    }


def put(path: Path, scene: Any) -> Path:
    path.write_text(scene if isinstance(scene, str) else json.dumps(scene))
    return path


def load(layout: Any, path: Path) -> Store:
    store = Store(layout)
    io.read(store, path)
    return store


def errors(layout: Any, path: Path) -> list[tuple[str, str]]:
    store = Store(layout)
    with pytest.raises(AraelError) as error:
        io.read(store, path)
    assert all(t.size == (p == "") for p, t in store.tables.items())
    return [(d.code, str(d)) for d in error.value.diagnostics]


def test_a_scene_is_read_into_columns(tmp_path: Path) -> None:
    store = load(slam(), put(tmp_path / "scene.json", slam_scene()))
    poses, frines = store.tables["poses"], store.tables["landmarks.frines"]
    assert poses.column("pos").tolist() == [[0, 0, 0.5], [1, 1, 1]]
    assert poses.fixed("ea").tolist() == [True, False]
    assert poses.present("info.gps").tolist() == [False, True]
    assert poses.column("info.gps.cov_r")[1].tolist() == EYE
    assert store.tables["poses.info.features"].parent_rows().tolist() == [0, 0, 1]
    assert frines.target_rows("pose").tolist() == [1, 0, 0]
    assert frines.target_rows("feature").tolist() == [2, 1, 0]
    assert frines.row_name(2) == "landmarks[1].frines[1]"
    assert store.root.column("gamma").tolist() == [2.5]
    assert store.tables["landmarks"].column("name").tolist() == ["tree", ""]


def test_rare_things_are_read(tmp_path: Path) -> None:
    store = load(odds(), put(tmp_path / "odds.json", odds_scene()))
    cameras = store.tables["cameras"]
    assert cameras.target_rows("twin").tolist() == [-1, 0]
    assert cameras.present("weight").tolist() == [True, False]
    assert cameras.present("mount.t").tolist() == [False, True]
    assert store.tables["cameras.mount.bolts"].parent_rows().tolist() == [1]
    assert store.tables["views"].target_rows("camera").tolist() == [1, 0]
    assert store.root.column("n").tolist() == [3] and not store.root.missing
    assert np.isclose(np.linalg.norm(store.root.column("global.q")[0]), 1)


@pytest.mark.parametrize("suffix", [".json", ".json.gz", ".npz"])
@pytest.mark.parametrize(("layout", "scene"), [(slam, slam_scene), (odds, odds_scene)])
def test_what_is_written_reads_back_as_the_same(
    tmp_path: Path, suffix: str, layout: Any, scene: Any
) -> None:
    first = load(layout(), put(tmp_path / "in.json", scene()))
    out = tmp_path / f"out{suffix}"
    io.write(first, out)
    second = load(layout(), out)
    for path, table in first.tables.items():
        again = second.tables[path]
        assert table.size == again.size
        for name, column in table.data.items():
            if column.role == "ref":
                assert table.target_rows(name).tolist() == again.target_rows(name).tolist()
            else:
                assert table.column(name).tolist() == again.column(name).tolist(), (path, name)
            assert table.present(name).tolist() == again.present(name).tolist()
            if column.role == "param":
                assert table.fixed(name).tolist() == again.fixed(name).tolist()
    again_out = tmp_path / f"again{suffix}"
    io.write(second, again_out)
    assert again_out.read_bytes() == out.read_bytes()


def test_single_precision_is_written_as_short_as_it_was_given(tmp_path: Path) -> None:
    scene = slam_scene()
    scene["gamma"] = 0.1
    store = load(slam("f32"), put(tmp_path / "in.json", scene))
    io.write(store, tmp_path / "out.json")
    assert json.loads((tmp_path / "out.json").read_text())["gamma"] == 0.1


def at(scene: Any, path: str, value: Any) -> Any:
    """The scene with one value replaced (or, with `...`, taken away)."""
    keys = [int(k) if k.isdigit() else k for k in path.split("/")]
    inner = scene
    for key in keys[:-1]:
        inner = inner[key]
    if value is ...:
        del inner[keys[-1]]
    else:
        inner[keys[-1]] = value
    return scene


@pytest.mark.parametrize(
    ("path", "value", "code", "words"),
    [
        ("poses/1/pos", [1, 2], "E0704", "scene.json: poses[1].pos: error[E0704]: expected 3 numbers, found 2"),
        ("poses/1/pos", "abc", "E0703", 'poses[1].pos: error[E0703]: expected vec3 [m] (3 numbers), found the string "abc"'),
        ("poses/1/pos", [1, 2, "3"], "E0703", 'poses[1].pos[2]: error[E0703]: expected a number, found the string "3"'),
        ("poses/1/pos", [1, 2, True], "E0703", "poses[1].pos[2]: error[E0703]: expected a number, found true"),
        ("poses/1/pos", [1, 2, None], "E0707", "poses[1].pos[2]"),
        ("poses/1/pos", None, "E0707", "poses[1].pos"),
        ("poses/1/pos", ..., "E0702", "poses[1]: error[E0702]: `pos` is missing"),
        ("poses/0/pso", 1, "E0701", "poses[0].pso"),
        ("poses/0/info", ..., "E0702", "`info` is missing"),
        ("poses/0/info", None, "E0707", "poses[0].info"),
        ("poses/0/info", 3, "E0703", "expected an object (`PoseInfo`), found the number 3"),
        ("poses/1/info/gps/cov_r", [[1, 0], [0, 1]], "E0704", "poses[1].info.gps.cov_r: error[E0704]: expected 3 rows, found 2"),
        ("poses/1/info/gps/cov_r/2", [1, 0], "E0704", "poses[1].info.gps.cov_r[2]"),
        ("poses/1/info/features/0/camera", 2**70, "E0706", "poses[1].info.features[0].camera"),
        ("poses/1/info/features/0/camera", 1.5, "E0706", "expected an integer, found the number 1.5"),
        ("poses/1/info/features/0/camera", False, "E0703", "found false"),
        ("poses/1/info/features", {}, "E0703", "expected an array (`list of PointFeature`)"),
        ("poses/1/ea", {"value": [0, 0, 0], "fixd": True}, "E0701", "no `fixd`"),
        ("poses/1/ea", {"value": [0, 0, 0], "fixed": 1}, "E0703", "poses[1].ea.fixed"),
        ("landmarks/1/frines/0/pose", 2, "E0708", "landmarks[1].frines[0].pose: error[E0708]: index 2 is out of range: `root.poses` has 2 rows"),
        ("landmarks/1/frines/0/pose", -1, "E0708", "index -1"),
        ("landmarks/1/frines/0/feature", 2, "E0708", "`pose.info.features` has 2 rows"),
        ("landmarks/1/frines/0/pose", None, "E0707", "landmarks[1].frines[0].pose"),
        ("landmarks/1/frines/0/pose", "a", "E0703", "expected the index of a `Pose`"),
        ("landmarks/1/name", 3, "E0703", "expected a string, found the number 3"),
        ("landmarks", 3, "E0703", "expected an array (`arena of PointLandmark`), found the number 3"),
        ("landmarks/0", 3, "E0703", "landmarks[0]: error[E0703]: expected an object (`PointLandmark`)"),
        ("landmarks/0/frines/0/row", 3, "E0701", "no field `row`"),
        ("gamma", "x", "E0703", "scene.json: gamma"),
    ],
)  # fmt: skip
def test_each_mistake_is_named(
    tmp_path: Path, path: str, value: Any, code: str, words: str
) -> None:
    found = errors(slam(), put(tmp_path / "scene.json", at(slam_scene(), path, value)))
    assert [c for c, _ in found] == [code]
    assert words in found[0][1]


def test_an_error_names_the_declaration_and_suggests(tmp_path: Path) -> None:
    scene = at(slam_scene(), "poses/1/pos", [1, 2])
    store = Store(slam())
    with pytest.raises(AraelError) as error:
        io.read(store, put(tmp_path / "scene.json", scene))
    (found,) = error.value.diagnostics
    assert found.notes == ("declared as `param pos: vec3 [m]` at model.arael:2:1",)
    with pytest.raises(AraelError) as error:
        io.read(store, put(tmp_path / "scene.json", at(slam_scene(), "poses/0/pso", 1)))
    assert error.value.diagnostics[0].help == ("did you mean `pos`?",)


def test_rare_mistakes_are_named(tmp_path: Path) -> None:
    for path, value, code, words in (
        ("n", 2**63, "E0706", "n: error"),
        ("n", ..., "E0702", "`n` is missing"),
        ("cameras/1/twin", "lefd", "E0708", 'whose `name` is "lefd"'),
        ("cameras/1/name", "left", "E0718", 'two rows have the key "left"'),
        ("cameras/0/q", [2, 0, 0, 0], "E0721", "its norm is 2"),
        ("cameras/0/base", [0, 0, 0, 0], "E0721", "cameras[0].base"),
        ("cameras/0/weight", "x", "E0703", "cameras[0].weight"),
        ("cameras/1/mount/t", [1], "E0704", "cameras[1].mount.t"),
        ("cameras/1/mount/bolts/0", {}, "E0702", "cameras[1].mount.bolts[0]"),
    ):
        found = errors(odds(), put(tmp_path / "odds.json", at(odds_scene(), path, value)))
        assert found[0][0] == code and words in found[0][1], (path, found)


def test_several_mistakes_in_one_run_but_not_without_end(tmp_path: Path) -> None:
    scene = slam_scene()
    scene["poses"][0]["pos"] = [1]
    scene["poses"][1]["info"]["tilt_roll"] = "x"
    scene["landmarks"][0]["color"] = 3
    found = errors(slam(), put(tmp_path / "scene.json", scene))
    assert sorted(c for c, _ in found) == ["E0701", "E0703", "E0704"]
    scene["poses"] *= 100
    assert len(errors(slam(), put(tmp_path / "scene.json", scene))) == 20


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ('{"poses": [{"pos": [1, 2', "E0711", "scene.json:1:24: error[E0711]: the JSON ends in the middle of `poses[0].pos[1]`"),
        ('{"gamma": 1,\n "poses": [}', "E0711", "scene.json:2:12"),
        ('{"gamma": NaN}', "E0705", "`gamma` is NaN"),
        ('{"poses": [{"pos": [0, -Infinity, 0]}]}', "E0705", "`poses[0].pos[1]` is -Infinity"),
        ('{"gamma": 1e999}', "E0706", "`gamma`: 1e999 does not fit a number"),
        ("[" * 100000, "E0711", "nested too deeply"),
        ("[]", "E0703", "expected an object, found an array of 0"),
        ('{"gamma": 1, "gamma": 2}', "E0718", "`gamma` is given twice"),
        ("", "E0712", "the file is empty"),
        ("  \n", "E0712", "the file is empty"),
        ('{"gamma": "\udcff"}', "E0711", "scene.json"),
        ('{"landmarks": [{"pos": [1,2,3], "name": "a:b"}]} x', "E0711", "trailing"),
    ],
)  # fmt: skip
def test_text_that_is_not_json_is_placed(tmp_path: Path, text: str, code: str, words: str) -> None:
    path = tmp_path / "scene.json"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    found = errors(slam(), path)
    assert found[0][0] == code and words in found[0][1]


def test_colons_in_strings_are_not_keys(tmp_path: Path) -> None:
    scene = slam_scene()
    scene["landmarks"][0]["name"] = 'a":b:c'
    load(slam(), put(tmp_path / "scene.json", scene))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert errors(slam(), tmp_path)[0][0] == "E0712"
    assert errors(slam(), tmp_path / "no.json")[0][0] == "E0712"
    (tmp_path / "a.xyz").write_text("hello")
    assert errors(slam(), tmp_path / "a.xyz")[0][0] == "E0713"
    packed = gzip.compress(json.dumps(slam_scene()).encode())
    (tmp_path / "cut.json.gz").write_bytes(packed[:-20])
    assert errors(slam(), tmp_path / "cut.json.gz")[0][0] == "E0712"
    (tmp_path / "bomb.json.gz").write_bytes(gzip.compress(b" " * 10_000_000))
    with pytest.raises(AraelError, match="E0714"):
        io.read(Store(slam()), tmp_path / "bomb.json.gz", limit=1_000_000)


def test_a_failed_write_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = load(slam(), put(tmp_path / "in.json", slam_scene()))
    out = tmp_path / "out.json"
    out.write_text("old")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(
        AraelError, match=r"E0715.*no space left on device; the old file is unchanged"
    ):
        io.write(store, out)
    assert out.read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in.json", "out.json"]


def test_numbers_that_json_cannot_hold_are_not_written(tmp_path: Path) -> None:
    store = load(slam(), put(tmp_path / "in.json", slam_scene()))
    store.tables["poses"].column("pos")[1, 2] = np.nan
    for suffix in ("json", "npz"):
        with pytest.raises(AraelError, match=r"poses\[1\].pos is NaN"):
            io.write(store, tmp_path / f"out.{suffix}")
        assert not (tmp_path / f"out.{suffix}").exists()
