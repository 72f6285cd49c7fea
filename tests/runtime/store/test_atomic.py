"""A change that is refused leaves everything as it was, refs and values alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

MODEL = """
struct Feature {
    u: real
}
struct Frame {
    param x: real
    features: list of Feature
    constraint near { x }
}
struct Sight {
    gain: real
    frame: ref Frame in root.frames
    feature: ref Feature in frame.features
}
struct Track {
    sight: Sight
    spare: Sight?
    constraint near { sight.gain * sight.frame.x }
}
root Scene {
    frames: list of Frame
    tracks: deque of Track
}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Any:
    path = tmp_path / "scene.arael"
    path.write_text(MODEL, encoding="utf-8")
    model = arael.load(path, interpret=True)()
    for count in (1, 3):
        frame = model.frames.append(x=1.0)
        frame.features.extend(u=np.arange(float(count)))
    model.tracks.append(sight={"gain": 1.0, "frame": 1, "feature": 2})
    return model


def everything(scene: Any) -> list[Any]:
    table = scene.tracks._table
    return [(name, table.buffers.view(name).tolist()) for name in table.buffers._arrays]


@pytest.mark.parametrize(
    ("value", "code"),
    [
        ({"gain": 5.0, "frame": 9, "feature": 0}, "E0708"),
        ({"gain": 5.0, "frame": 0, "feature": 2}, "E0708"),  # frame 0 has one feature
        ({"gain": 5.0, "frame": 0, "feature": "x"}, "E0703"),
    ],
)
@pytest.mark.parametrize("field", ["sight", "spare"])
def test_a_struct_with_a_wrong_ref_leaves_the_row_as_it_was(
    scene: Any, field: str, value: dict[str, Any], code: str
) -> None:
    before = everything(scene)
    with pytest.raises(AraelError) as caught:
        setattr(scene.tracks[0], field, value)
    assert caught.value.diagnostics[0].code == code
    assert everything(scene) == before
    setattr(scene.tracks[0], field, {"gain": 5.0, "frame": 0, "feature": 0})
    assert everything(scene) != before


def test_rows_with_a_wrong_ref_are_not_added(scene: Any) -> None:
    before = everything(scene)
    wrong = {"gain": 5.0, "frame": 0, "feature": 2}
    for add in (scene.tracks.append, scene.tracks.appendleft):
        with pytest.raises(AraelError):
            add(sight=wrong)
    with pytest.raises(AraelError):
        scene.tracks.extend(
            **{"sight.gain": [1.0, 2.0], "sight.frame": [1, 0], "sight.feature": [2, 2]}
        )
    assert everything(scene) == before
