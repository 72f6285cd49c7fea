"""Maps: which axes, what is linked, how large ellipses are, and where cameras stand."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.plot.map import Links, Map, Points, map_figure, map_of, view_of
from tests.optional import needs

LEG = np.column_stack((np.arange(6.0), np.zeros(6), np.zeros(6)))
STEPS = np.column_stack((np.arange(5), np.arange(1, 6)))


@pytest.mark.parametrize(
    ("scale", "view"),
    [((9, 8, 1), "xy"), ((9, 1, 8), "xz"), ((1, 9, 8), "yz"), ((9, 8, 7), "3d")],
)
def test_the_view_shows_most(scale: tuple[float, ...], view: str) -> None:
    cloud = np.random.default_rng(0).uniform(size=(200, 3)) * scale
    assert view_of(Map({"points": Points(cloud)})) == view
    assert view_of(Map({"points": Points(cloud)}), "xz") == "xz"


def test_a_plane_has_one_view_and_others_are_refused() -> None:
    flat = Map({"poses": Points(LEG[:, :2])})
    assert view_of(flat, "3d") == "xy"
    with pytest.raises(AraelError, match="E0828"):
        view_of(flat, "zx")  # type: ignore[arg-type]


@needs("matplotlib")
def test_a_path_is_drawn_apart_from_what_closes_it() -> None:
    pairs = np.vstack((STEPS, [[5, 0]]))
    drawn = map_figure(Map({"poses": Points(LEG)}, (Links("poses", "poses", pairs),)), "walk", "ok")
    path, closure = drawn.axes[0].collections
    assert (len(path.get_segments()), len(closure.get_segments())) == (5, 1)
    assert drawn.get_suptitle() == "walk\n6 poses; ok"
    loose = map_figure(Map({"poses": Points(LEG)}, (Links("poses", "poses", pairs[3:]),)))
    assert len(loose.axes[0].collections) == 1


@needs("matplotlib")
@pytest.mark.parametrize(("sigma", "factor"), [(0.05, 1), (5.0, 0.02), (1e-4, 200)])
def test_ellipses_have_two_sigmas_times_a_factor_that_is_told(sigma: float, factor: float) -> None:
    spread = np.tile(np.diag([sigma**2, sigma**2 / 4, 1.0]), (6, 1, 1))
    axes = map_figure(Map({"poses": Points(LEG, spread)}), view="xy").axes[0]
    (ellipses,) = axes.collections
    assert ellipses.get_widths()[0] == pytest.approx(4 * sigma * factor)
    assert ellipses.get_heights()[0] == pytest.approx(2 * sigma * factor)
    told = f", times {factor:g}" if factor != 1 else ""
    assert axes.get_legend_handles_labels()[1] == ["poses", f"2 sigma of poses{told}"]


@needs("matplotlib")
def test_distant_points_are_left_out_and_counted() -> None:
    cloud = np.vstack((np.random.default_rng(0).uniform(size=(100, 2)), [[1e6, 0]]))
    figure = map_figure(Map({"points": Points(cloud)}))
    assert figure.get_suptitle() == "101 points; 1 far away left out"
    assert figure.axes[0].get_xlim()[1] < 2


WALK = """
struct Pose {
    name: string
    key name
    param t: vec2 [m]
    prev: ref Pose in root.poses?
    constraint step when prev { (t - prev.t - [1, 0]) / 0.1 }
}
struct Fix { pose: ref Pose in root.poses; constraint at { pose.t / 0.2 } }
root Walk { poses: list of Pose; fixes: list of Fix }
"""


@needs("matplotlib")
def test_the_map_of_a_model_has_links_names_and_covariances() -> None:
    walk = arael.loads(WALK, interpret=True)()
    walk.poses.extend(name=["a", "b", "c"], t=np.zeros((3, 2)), prev=[None, 0, 1])
    walk.fixes.append(pose=0)
    walk.solve()
    found = map_of(walk, type(walk).layout, uncertain=True)
    assert found is not None and found.unit == "m"
    poses = found.points["poses"]
    assert np.allclose(poses.places, [[0, 0], [1, 0], [2, 0]])
    assert poses.covariances is not None
    assert np.allclose(poses.covariances[2], (0.2**2 + 2 * 0.1**2) * np.eye(2))
    assert poses.names == ("a", "b", "c")
    assert [(one.a, one.b, one.pairs.tolist()) for one in found.links] == [
        ("poses", "poses", [[0, 1], [1, 2]])
    ]
    texts = [text.get_text() for text in walk.plot().axes[0].texts]
    assert texts == [" a", " b", " c"]


@needs("matplotlib")
def test_a_model_without_places_has_residuals_and_no_map() -> None:
    text = "root R { param a: real = 0; constraint c loss cauchy(1) { [a - 1, 3 * a] } }"
    model = arael.loads(text, interpret=True)()
    model.solve()
    assert map_of(model, type(model).layout) is None
    left, right, weights = model.plot().axes
    assert left.get_title(loc="left").startswith("R.c: 2 residuals")
    values = model.residual_values("R.c")
    assert weights.lines[0].get_ydata()[0] == pytest.approx(values.weight[0]) != 1
    assert [line.get_ydata()[0] for line in left.lines[:2]] == values.whitened[0].tolist()
    assert right.get_xlabel() == "residual / sigma"
    with pytest.raises(AraelError, match="E0828"):
        model.plot("map")
    with pytest.raises(AraelError, match="E0828"):
        model.plot("cost")  # type: ignore[arg-type]


def test_cameras_stand_where_they_look_from() -> None:
    bundle = arael.load("bundle_adjustment", interpret=True)()
    # A quarter turn about z, world to camera; the camera is at (1, 2, 3): t = -R c.
    half = np.sqrt(0.5)
    bundle.cameras.append(r=[half, 0, 0, half], t=[2, -1, -3], f=1.0, k1=0.0, k2=0.0)
    found = map_of(bundle, type(bundle).layout)
    assert found is not None and found.up == "y"
    assert np.allclose(found.points["cameras"].places, [[1, 2, 3]])


@needs("matplotlib")
def test_residuals_of_run_time_are_drawn_too() -> None:
    model = arael.loads("root R { param a: real = 0; constraint c { a - 1 } }", interpret=True)()
    model.residuals.add("3 * a - 6", label="later")
    model.solve()
    titles = [axes.get_title(loc="left") for axes in model.plot("residuals").axes]
    assert titles[0].startswith("later: 1 residuals") or titles[2].startswith("later: 1 residuals")


MIXED = """
struct Camera { param f: vec2 [px] = [600, 600]; param v: vec3 [m/s] = [1, 2, 3] }
struct View { param v: vec3 [m/s] = [0, 0, 0]; param t: vec3 [m] = [0, 0, 0] }
root Rig { cameras: list of Camera; views: list of View
    fit views as w { [w.t / 1 [m], w.v / 1 [m/s]] } }
"""


def test_only_lengths_are_places() -> None:
    rig = arael.loads(MIXED, interpret=True)()
    rig.cameras.extend(2)
    rig.views.extend(t=[[0, 0, 1], [1, 0, 2]])
    drawn = map_of(rig, type(rig).layout)
    assert drawn is not None and list(drawn.points) == ["views"] and drawn.unit == "m"
    np.testing.assert_array_equal(drawn.points["views"].places, [[0, 0, 1], [1, 0, 2]])
    rig.views.clear()
    drawn = map_of(rig, type(rig).layout)
    assert drawn is not None and list(drawn.points) == ["cameras"] and drawn.unit == "px"


@needs("matplotlib")
def test_a_map_of_one_place_gives_way_to_the_residuals() -> None:
    rig = arael.loads(MIXED, interpret=True)()
    rig.views.extend(3)
    assert "residual" in rig.plot().axes[0].get_ylabel()
    assert rig.plot("map").axes[0].get_ylabel() == "y [m]"
    rig.views[1].t = [1, 0, 0]
    assert "m]" in rig.plot().axes[0].get_ylabel()
