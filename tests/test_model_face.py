"""A model instance from Python: names in place of tables, rows and columns."""

import numpy as np
import pytest

from arael.compiled_model import CompiledModel
from arael.diagnostics.records import AraelError
from arael.model import Model
from arael.runtime.layout import ByValue
from tests.hand_layouts import data, layout, odds, param, slam, table

EYE = np.eye(3)


def new_path(n: int = 4) -> Model:
    path = Model(CompiledModel(slam(), None, None, "test", {}), gamma=2.0)
    for i in range(n):
        path.poses.append(
            pos=[i, 0, 0],
            ea=[0, 0, 0.1 * i],
            info={
                "delta_pos": [1, 0, 0],
                "tilt_roll": 0.5 * i,
                "gps": None if i % 2 else {"pos": [i, i, i], "cov_r": EYE},
                "features": [{"pixel": [k, i]} for k in range(i)],
            },
        )
    return path


def codes(error: pytest.ExceptionInfo[AraelError]) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def test_columns_of_a_collection_are_the_stores_own_memory() -> None:
    path = new_path()
    assert path.poses.pos.value.shape == (4, 3)
    path.poses.pos.value[2, 1] = 7
    assert path.poses[2].pos.value.tolist() == [2, 7, 0]
    path.poses[2].pos.value[0] = 9
    assert path.poses.pos.value[2].tolist() == [9, 7, 0]
    assert path._store.tables["poses"].column("pos")[2].tolist() == [9, 7, 0]
    assert path.poses.info.tilt_roll.tolist() == [0, 0.5, 1, 1.5]
    path.poses.info.tilt_roll = 3
    assert path.poses[1].info.tilt_roll == 3.0


def test_a_row_is_read_and_written_by_name() -> None:
    path = new_path()
    row = path.poses[-1]
    row.pos = [1, 2, 3]
    assert row.pos.value.tolist() == [1, 2, 3]
    row.ea.value = [0, 0, 1]
    assert row.ea.value.tolist() == [0, 0, 1]
    row.info.tilt_roll = 4
    assert path.poses[3].info.tilt_roll == 4.0 and isinstance(row.info.tilt_roll, float)
    assert [p.row for p in path.poses] == [0, 1, 2, 3]
    assert len(path.poses[1:3]) == 2 and path.poses[1:3].pos.value.shape == (2, 3)
    assert path.poses[[3, 0]].info.tilt_roll.tolist() == [4.0, 0.0]
    assert path.gamma == 2.0 and path.tilt_isigma == 1.0
    path.gamma = 3
    assert path.gamma == 3.0
    assert path.poses["info.tilt_roll"].shape == (4,)


def test_optional_structs_are_none_or_whole() -> None:
    path = new_path()
    assert path.poses.info.gps.present.tolist() == [True, False, True, False]
    assert path.poses[1].info.gps is None
    assert path.poses[2].info.gps.pos.tolist() == [2, 2, 2]
    path.poses[2].info.gps = None
    assert path.poses[2].info.gps is None
    with pytest.raises(AraelError) as error:
        path.poses[1].info.gps = {"pos": [1, 1, 1]}
    assert codes(error) == ["E0702"] and "info.gps.cov_r" in str(error.value)
    assert path.poses[1].info.gps is None
    with pytest.raises(AraelError) as error:
        path.poses[1].info.gps = {"pos": [1, 1], "cov_r": EYE}
    assert error.value.diagnostics[0].origin == "poses[1].info.gps.pos"
    path.poses[1].info.gps = {"pos": [1, 1, 1], "cov_r": EYE}
    path.poses[1].info.gps = {"pos": [5, 5, 5]}
    assert path.poses[1].info.gps.pos.tolist() == [5, 5, 5]
    assert path.poses[1].info.gps.cov_r.tolist() == EYE.tolist()
    assert path.poses[1].pos.value.tolist() == [1, 0, 0]
    with pytest.raises(AraelError) as error:
        path.poses[1].info = None
    assert codes(error) == ["E0707"]


def test_flags_by_row_and_for_rows_to_come() -> None:
    path = new_path()
    path.poses.ea.optimize = False
    path.poses[1].pos.fixed = True
    path.poses.ea.fixed[2] = True
    path.poses.append(pos=[0, 0, 0], ea={"value": [0, 0, 0], "fixed": True},
                      info={"delta_pos": [0, 0, 0], "tilt_roll": 0})  # fmt: skip
    table = path._store.tables["poses"]
    assert not table.optimize("ea").any()
    assert table.free("pos").tolist() == [True, False, True, True, True]
    assert table.fixed("ea").tolist() == [False, False, True, False, True]
    assert path.poses[1].pos.fixed is True and path.poses[1].ea.optimize is False
    with pytest.raises(AraelError) as error:
        path.poses.ea.optimize = 1.0
    assert codes(error) == ["E0703"]
    with pytest.raises(AttributeError):
        path.poses.pos.vlaue = 3


