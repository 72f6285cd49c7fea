"""The store: columns, handles, owners, refs; removal and growth against a plain Python model of them."""
# ruff: noqa: E501 - a case, or a column, is one line

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.diagnostics.records import AraelError
from arael.runtime.store import Handles, Store
from tests.hand_layouts import odds, slam


def codes(error: pytest.ExceptionInfo[AraelError]) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def poses(store: Store, n: int) -> np.ndarray:
    return store.tables["poses"].extend(
        n,
        pos=np.arange(3.0 * n).reshape(n, 3),
        ea=[0.1, 0.2, 0.3],
        **{"info.delta_pos": [1, 0, 0], "info.tilt_roll": np.arange(n)},
    )


def scene() -> Store:
    """Three poses with 2, 0, 3 features; two landmarks with frines on pose 0 and 2."""
    store = Store(slam())
    poses(store, 3)
    store.tables["poses.info.features"].extend(
        5, [2, 0, 2, 0, 2], pixel=np.arange(10.0).reshape(5, 2)
    )
    store.tables["landmarks"].extend(2, pos=np.zeros((2, 3)))
    store.tables["landmarks.frines"].extend(3, [0, 1, 0], pose=[0, 2, 2], feature=[1, 0, 2])
    return store


def test_columns_have_the_declared_types_and_are_live() -> None:
    for precision, real in (("f32", np.float32), ("f64", np.float64)):
        store = Store(slam(precision))
        poses(store, 4)
        table = store.tables["poses"]
        assert table.column("pos").dtype == real
        assert table.column("pos").shape == (4, 3)
        assert table.column("pos").flags.c_contiguous
        table.column("pos")[2, 1] = 7
        assert table.column("pos")[2, 1] == 7
    assert store.tables["poses.info.features"].column("camera").dtype == np.int64


def test_root_has_one_row_with_defaults() -> None:
    store = Store(odds())
    assert store.root.size == 1
    assert store.root.column("on").tolist() == [True]
    with pytest.raises(AraelError) as error:
        store.check_complete()
    assert codes(error) == ["E0702"] and "`n`" in str(error.value)
    store.root.set_values("n", 0, 3, "n")
    store.check_complete()


def test_children_know_their_owner_and_are_named_by_it() -> None:
    store = scene()
    features = store.tables["poses.info.features"]
    assert features.parent_rows().tolist() == [2, 0, 2, 0, 2]
    order, offsets = features.grouped()
    assert offsets.tolist() == [0, 2, 2, 5]
    assert order.tolist() == [1, 3, 0, 2, 4]
    assert features.row_name(4) == "poses[2].info.features[2]"
    rows = np.array([4, 0, 1, 4])
    assert features.row_names(rows) == [features.row_name(row) for row in rows]
    assert store.tables["poses"].row_names(rows[1:3]) == ["poses[0]", "poses[1]"]
    assert store.root.row_names(rows[:1]) == [""]
    assert store.root.name_of(0, "gamma") == "gamma"


def test_refs_count_within_the_owner_they_are_chained_through() -> None:
    store = scene()
    frines = store.tables["landmarks.frines"]
    assert frines.target_rows("pose").tolist() == [0, 2, 2]
    assert frines.target_rows("feature").tolist() == [3, 0, 4]
    target, rows = store.walk("landmarks.frines", frines.layout.column("feature").target.base)
    assert target is store.tables["poses"] and rows.tolist() == [0, 2, 2]


def test_retiring_a_pose_takes_its_features_and_makes_refs_stale_by_name() -> None:
    store = scene()
    before = store.tables["landmarks.frines"].structure_version
    kept = store.tables["poses"].handles(slice(None))
    store.tables["poses"].retire_front(1)
    features = store.tables["poses.info.features"]
    assert features.size == 3 and features.parent_rows().tolist() == [1, 1, 1]
    assert features.column("pixel")[:, 0].tolist() == [0, 4, 8]
    assert store.tables["poses"].rows_of(kept).tolist() == [-1, 0, 1]
    assert before == store.tables["landmarks.frines"].structure_version
    with pytest.raises(AraelError) as error:
        store.tables["landmarks.frines"].target_rows("pose")
    assert codes(error) == ["E0709"]
    assert "landmarks[0].frines[0].pose is stale" in str(error.value)


