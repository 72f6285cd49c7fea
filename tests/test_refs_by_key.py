"""Refs given from Python by the `key` text of their target, as in data files."""
# ruff: noqa: E501 - a case is one line

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

MODEL = """
struct Camera {
    name: string
    key name
    param f: real
    link: Link?
    spots: list of Spot
    constraint keep { f - f.value }
}
struct Link { to: ref Camera in root.cameras }
struct Spot { id: string = "s"
    key id
    param u: real }
struct View {
    camera: ref Camera in root.cameras
    spot: ref Spot in camera.spots
    constraint see { camera.f + spot.u - 1 }
}
struct Plain { param x: real }
struct Uses { at: ref Plain in root.plains
    constraint c { at.x } }
root Rig {
    cameras: list of Camera
    views: list of View
    plains: list of Plain
    uses: list of Uses
}
"""


@pytest.fixture(scope="module")
def kind(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("models") / "rig.arael"
    path.write_text(MODEL, encoding="utf-8")
    return arael.load(path, interpret=True)


@pytest.fixture
def rig(kind: Any) -> Any:
    model = kind()
    model.cameras.extend(name=["left", "right", "rear"], f=[1.0, 2.0, 3.0])
    # The spots of each camera are named anew: "a" is in all of them, at another place in each.
    for camera, ids in zip(model.cameras, (["a", "b"], ["b", "a"], ["c", "a"]), strict=True):
        camera.spots.extend(id=ids, u=0.0)
    return model


def codes(error: pytest.ExceptionInfo[AraelError]) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def test_one_row(rig: Any) -> None:
    view = rig.views.append(camera="right", spot="a")
    assert view.camera == rig.cameras[1]
    assert view.spot.name == "cameras[1].spots[1]"
    view.camera, view.spot = "rear", "c"
    assert view.spot.name == "cameras[2].spots[0]"
    top = rig.cameras.append(name="top", f=1.0, link={"to": "left"})
    assert top.link.to == rig.cameras[0]


@pytest.mark.parametrize("form", [list, tuple, np.array, lambda v: np.array(v, object)])
def test_many_rows_each_within_its_owner(rig: Any, form: Any) -> None:
    refs = rig.views.extend(
        camera=form(["right", "left", "right", "rear"]), spot=form(["a", "a", "b", "c"])
    )
    assert len(refs) == 4
    assert rig.views.camera.rows.tolist() == [1, 0, 1, 2]
    assert [ref.spot.name for ref in refs] == [
        "cameras[1].spots[1]", "cameras[0].spots[0]", "cameras[1].spots[0]", "cameras[2].spots[0]",
    ]  # fmt: skip


def test_keys_and_indices_together(rig: Any) -> None:
    rig.views.extend(camera=["rear", 0, np.int64(1)], spot="a")
    assert rig.views.camera.rows.tolist() == [2, 0, 1]
    rig.views.camera = [1, "left", "left"]
    assert rig.views.camera.rows.tolist() == [1, 0, 0]


def test_new_rows_may_name_each_other_where_they_have_a_link(rig: Any) -> None:
    rig.cameras.extend(
        name=["3", "4", "5"],
        f=0.0,
        link=[True, False, True],
        **{"link.to": ["4", "missing", "left"]},
    )
    assert rig.cameras.link.present.tolist() == [False, False, False, True, False, True]
    assert rig.cameras[3].link.to.row == 4
    assert rig.cameras[4].link is None
    assert rig.cameras[5].link.to == rig.cameras[0]


def test_keys_from_python_and_from_a_file_lead_to_the_same(
    rig: Any, kind: Any, tmp_path: Path
) -> None:
    rig.views.extend(camera=["right", "rear"], spot=["b", "a"])
    rig.write(tmp_path / "rig.json")
    other = kind()
    other.read(tmp_path / "rig.json")
    assert other.views.camera.rows.tolist() == rig.views.camera.rows.tolist() == [1, 2]
    assert other.views.spot.rows.tolist() == rig.views.spot.rows.tolist()


@pytest.mark.parametrize(
    ("camera", "spot", "told"),
    [
        (
            ["left", "rihgt"],
            "a",
            [("E0708", '`root.cameras` has no row whose `name` is "rihgt"', "views.camera (row 1)")],
        ),
        (
            ["letf", "left", "raer"],
            "a",
            [
                ("E0708", '`root.cameras` has no row whose `name` is "letf"', "views.camera (row 0)"),
                ("E0708", '`root.cameras` has no row whose `name` is "raer"', "views.camera (row 2)"),
            ],
        ),
        (
            ["left", "rear"],
            ["b", "b"],
            [("E0708", '`camera.spots` has no row whose `id` is "b"', "views.spot (row 1)")],
        ),
        (
            ["left", 2.5],
            "a",
            [
                (
                    "E0703",
                    "expected the index of a `Camera` or its `name`, found the number 2.5",
                    "views.camera (row 1)",
                )
            ],
        ),
        (["left", 3], "a", [("E0708", "index 3 is out of range: `root.cameras` has 3 rows", "views.camera (row 1)")]),
        (["left", None], "a", [("E0707", "null where a ref is needed", "views.camera (row 1)")]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_by_row(
    rig: Any, camera: Any, spot: Any, told: list[tuple[str, str, str]]
) -> None:
    with pytest.raises(AraelError) as error:
        rig.views.extend(camera=camera, spot=spot)
    assert [(d.code, d.message, d.origin) for d in error.value.diagnostics] == told
    assert len(rig.views) == 0


def test_a_misspelt_key_gets_a_suggestion_from_its_own_owner(rig: Any) -> None:
    with pytest.raises(AraelError) as error:
        rig.views.append(camera="rihgt", spot="a")
    assert error.value.diagnostics[0].help == ("did you mean `right`?",)
    with pytest.raises(AraelError) as error:
        rig.views.append(camera="rear", spot="x")
    assert error.value.diagnostics[0].help == ("known names are `c`, `a`",)


def test_a_key_of_two_rows_is_refused(rig: Any) -> None:
    rig.cameras.append(name="left", f=4.0)
    rig.views.append(camera="right", spot="a")
    with pytest.raises(AraelError) as error:
        rig.views.extend(camera=["right", "left", "left"], spot="a")
    (found,) = error.value.diagnostics
    assert (found.code, found.message) == ("E0718", 'two rows have the key "left"')
    assert found.origin == "cameras[3].name"
    assert len(rig.views) == 1


def test_text_for_a_struct_without_key_or_beside_refs(rig: Any) -> None:
    rig.plains.append(x=1.0)
    with pytest.raises(AraelError) as error:
        rig.uses.append(at="first")
    assert codes(error) == ["E0703"]
    with pytest.raises(AraelError) as error:
        rig.views.extend(camera=[rig.cameras[0], "left"], spot=0)
    assert codes(error) == ["E0703"]
    with pytest.raises(AraelError) as error:
        rig.views.extend(2, camera=["left"] * 3, spot=0)
    assert codes(error) == ["E0704"]
