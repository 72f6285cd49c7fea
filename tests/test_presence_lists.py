"""Presence of an optional struct, passed to `extend` as a list of bools."""

from typing import Any

import numpy as np
import pytest

from arael.compiled_model import CompiledModel
from arael.diagnostics.records import AraelError
from arael.model import Model
from tests.hand_layouts import odds, slam

COMMON = {"ea": [0, 0, 0], "info.delta_pos": [1, 0, 0], "info.tilt_roll": 0.0}
GPS = {"gps.pos": [[0, 0, 0], [1, 2, 3], [4, 5, 6]], "gps.cov_r": np.stack([np.eye(3)] * 3)}


def new_path() -> Model:
    return Model(CompiledModel(slam(), None, None, "test", {}), gamma=2.0)


@pytest.mark.parametrize("form", [list, tuple, np.array, lambda v: [np.bool_(x) for x in v]])
def test_a_list_of_bools_is_as_good_as_an_array(form: Any) -> None:
    path = new_path()
    said = form([False, True, False])
    path.poses.extend(pos=np.zeros((3, 3)), info={"gps": said, **GPS}, **COMMON)
    assert path.poses.info.gps.present.tolist() == [False, True, False]
    assert path.poses[0].info.gps is None
    assert path.poses[1].info.gps.pos.tolist() == [1, 2, 3]
    assert path.poses[2].info.gps is None


def test_the_list_tells_how_many_rows_there_are() -> None:
    model = Model(CompiledModel(odds(), None, None, "test", {}), n=1)
    model.cameras.extend(name=["a", "b"], q=[1, 0, 0, 0], th=0.0, mount=[False, False])
    assert model.cameras.mount.present.tolist() == [False, False]
    model.cameras.extend(name="c", q=[1, 0, 0, 0], th=0.0, mount=[False])
    assert len(model.cameras) == 3
    model.cameras.extend(name=[], q=[1, 0, 0, 0], th=0.0, mount=[])
    assert len(model.cameras) == 3


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ([False, 1, True], "found the number 1 in row 1"),
        ([True, None, True], "found null in row 1"),
        ([False, True, [True]], "found an array of 1 in row 2"),
        ([False, True], "expected presence as true or false for each row"),
        ([0, 1, 0], "expected a dict of fields, found an array of 3"),
    ],
)
def test_other_lists_are_refused(said: list[Any], words: str) -> None:
    path = new_path()
    with pytest.raises(AraelError, match=words) as error:
        path.poses.extend(pos=np.zeros((3, 3)), info={"gps": said, **GPS}, **COMMON)
    (found,) = error.value.diagnostics
    assert found.code == "E0703"
    assert found.origin == "poses.info.gps"
    assert len(path.poses) == 0
