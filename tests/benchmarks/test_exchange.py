"""Files of columns: what is written is read; a model's data come over as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import arael
from arael.scenes import PlaneConfig, fill, make_plane_scene
from benchmarks import exchange


def test_columns_come_back_as_they_were(tmp_path: Path) -> None:
    found = {
        "a.b": np.arange(6.0).reshape(2, 3) / 7,
        "seen": np.array([True, False]),
        "rows": np.array([3, -1, 2**40]),
        "none": np.zeros((0, 3)),
    }
    exchange.write(tmp_path / "x.columns", found)
    back = exchange.read(tmp_path / "x.columns")
    assert list(back) == list(found)
    for name, values in found.items():
        assert back[name].shape == values.shape
        np.testing.assert_array_equal(back[name], values)
    assert back["rows"].dtype == np.int64
    assert back["a.b"].dtype == np.float64


def test_the_head_is_text_and_the_values_follow(tmp_path: Path) -> None:
    path = tmp_path / "x.columns"
    exchange.write(path, {"t": np.array([[1.0, 2.0]]), "n": np.array([5])})
    head, _, rest = path.read_bytes().partition(b"\n\n")
    assert head == b"t f64 1 2\nn i64 1"
    assert rest == np.array([1.0, 2.0]).tobytes() + np.array([5]).tobytes()


def test_a_model_is_written_whole(tmp_path: Path) -> None:
    scene = make_plane_scene(PlaneConfig(poses=6))
    model = arael.load("plane_slam")
    instance = model()
    fill(instance, model.layout, scene.columns)
    exchange.write_model(tmp_path / "x.columns", instance)
    back = exchange.read(tmp_path / "x.columns")
    for name, values in scene.columns.items():
        np.testing.assert_array_equal(back[name], values)
    assert back["distance_isigma"] == [1 / 0.02]
