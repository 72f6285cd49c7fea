"""`arael.initialise`: the start of least cost, and what it leaves alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.starts import WAYS, can_initialise
from arael.starts.chordal import chordal_poses
from arael.starts.columns import graph_of, put, rotation_column
from tests.public_data import public
from tests.starts import scenes
from tests.starts.test_chordal import SHAPES, scene
from tests.test_public_optima import OPTIMA


def displaced(name: str = "2d") -> Any:
    graph = scene(SHAPES[name], 0.1, 0.1)
    graph.poses.t.value[1:] += 3.0
    graph.poses.t.value[2:] -= 5.0
    return graph


@pytest.mark.parametrize("name", SHAPES)
def test_auto_takes_a_chordal_start_near_the_noise_without_the_tree(name: str) -> None:
    graph = displaced(name)
    file = graph.cost()
    start = arael.initialise(graph)
    assert list(start.costs) == ["file", "chordal"]
    assert start.costs["file"] == file
    assert start.chosen == min(start.costs, key=start.costs.__getitem__) == "chordal"
    assert graph.cost() == pytest.approx(start.costs["chordal"], rel=1e-12)
    assert str(start).startswith(f"start: chordal, cost {graph.cost():.6g} (file ")
    assert start.to_dict()["chosen"] == "chordal"


def test_auto_takes_the_least_cost_of_all_where_none_is_near_the_noise() -> None:
    """One loop closure in three is an outlier: the tree of odometry fits all the others."""
    graph = displaced()
    spoilt = np.arange(23, len(graph.edges), 3)
    graph.edges.th[spoilt] += 2.0
    graph.edges.u[spoilt] *= 0.9
    start = arael.initialise(graph)
    assert sorted(start.costs) == ["chordal", "file", "tree"]
    assert start.chosen == min(start.costs, key=start.costs.__getitem__)
    assert graph.cost() == pytest.approx(start.costs[start.chosen], rel=1e-12)


def test_auto_computes_no_start_where_the_file_is_at_the_noise() -> None:
    graph = displaced()
    residuals = 3 * len(graph.edges)
    graph.edges.u[...] *= np.sqrt(0.99 * residuals / graph.cost())
    assert graph.cost() == pytest.approx(0.99 * residuals)
    assert list(arael.initialise(graph).costs) == ["file"]
    graph.edges.u[...] *= 1.01
    assert arael.initialise(graph).chosen == "chordal"


def test_auto_keeps_a_solution_to_the_bit() -> None:
    graph = displaced()
    graph.solve()
    before = graph.serialize()
    assert arael.initialise(graph).chosen == "file"
    assert np.array_equal(graph.serialize(), before)


@pytest.mark.parametrize("how", ["tree", "chordal"])
def test_what_is_asked_for_is_taken_whatever_it_costs(how: Any) -> None:
    graph = displaced()
    graph.solve()
    best = graph.cost()
    start = arael.initialise(graph, how)
    assert start.chosen == how
    assert graph.cost() == pytest.approx(start.costs[how], rel=1e-12)
    assert graph.cost() > best


def test_file_changes_nothing() -> None:
    graph = displaced()
    before = graph.serialize()
    assert arael.initialise(graph, "file").costs == {"file": graph.cost()}
    assert np.array_equal(graph.serialize(), before)


@pytest.mark.parametrize("how", ["tree", "chordal"])
def test_fixed_poses_and_parts_of_poses_keep_their_values(how: Any) -> None:
    graph = displaced("3d")
    graph.poses[5].t.fixed = True
    graph.poses[8].q.fixed = True
    graph.poses[11].t.optimize = False
    graph.poses[7].t.fixed = [False, True, False]
    graph.poses[9].t.x.optimize = False
    graph.poses[10].t.high = graph.poses[10].t.value - 0.5
    t, q = graph.poses.t.value.copy(), graph.poses.q.value.copy()
    arael.initialise(graph, how)
    assert np.array_equal(graph.poses.t.value[[0, 5, 7, 9, 11]], t[[0, 5, 7, 9, 11]])
    assert (graph.poses.t.value[10] <= t[10] - 0.5).all()
    assert np.array_equal(graph.poses.q.value[[0, 8]], q[[0, 8]])
    assert not np.array_equal(graph.poses.t.value[8], t[8])


def test_a_component_that_nothing_holds_keeps_its_first_pose() -> None:
    graph = displaced()
    graph.poses.t.fixed = False
    graph.poses.th.fixed = False
    graph.poses.extend(2, t=[[90, 1], [7, 7]], th=[0.5, 0])
    graph.edges.append(a=24, b=25, t=[2, 0], th=0.1, u=np.eye(3))
    for how in ("tree", "chordal"):
        arael.initialise(graph, how)
        assert graph.poses.t.value[0].tolist() == [0, 0]
        assert graph.poses.t.value[24].tolist() == [90, 1]
        expected = [90 + 2 * np.cos(0.5), 1 + 2 * np.sin(0.5)]
        assert np.allclose(graph.poses.t.value[25], expected)


def test_anchors_draw_the_chordal_start_as_they_draw_the_solution() -> None:
    graph = scene(SHAPES["2d"], 0.1, 0.1, noise=0)
    graph.poses.t.fixed = False
    graph.poses.th.fixed = False
    for row in (3, 20):  # the same graph, moved by (100, 50)
        t, th = graph.poses.t.value[row] + [100, 50], graph.poses.th.value[row]
        graph.anchors.append(pose=row, t=t, th=th)
    truth = graph.poses.t.value + np.array([100, 50])
    assert arael.initialise(graph).costs["chordal"] < 1e-15
    assert np.allclose(graph.poses.t.value, truth)


def test_auto_goes_on_where_the_chordal_start_is_not_determined() -> None:
    graph = displaced()
    graph.edges.u[:, 2, 2] = 0
    assert "chordal" not in arael.initialise(graph).costs
    before = graph.serialize()
    with pytest.raises(arael.AraelError, match="do not determine a chordal start") as caught:
        arael.initialise(graph, "chordal")
    assert caught.value.diagnostics[0].code == "E0844"
    assert np.array_equal(graph.serialize(), before)


def test_nothing_to_start_is_no_mistake() -> None:
    graph = arael.load("pose_graph_2d")()
    graph.poses.append(t=[1, 2], th=0)
    assert arael.initialise(graph).chosen == "file"


def test_other_models_and_other_ways_are_refused() -> None:
    line = arael.load("linear", interpret=True)()
    assert not can_initialise(line)
    with pytest.raises(arael.AraelError, match="is not a pose graph") as caught:
        arael.initialise(line)
    assert caught.value.diagnostics[0].code == "E0843"
    with pytest.raises(arael.AraelError, match="there is no start `best`"):
        arael.initialise(displaced(), "best")  # type: ignore[arg-type]


def test_the_command_offers_the_same_ways() -> None:
    from arael.cli.options import INITS

    assert INITS == WAYS


AUTO = {**OPTIMA, (2, "M3500a"): 912.1150, (3, "sphere_slambook"): 127573.7230}


@pytest.mark.parametrize(("n", "name"), AUTO)
def test_the_automatic_start_leads_to_the_optimum_in_six_attempts(n: int, name: str) -> None:
    graph = arael.load(f"pose_graph_{n}d")()
    graph.read(public(f"pose_graph_{n}d/{name}.g2o"))
    at_noise = name in ("intel", "parking-garage")
    assert arael.initialise(graph).chosen == ("file" if at_noise else "chordal")
    result = graph.solve()
    assert result.status == "converged"
    assert result.end_cost == pytest.approx(AUTO[n, name], rel=3e-7, abs=5e-5)
    assert result.iterations <= 6


def test_a_model_with_the_same_collections_is_a_pose_graph(tmp_path: Any) -> None:
    text = (arael.loading.standard_models()["pose_graph_2d"]).read_text(encoding="utf-8")
    text = text.replace("constraint between {", "constraint between loss huber(9) {")
    root = "root Own {\n    poses: list of Pose\n    edges: list of Edge\n}\n"
    text = text[: text.index("# An absolute")] + root
    (tmp_path / "own.arael").write_text(text)
    graph = arael.load(tmp_path / "own.arael", interpret=True)()
    plain = displaced()
    graph.poses.extend(24, t=plain.poses.t.value, th=plain.poses.th.value)
    graph.poses[0].t.fixed = graph.poses[0].th.fixed = True
    ends = scenes.neighbours(4, 6, False)
    edges = {k: plain.edges[k] for k in ("t", "th", "u")}
    graph.edges.extend(len(ends), a=ends[:, 0], b=ends[:, 1], **edges)
    assert arael.initialise(graph).chosen == "chordal"


def test_a_start_written_with_its_graph_is_that_written_by_the_flags() -> None:
    flagged, known = displaced("2d"), displaced("2d")
    for model in (flagged, known):
        model.poses[3].t.fixed = True
        model.poses[5].th.optimize = False
    graph = graph_of(known._store)
    found = chordal_poses(graph)
    put(flagged._store, found)
    put(known._store, found, "th", graph)
    for path in ("t", "th"):
        np.testing.assert_array_equal(
            known._store.tables["poses"].column(path), flagged._store.tables["poses"].column(path)
        )


def test_whether_a_model_is_a_pose_graph_is_found_once_for_its_layout(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = displaced("2d")
    assert rotation_column(model._store) == "th"
    monkeypatch.setattr("arael.starts.columns._rotation_column", None)
    assert rotation_column(model._store) == "th"