def test_refs_nested_collections_and_bulk() -> None:
    path = new_path()
    landmark = path.landmarks.append(pos=[0, 0, 0])
    other = path.landmarks.append(pos=[1, 1, 1])
    features = path.poses[3].info.features
    frine = path.landmarks[0].frines.append(pose=path.poses[3], feature=features[2])
    assert frine.name == "landmarks[0].frines[0]"
    assert frine.pose == path.poses[3] and frine.feature.pixel.tolist() == [2, 3]
    path.landmarks.frines.extend(parent=[1, 0, 1], pose=[1, 2, 3], feature=[0, 1, 0])
    assert len(landmark.frines) == 2 and len(other.frines) == 2
    assert [f.feature.name for f in other.frines] == [
        "poses[1].info.features[0]", "poses[3].info.features[0]",
    ]  # fmt: skip
    assert path.landmarks.frines.pose.rows.tolist() == [3, 1, 2, 3]
    assert other.frines.row.tolist() == [-1, -1]
    assert path.poses.info.features.pixel.shape == (6, 2)
    with pytest.raises(ValueError, match="read-only"):
        other.frines.row[0] = 5
    refs = path.poses.extend(
        pos=np.zeros((2, 3)), ea=[0, 0, 0], info={"delta_pos": EYE[:2], "tilt_roll": np.zeros(2)}
    )
    assert len(refs) == 2 and refs.rows.tolist() == [4, 5]
    path.pose_pairs.extend(prev=path.poses.refs[:-1], cur=path.poses.refs[1:])
    assert path.pose_pairs[0].cur == path.poses[1]
    path.pose_pairs[0].cur = path.poses[2]
    assert path.pose_pairs[0].cur.row == 2


def test_a_window_slides_and_old_refs_are_found_out() -> None:
    path = new_path()
    first, second = path.poses[0], path.poses[1]
    path.pose_pairs.append(prev=first, cur=second)
    path.poses.popleft()
    assert not first.is_valid and second.row == 0 and len(path.poses) == 3
    with pytest.raises(AraelError) as error:
        first.pos.value  # noqa: B018
    assert codes(error) == ["E0709"]
    assert repr(first) == "<stale ref into poses>"
    with pytest.raises(AraelError, match=r"pose_pairs\[0\].prev is stale"):
        path._store.tables["pose_pairs"].target_rows("prev")
    with pytest.raises(AraelError) as error:
        path.pose_pairs.append(prev=first, cur=second)
    assert codes(error) == ["E0709"]
    front = path.poses.appendleft(
        pos=[9, 9, 9], ea=[0, 0, 0], info={"delta_pos": [0, 0, 0], "tilt_roll": 0}
    )
    assert front.row == 0 and second.row == 1


def test_an_arena_removes_anywhere_and_only_an_arena_does() -> None:
    path = new_path()
    a, b, c = (path.landmarks.append(pos=[i, i, i]) for i in range(3))
    b.frines.append(pose=2, feature=0)
    path.landmarks.remove(b)
    assert [lm.pos.value[0] for lm in path.landmarks] == [0, 2]
    assert (a.row, c.row) == (0, 1) and len(path.landmarks.frines) == 0
    for refused in (
        lambda: path.landmarks.remove(b),
        lambda: path.pose_pairs.popleft(),
        lambda: path.landmarks.frines.append(pose=0, feature=0),
    ):
        with pytest.raises(AraelError) as error:
            refused()
        assert codes(error)[0] in ("E0424", "E0709")


def test_messages_of_refused_removals_are_in_plain_words() -> None:
    path = new_path()
    with pytest.raises(AraelError, match="`remove` of a list: only an arena removes anywhere"):
        path.pose_pairs.remove(0)
    with pytest.raises(AraelError, match="`popleft` of an arena: only a deque removes"):
        path.landmarks.popleft()


@pytest.mark.parametrize("given", [-1, [0, -1]])
def test_minus_one_for_a_ref_is_not_called_null(given: object) -> None:
    path = new_path()
    for i in range(2):
        path.pose_pairs.append(prev=i, cur=i)
    with pytest.raises(AraelError) as error:
        if isinstance(given, list):
            path.pose_pairs.prev = given
        else:
            path.pose_pairs[0].prev = given
    assert error.value.diagnostics[0].message == "index -1 is negative: `root.poses` has 4 rows"


def test_wrong_names_and_values_are_named() -> None:
    path = new_path()
    with pytest.raises(AttributeError):
        path.pozes  # noqa: B018
    with pytest.raises(AraelError) as error:
        path.poses[3].pso = [1, 2, 3]
    assert codes(error) == ["E0701"] and "poses[3]" in str(error.value)
    with pytest.raises(AraelError) as error:
        path.poses[3].pos = [1, 2]
    assert "poses[3].pos" in str(error.value) and "2 numbers" in str(error.value)
    note = error.value.diagnostics[0].notes[0]
    assert note == "declared as `param pos: vec3 [m]` at model.arael:2:1"
    with pytest.raises(AraelError) as error:
        path.poses.append(pos=[1, 2, 3], ea=[0, 0, 0], info={"tilt": 3})
    assert codes(error) == ["E0701"]
    with pytest.raises(AraelError) as error:
        path.poses.append(pos=[1, 2, 3], ea=[0, 0, 0], info={"delta_pos": [0, 0, 0], "tilt_roll": 0,
                          "features": [{"pixel": [1]}]})  # fmt: skip
    assert codes(error) == ["E0704"] and len(path.poses) == 4
    with pytest.raises(IndexError):
        path.poses[4]
    assert not hasattr(path.poses, "nothing") and hasattr(path.poses, "pos")


