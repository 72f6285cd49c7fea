"""Optional refs from the text to the solution: `prev: ref Pose in root.poses?`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

MODEL = """
struct Spot { param u: real
    constraint here { u - 1 } }
struct Pose {
    param x: real
    step: real = 1
    prev: ref Pose in root.poses?
    info: Info?
    spots: list of Spot
    skip note: ref Pose in root.poses?
    constraint odometry when prev { x - prev.x - step }
    constraint start when not prev { x / 10 }
    constraint ahead when prev and prev.x > 100 { x }
}
struct Info { twin: ref Pose in root.poses?
    constraint same when twin { (twin.x - parent.x) * 1e-3 } }
struct Sight {
    param y: real
    pose: ref Pose in root.poses?
    spot: ref Spot in pose.spots?
    constraint at when spot { y - spot.u }
    constraint near when not pose or pose.step > 1 { (y - 2) * 0.5 }
    constraint keep { y * 0.1 }
}
root Chain {
    poses: deque of Pose
    sights: list of Sight
    current: ref Pose in root.poses?
    constraint now when current { (current.x - 3) * 0.1 }
}
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("refs") / "chain.arael"
    found.write_text(MODEL)
    return found


@pytest.fixture(scope="module")
def chain(path: Path) -> Any:
    return arael.load(path, interpret=True)


def filled(chain: Any) -> Any:
    """Four poses in two tracks, and sights with a pose, with a spot, with neither."""
    model = chain()
    first = model.poses.append(x=0.5, spots=[{"u": 2}, {"u": 3}])
    second = model.poses.append(x=0, prev=first, info={"twin": first})
    model.poses.append(x=0, prev=second, step=2, info={"twin": None})
    model.poses.append(x=4, prev=None, note=second)
    model.sights.append(y=0, pose=first, spot=1)
    model.sights.append(y=0, pose=model.poses[2])
    model.sights.append(y=0)
    return model


def test_instances_with_a_null_ref_do_not_act(chain: Any) -> None:
    model = filled(chain)
    table = model.cost_table()
    assert table.instances == {
        "Spot.here": 2,
        "Pose.odometry": 2,
        "Pose.start": 2,
        "Pose.ahead": 0,
        "Info.same": 1,
        "Sight.at": 1,
        "Sight.near": 2,
        "Sight.keep": 3,
        "Chain.now": 0,
    }
    model.current = model.poses[3]
    assert model.cost_table().instances["Chain.now"] == 1
    assert model.jacobian().of("Chain.now").shape[0] == 1


def test_optimum_is_that_of_the_guarded_residuals(chain: Any) -> None:
    model = filled(chain)
    model.poses[1].info = None
    model.solve(rel_precision=1e-14)
    np.testing.assert_allclose(model.poses.x.value, [0, 1, 3, 0], atol=1e-9)
    spot = np.linalg.solve([[2.0, -1.0], [-1.0, 1.01]], [1.0, 0.0])  # u and y of the first sight
    np.testing.assert_allclose(model.poses[0].spots[1].u.value, spot[0], atol=1e-9)
    np.testing.assert_allclose(model.sights.y.value, [spot[1], 0.5 / 0.26, 0.5 / 0.26], atol=1e-9)


def test_kernels_agree_with_the_interpreter(chain: Any, path: Path) -> None:
    found = []
    for loaded in (chain, arael.load(path)):
        model = filled(loaded)
        model.current = 2
        model.solve(rel_precision=1e-12)
        model.poses.popleft()
        model.solve(rel_precision=1e-12)
        found.append(np.concatenate([model.poses.x.value, model.sights.y.value, [model.cost()]]))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("given", "rows"),
    [
        ({"prev": [0, 1]}, [0, 1]),
        ({"prev": [0, None]}, [0, -1]),
        ({"prev": [-1, 1]}, [-1, 1]),
        ({"prev": np.array([-1, 1])}, [-1, 1]),
        ({"prev": np.array([None, 1])}, [-1, 1]),
        ({"prev": [None, None]}, [-1, -1]),
        ({"prev": None}, [-1, -1]),
        ({}, [-1, -1]),
        ({"prev": 1}, [1, 1]),
        ({"prev": [0, 1], "prev?": np.array([False, True])}, [-1, 1]),
    ],
)
def test_extend_takes_nulls(chain: Any, given: dict[str, Any], rows: list[int]) -> None:
    model = filled(chain)
    model.poses.extend(2, x=1.0, **given)
    assert model.poses.prev.rows[-2:].tolist() == rows
    assert model.poses["prev?"][-2:].tolist() == [row >= 0 for row in rows]
    assert [ref is None for ref in model.poses.prev][-2:] == [row < 0 for row in rows]


def test_refs_of_rows_are_given_with_none_among_them(chain: Any) -> None:
    model = filled(chain)
    model.poses.extend(x=[1.0, 2.0], prev=[None, model.poses[1]])
    assert model.poses.prev.rows[-2:].tolist() == [-1, 1]


@pytest.mark.parametrize(
    ("value", "code"), [([0, -2], "E0708"), ([0, 99], "E0708"), ([0.5, None], "E0703")]
)
def test_what_is_no_row_is_refused(chain: Any, value: Any, code: str) -> None:
    model = filled(chain)
    with pytest.raises(AraelError) as failure:
        model.poses.extend(x=[1.0, 2.0], prev=value)
    assert failure.value.diagnostics[0].code == code
    assert len(model.poses) == 4