def test_removed_handle_is_stale_even_when_its_slot_is_used_again() -> None:
    store = Store(slam())
    landmarks = store.tables["landmarks"]
    first = landmarks.append(pos=[0, 0, 0])
    second = landmarks.append(pos=[1, 1, 1])
    landmarks.remove(first)
    third = landmarks.append(pos=[2, 2, 2])
    assert not landmarks.is_valid(first)
    assert landmarks.row_of(second) == 0 and landmarks.row_of(third) == 1
    with pytest.raises(AraelError, match="stale"):
        landmarks.remove(first)


def test_adopting_new_data_makes_every_old_handle_stale() -> None:
    store = scene()
    kept = store.tables["poses"].handles(slice(None))
    fresh = store.fresh()
    poses(fresh, 5)
    store.adopt(fresh)
    assert store.tables["poses"].size == 5
    assert (store.tables["poses"].rows_of(kept) == -1).all()


@pytest.mark.parametrize(
    ("columns", "code", "words"),
    [
        ({"pos": [1, 2, 3], "pso": 1}, "E0701", "no field `pso`"),
        ({"ea": [0, 0, 0]}, "E0702", "`pos` is missing"),
        ({"pos": "abc", "ea": [0, 0, 0]}, "E0703", "found the string"),
        ({"pos": [True, 0, 0], "ea": [0, 0, 0]}, "E0703", "vec3"),
        ({"pos": [1, 2], "ea": [0, 0, 0]}, "E0704", "shape (2, 3)"),
        ({"pos": [1, 2, np.nan], "ea": [0, 0, 0]}, "E0705", "NaN"),
        ({"pos": [[1, 2, 3], [1, np.inf, 3]], "ea": [0, 0, 0]}, "E0705", "row 1"),
    ],
)
def test_wrong_values_are_refused_and_leave_the_table_as_it_was(
    columns: dict[str, object], code: str, words: str
) -> None:
    store = Store(slam())
    full = {"info.delta_pos": [0, 0, 0], "info.tilt_roll": 0, **columns}
    with pytest.raises(AraelError) as error:
        store.tables["poses"].extend(2, **full)
    assert codes(error)[0] == code
    assert words in str(error.value)
    assert store.tables["poses"].size == 0
    store.tables["poses"].append(**{**full, "pos": [0, 0, 0], "ea": [0, 0, 0]} if code != "E0701" else {
        **{k: v for k, v in full.items() if k != "pso"}, "ea": [0, 0, 0]})  # fmt: skip


def test_numbers_that_do_not_fit_are_refused() -> None:
    store = Store(odds())
    views = store.tables["views"]
    store.tables["cameras"].append(name="a", q=[1, 0, 0, 0], th=0.0)
    for count, code in (
        (2**70, "E0706"),
        (1.5, "E0706"),
        (True, "E0703"),
        (np.uint64(2**63), "E0706"),
    ):
        with pytest.raises(AraelError) as error:
            views.append(camera=0, ok=True, count=count)
        assert codes(error) == [code], count
    views.append(camera=0, ok=True, count=2.0)
    assert views.column("count").tolist() == [2]
    with pytest.raises(AraelError) as error:
        Store(slam("f32")).tables["landmarks"].append(pos=[1e39, 0, 0])
    assert codes(error) == ["E0706"]


def test_refs_of_another_model_or_table_are_refused() -> None:
    store, other = scene(), scene()
    pairs = store.tables["pose_pairs"]
    foreign = Handles(other.tables["poses"], other.tables["poses"].handles(0))
    with pytest.raises(AraelError) as error:
        pairs.append(prev=foreign, cur=1)
    assert codes(error) == ["E0710"] and "another model" in str(error.value)
    with pytest.raises(AraelError) as error:
        pairs.append(
            prev=Handles(store.tables["landmarks"], store.tables["landmarks"].handles(0)), cur=1
        )
    assert "points into `landmarks`, not into `poses`" in str(error.value)
    with pytest.raises(AraelError) as error:
        pairs.append(prev=3, cur=1)
    assert codes(error) == ["E0708"] and "has 3 rows" in str(error.value)
    features = store.tables["poses.info.features"]
    with pytest.raises(AraelError) as error:  # a feature of pose 2, with pose 0
        store.tables["landmarks.frines"].append(
            0, pose=0, feature=Handles(features, features.handles(0))
        )
    assert codes(error) == ["E0708"] and "pose.info.features" in str(error.value)
    assert pairs.size == 0 and store.tables["landmarks.frines"].size == 3