def test_rotations_in_any_form() -> None:
    model = Model(CompiledModel(odds(), None, None, "test", {}), n=3)
    euler = np.array([0.3, -0.2, 1.0])
    camera = model.cameras.append(name="left", q=euler, th=0.5)
    assert camera.q.value.shape == (4,)
    assert np.allclose(camera.q.euler, euler)
    camera.q.matrix = camera.q.matrix.T
    assert np.allclose(camera.q.quaternion[1:] * [-1, -1, -1],
                       model.cameras.append(name="r", q=euler, th=0.0).q.value[1:])  # fmt: skip
    assert model.cameras.q.matrix.shape == (2, 3, 3)
    model.cameras.q = np.stack([EYE, EYE])
    assert model.cameras.q.value.tolist() == [[1, 0, 0, 0]] * 2
    assert np.allclose(camera.th.matrix, [[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    with pytest.raises(AraelError):
        camera.th.euler  # noqa: B018
    getattr(model, "global").q = euler
    assert np.allclose(model["global.q"].euler, euler)


def test_structs_of_the_root_are_set_whole_or_by_field() -> None:
    table_ = table("", "R", "root", data("g.x", "real"), data("g.y", "real"), param("p", "real"),
                   values=[ByValue("g", "G", False, "model.arael:1:1")])  # fmt: skip
    model = Model(CompiledModel(layout("r", "R", table_), None, None, "test", {}), p=1.0)
    assert model._store.root.missing == {"g.x", "g.y"}
    model.g = {"x": 1, "y": 2}
    model.g.y = 3
    assert (model.g.x, model.g.y, model["g.y"]) == (1.0, 3.0, 3.0)
    assert not model._store.root.missing
    assert (
        Model(
            CompiledModel(layout("r", "R", table_), None, None, "test", {}), g={"x": 1, "y": 2}
        ).g.x
        == 1.0
    )


def test_reprs_say_what_is_there() -> None:
    path = new_path()
    assert repr(path.poses) == "<deque of Pose poses: 4 rows>"
    assert (
        repr(path.poses[2].info.features) == "<list of PointFeature poses[2].info.features: 2 rows>"
    )
    assert repr(path.poses[1]).startswith("<Pose poses[1]: pos=[1. 0. 0.], ea=[0.  0.  0.1]")
    assert repr(path).startswith("<Path of slam.arael: ")
    assert "poses[1].pos" in repr(path.poses[1].pos)


def test_fields_win_over_the_properties_of_a_ref() -> None:
    model = Model(CompiledModel(odds(), None, None, "test", {}), n=1)
    left = model.cameras.append(name="left", q=[1, 0, 0, 0], th=0.0, weight=2.0)
    right = model.cameras.append(name="right", q=[1, 0, 0, 0], th=0.0, twin=left)
    assert left.name == "left" and right.twin == left
    assert "twin=cameras[0]" in repr(right)
    assert model.cameras["weight?"].tolist() == [True, False]
    assert left["weight?"] is True and right.weight is None
    assert {"name", "twin", "mount"} <= set(dir(left))


def test_values_in_bulk_are_copied_in_not_shared() -> None:
    path = new_path(0)
    given = np.zeros((2, 3))
    path.poses.extend(pos=given, ea=given, info={"delta_pos": given, "tilt_roll": 0})
    path.poses.pos.value[:] = 5
    assert not given.any()


def test_a_row_that_is_refused_is_named_by_the_place_it_would_have_had() -> None:
    path = new_path()
    lm = path.landmarks.append(pos=[0, 0, 0])
    lm.frines.append(pose=2, feature=0)
    for refused, name in (
        (lambda: path.pose_pairs.append(prev=0, cur=9), "pose_pairs[0].cur"),
        (lambda: path.poses.append(pos=[1], ea=[0, 0, 0]), "poses[4].pos"),
        (lambda: lm.frines.append(pose=9, feature=0), "landmarks[0].frines[1].pose"),
        (lambda: lm.frines.append(pose=2, feature="x"), "landmarks[0].frines[1].feature"),
        (lambda: path.poses.extend(pos=[[1, 2], [3, 4]], ea=[0, 0, 0]), "poses.pos"),
    ):
        with pytest.raises(AraelError) as error:
            refused()
        assert error.value.diagnostics[0].origin.startswith(name)
    assert len(path.pose_pairs) == 0 and len(lm.frines) == 1