def test_a_ref_is_made_null_and_set_again(chain: Any) -> None:
    model = filled(chain)
    second = model.poses[1]
    assert second.prev == model.poses[0]
    second.prev = None
    assert second.prev is None
    assert "prev=None" in repr(second)
    assert model.cost_table().instances["Pose.odometry"] == 1
    second.prev = 0
    assert model.cost_table().instances["Pose.odometry"] == 2
    model.poses.prev = [None, 0, None, 2]
    assert model.poses.prev.rows.tolist() == [-1, 0, -1, 2]


def test_a_removed_target_reads_as_null(chain: Any, tmp_path: Path) -> None:
    model = filled(chain)
    second, third, last = (model.poses[k] for k in (1, 2, 3))
    model.poses.popleft()
    assert second.prev is None
    assert second.info.twin is None
    assert third.prev == second
    assert last.note == second
    assert model.poses["prev?"].tolist() == [False, True, False]
    assert model.poses.prev.rows.tolist() == [-1, 0, -1]
    assert model.poses.prev[0] is None
    assert model.sights[0].spot is None
    assert model.cost_table().instances["Pose.odometry"] == 1
    model.write(tmp_path / "a.json")
    assert chain().read(tmp_path / "a.json") is None


@pytest.mark.parametrize("kind", ["json", "npz"])
def test_files_hold_nulls(chain: Any, tmp_path: Path, kind: str) -> None:
    model = filled(chain)
    model.current = 1
    model.write(tmp_path / f"a.{kind}")
    other = chain()
    other.read(tmp_path / f"a.{kind}")
    assert other.poses.prev.rows.tolist() == [-1, 0, 1, -1]
    assert other.poses.note.rows.tolist() == [-1, -1, -1, 1]
    assert other.poses[1].info.twin == other.poses[0]
    assert other.poses[2].info.twin is None
    assert other.sights[0].spot.index == 1
    assert other.current.index == 1
    assert other.cost() == model.cost()


def test_csv_has_an_empty_cell_for_null(chain: Any, tmp_path: Path) -> None:
    model = chain()
    model.poses.extend(x=[1.0, 2.0], prev=[-1, 0])
    model.write(tmp_path / "poses.csv")
    header, first, second = (tmp_path / "poses.csv").read_text().splitlines()
    at = header.split(",").index("prev")
    assert [line.split(",")[at] for line in (first, second)] == ["", "0"]
    (tmp_path / "poses.csv").write_text("x,prev\n1,\n2,0\n3,\n")
    model.read(tmp_path / "poses.csv")
    assert model.poses.prev.rows.tolist() == [-1, 0, -1]


def test_a_refused_csv_leaves_refs_into_the_collection(chain: Any, tmp_path: Path) -> None:
    model = filled(chain)
    (tmp_path / "poses.csv").write_text("x,prev\n1,7\n")
    with pytest.raises(AraelError):
        model.read(tmp_path / "poses.csv")
    assert model.sights.pose.rows.tolist() == [0, 2, -1]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ('{"poses": [{"x": 1, "prev": -1}]}', "E0708"),
        ('{"poses": [{"x": 1, "prev": 1}]}', "E0708"),
        ('{"poses": [{"x": 1, "prev": "a"}]}', "E0703"),
        ('{"poses": [{"x": 1}], "sights": [{"y": 1, "spot": 0}]}', "E0708"),
    ],
)
def test_json_names_what_is_wrong(chain: Any, tmp_path: Path, text: str, code: str) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(AraelError) as failure:
        chain().read(tmp_path / "a.json")
    assert [d.code for d in failure.value.diagnostics] == [code]


@pytest.mark.parametrize("rows", [0, 2])
def test_a_chained_ref_without_its_owner_is_refused(chain: Any, rows: int) -> None:
    model = chain()
    model.poses.extend(rows, x=1.0)
    for row in model.poses:
        row.spots.append(u=1)
    for given in ({"spot": 0}, {"pose": None, "spot": 0}):
        with pytest.raises(AraelError, match="the ref on the path is null"):
            model.sights.append(y=0, **given)
    model.sights.append(y=0)
    assert model.sights[0].spot is None
    assert len(model.sights) == 1


def test_info_shows_an_optional_ref_once(path: Path) -> None:
    from click.testing import CliRunner

    from arael.cli.main import command

    shown = CliRunner().invoke(command, ["info", str(path)]).output
    lines = [line.split(None, 1)[1] for line in shown.splitlines() if line.startswith("  prev ")]
    assert lines == ["ref Pose in root.poses?"]


def test_emit_shows_that_a_ref_is_optional(path: Path) -> None:
    from click.testing import CliRunner

    from arael.cli.main import command

    shown = CliRunner().invoke(command, ["emit", "--stage", "ast", str(path)]).output
    assert "RefType optional=True" in shown
    assert "guard: Present slot=0 column='prev'" in " ".join(
        CliRunner().invoke(command, ["emit", "--stage", "types", str(path)]).output.split()
    )
