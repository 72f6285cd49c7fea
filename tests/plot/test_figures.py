"""Figures are written, whole, and the same every time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.plot import figure as figures
from arael.plot.fit import Line, fit_figure
from arael.plot.history import history_figure
from arael.plot.map import Links, Map, Points, map_figure
from arael.plot.scene import View, scene_figure
from arael.plot.sparsity import sparsity_figure
from arael.scenes import demo_config, make_scene
from tests.optional import needs, require


def view(landmarks: bool = True) -> View:
    scene = make_scene(demo_config(10))
    covariances = np.tile(np.diag([0.04, 0.01, 0.01]), (len(scene.landmarks), 1, 1))
    covariances[3] = np.nan
    return View(
        true_poses=scene.pos,
        start_poses=scene.start_pos,
        poses=scene.pos,
        true_landmarks=scene.landmarks,
        landmarks=scene.start_landmarks if landmarks else None,
        covariances=covariances if landmarks else None,
        title="scene",
    )


@pytest.mark.parametrize("ending", figures.FORMATS)
@needs("matplotlib")
def test_save_writes_each_format(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"scene{ending}"
    assert figures.save(scene_figure(view()), path) == str(path)
    start = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}[ending]
    assert path.read_bytes().startswith(start)
    again = tmp_path / f"again{ending}"
    figures.save(scene_figure(view()), again)
    assert again.read_bytes() == path.read_bytes()


@needs("matplotlib")
def test_a_notebook_shows_figures_as_pictures() -> None:
    assert scene_figure(view())._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


@needs("matplotlib")
def test_legend_names_what_is_drawn() -> None:
    texts = [t.get_text() for t in scene_figure(view()).legends[0].get_texts()]
    assert "2 sigma relative to the closest pose" in texts
    assert {"true landmarks", "solved landmarks", "truth", "start", "solved poses"} <= set(texts)
    known = [t.get_text() for t in scene_figure(view(landmarks=False)).legends[0].get_texts()]
    assert "landmarks (known)" in known
    assert not any("sigma" in text for text in known)


@needs("matplotlib")
def test_ellipses_have_the_size_and_direction_of_the_covariance() -> None:
    axes = scene_figure(view()).axes[0]
    (ellipses,) = (c for c in axes.collections if type(c).__name__ == "EllipseCollection")
    assert len(ellipses.get_offsets()) == 39  # the one not known is left out
    assert ellipses.get_widths()[0] == pytest.approx(2 * 2 * 0.2)
    assert ellipses.get_heights()[0] == pytest.approx(2 * 2 * 0.1)
    assert ellipses.get_angles()[0] % 180 == pytest.approx(0)


@needs("matplotlib")
def test_sparsity_is_symmetric_and_coloured_by_group() -> None:
    figure = sparsity_figure(np.array([0, 1, 2]), np.array([0, 1, 0]), 3, [("a", 2), ("b", 1)])
    image = figure.axes[0].images[0].get_array()
    assert image.tolist() == [[1, 0, 3], [0, 1, 0], [3, 0, 0]]
    assert figure.axes[0].get_xlabel() == "3 parameters, 4 non-zero entries (44.4%)"


@needs("matplotlib")
def test_large_pattern_is_reduced() -> None:
    places = np.arange(100_000)
    figure = sparsity_figure(places, places, 100_000)
    image = np.asarray(figure.axes[0].images[0].get_array())
    assert image.shape == (1400, 1400)
    assert np.all(np.diag(image) == 1)
    assert image.sum() == 1400


@needs("matplotlib")
def test_history_marks_rejected_attempts() -> None:
    kinds = [("cost", float), ("trial_cost", float), ("damping", float), ("accepted", int)]
    records = np.array([(9, 4, 1e-4, 1), (4, 8, 2e-5, 0), (4, 1, 2e-4, 1)], dtype=kinds)
    figure = history_figure([("solve", records)])
    line, accepted, rejected = figure.axes[0].lines[:3]
    assert line.get_ydata().tolist() == [9, 4, 4, 1]
    assert accepted.get_xdata().tolist() == [1, 3]
    assert rejected.get_xdata().tolist() == [2]


@needs("matplotlib")
def test_history_draws_the_trust_region_where_there_is_one() -> None:
    kinds = [
        ("cost", float), ("trial_cost", float), ("damping", float), ("radius", float),
        ("accepted", int),
    ]  # fmt: skip
    cut = np.array([(9, 4, 1e-12, 7.5, 1), (4, 1, 1e-12, 15.0, 1)], dtype=kinds)
    damped = np.array([(1, 0.5, 1e-4, np.nan, 1)], dtype=kinds)
    axes = history_figure([("first", cut), ("second", damped)]).axes[1]
    assert axes.get_title(loc="left") == "damping, trust region"
    drawn = [line.get_ydata().tolist() for line in axes.lines if line.get_marker() == "."]
    assert drawn == [[7.5, 15.0], [1e-4]]


@needs("matplotlib")
def test_fit_and_map_figures(tmp_path: Path) -> None:
    x = np.linspace(0, 1, 9)
    fit = fit_figure(x, 2 * x, x > 0.8, [Line("robust", 2.0, 0.0, figures.BLUE)])
    assert fit.axes[0].get_legend().get_texts()[-1].get_text() == "robust: 2.0000 x +0.0000"
    poses = Points(np.array([[0.0, 0, 0], [1, 1, 1]]))
    links = (Links("poses", "poses", np.array([[0, 1]])),)
    drawn = map_figure(Map({"poses": poses, "landmarks": Points(np.ones((3, 2)))}, links))
    assert len(drawn.axes[0].collections) == 1
    figures.save(drawn, tmp_path / "map.png")


def test_unknown_ending_is_told() -> None:
    with pytest.raises(AraelError, match=r"E0861.*expected a picture file \(.png, .pdf, .svg\)"):
        figures.check_format(Path("x.bmp"))


@needs("matplotlib")
def test_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(AraelError, match="E0715"):
        figures.save(map_figure(Map({"a": Points(np.zeros((1, 2)))})), tmp_path / "no" / "x.png")


def test_missing_matplotlib_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.plot.figure.find_spec", lambda name: None)
    with pytest.raises(AraelError, match=r"E0860.*which is not installed"):
        map_figure(Map({"a": Points(np.zeros((1, 2)))}))


def test_beside() -> None:
    assert figures.beside(Path("a/run.png"), "hessian") == Path("a/run-hessian.png")


@pytest.mark.parametrize(
    ("formula", "group"),
    [
        ("y = a * x + b", None),
        ("y = a * x + b", "g"),
        ("y = a * x + b * z", None),
        ("0 = a * x - y", None),
        ("y = a", None),
    ],
)
def test_fitted_curves(formula: str, group: str | None, recwarn: pytest.WarningsRecorder) -> None:
    require("matplotlib")
    x = np.arange(8.0)
    data = {"x": x, "z": x**2, "y": 2 * x + 1 + np.sin(7 * x), "g": np.repeat(["p", "q"], 4)}
    figure = arael.fit(formula, data, group=group).plot(level=0.9)
    assert len(figure.axes) == (1 if formula.startswith("0") else 2)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[-1] == "residuals" and not recwarn.list