def test_optionals_may_be_absent_and_are_required_whole_when_present() -> None:
    store = Store(slam())
    common = {"pos": [0, 0, 0], "ea": [0, 0, 0], "info.delta_pos": [0, 0, 0], "info.tilt_roll": 0}
    table = store.tables["poses"]
    table.append(**common)
    eye = np.eye(3)
    table.append(**common, **{"info.gps.pos": [1, 2, 3], "info.gps.cov_r": eye})
    gps = {"info.gps": np.array([False, True]), "info.gps.pos": [[np.nan] * 3, [1, 1, 1]]}
    table.extend(2, **common, **gps, **{"info.gps.cov_r": eye})
    assert table.present("info.gps.pos").tolist() == [False, True, False, True]
    assert table.column("info.gps").tolist() == [False, True, False, True]
    assert np.isfinite(table.column("info.gps.pos")).all()
    with pytest.raises(AraelError) as error:
        table.append(**common, **{"info.gps.pos": [1, 2, 3]})
    assert codes(error) == ["E0702"] and "info.gps.cov_r" in str(error.value)


def test_free_is_optimize_and_not_fixed_and_present() -> None:
    store = Store(odds())
    cameras = store.tables["cameras"]
    names = np.array(["a", "b", "c"], dtype=object)
    mount = {"mount": np.array([True, True, False]), "mount.t": np.zeros((3, 3))}
    cameras.extend(
        3, name=names, q=[1, 0, 0, 0], th=0.0, **mount, **{"mount.t.fixed": [True, False, False]}
    )
    assert cameras.free("mount.t").tolist() == [False, True, False]
    cameras.optimize("mount.t")[:] = False
    assert not cameras.free("mount.t").any()
    assert cameras.column("mount.t").shape == (3, 3)


def test_optional_refs_are_minus_one_where_absent() -> None:
    store = Store(odds())
    cameras = store.tables["cameras"]
    cameras.append(name="a", q=[1, 0, 0, 0], th=0.0)
    cameras.append(name="b", q=[1, 0, 0, 0], th=0.0, twin=0)
    assert cameras.target_rows("twin").tolist() == [-1, 0]
    assert cameras.present("twin").tolist() == [False, True]


@pytest.mark.parametrize("path", ["q", "global.q"])
def test_rotations_are_taken_in_any_form(path: str) -> None:
    store = Store(odds())
    euler = np.array([0.1, -0.4, 2.0])
    cameras = store.tables["cameras"]
    cameras.append(name="a", q=euler, th=0.0)
    from arael.runtime.store import rotations

    cameras.append(name="b", q=rotations.matrix_from_euler(euler), th=0.0)
    assert np.allclose(cameras.column("q")[0], cameras.column("q")[1], atol=1e-15)
    with pytest.raises(AraelError) as error:
        cameras.append(name="c", q=[2, 0, 0, 0], th=0.0)
    assert codes(error) == ["E0721"]
    with pytest.raises(AraelError) as error:
        cameras.append(name="c", q=-np.eye(3), th=0.0)
    assert codes(error) == ["E0721"]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["back", "front", "popfront", "child", "remove"]), st.integers(0, 9)
        ),
        max_size=40,
    )
)
def test_rows_follow_a_plain_model_through_any_changes(steps: list[tuple[str, int]]) -> None:
    """Rows, children and handles agree with a list of lists after any sequence of changes."""
    store = Store(slam())
    table, features = store.tables["poses"], store.tables["poses.info.features"]
    model: list[tuple[int, float, list[float]]] = []
    gone: list[int] = []
    made = 0.0
    for what, k in steps:
        made += 1
        row = {
            "pos": [made, 0, 0],
            "ea": [0, 0, 0],
            "info.delta_pos": [0, 0, 0],
            "info.tilt_roll": 0,
        }
        if what == "back":
            model.append((table.append(**row), made, []))
        elif what == "front":
            model.insert(0, (table.append(front=True, **row), made, []))
        elif what == "popfront" and model:
            count = min(k % 3 + 1, len(model))
            table.retire_front(count)
            gone += [h for h, _, _ in model[:count]]
            del model[:count]
        elif what == "child" and model:
            features.append(k % len(model), pixel=[made, 0])
            model[k % len(model)][2].append(made)
        elif what == "remove" and model:
            handle = model.pop(k % len(model))[0]
            gone.append(handle)
            table.remove(handle)
        assert table.column("pos")[:, 0].tolist() == [v for _, v, _ in model]
        assert table.rows_of(np.array([h for h, _, _ in model], np.int64)).tolist() == list(
            range(len(model))
        )
        assert not any(table.is_valid(h) for h in gone)
        order, offsets = features.grouped()
        held = features.column("pixel")[order, 0].tolist()
        assert [held[a:b] for a, b in pairwise(offsets)] == [c for _, _, c in model]
