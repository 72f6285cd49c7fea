"""Small groups are placed many at a time, exactly as they would be one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime import structure

MODEL = """
struct Point {
    param pos: vec2
    param scale: real
    on: bool = true
    constraint keep when on { (pos - pos.value) * scale }
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    constraint near { [norm2(a.pos - b.pos) - root.size, a.scale * b.scale] }
    constraint apart { [a.scale - 1, b.scale - 2] }
}
root Net {
    param size: real
    points: list of Point
    links: list of Link
}
"""


@pytest.fixture(scope="module")
def net(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("models") / "net.arael"
    path.write_text(MODEL, encoding="utf-8")
    model = arael.load(path, interpret=True)(size=1.0)
    rng = np.random.default_rng(4)
    model.points.extend(pos=rng.normal(size=(9, 2)), scale=1.0, on=rng.random(9) < 0.7)
    for a, b in rng.integers(0, 9, (14, 2)):
        model.links.append(a=model.points[int(a)], b=model.points[int(b)])  # a == b among them
    model.links.append(a=model.points[2], b=model.points[2])
    model.points[4].pos.fixed = True
    model.points[4].scale.fixed = True
    for k in range(6):
        text = f"points[{k}].pos.x * points[{k + 1}].scale - p{k} * size"
        model.residuals.add(text, label=f"r{k}", parameters={f"p{k}": 0.5})
    model.residuals.add("a.pos - [2, 2]", label="every", entities={"a": model.points})
    return model


@pytest.mark.parametrize("limit", [0, 9, 14])
def test_together_as_one_by_one(net: Any, limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    net.session.release()
    together = net._problem().structure
    monkeypatch.setattr(structure, "SMALL", limit)
    alone = net._problem().structure
    assert together.pattern.same_as(alone.pattern)
    assert len(together.placements) == len(net._problem().layout.groups) == 10
    for a, b in zip(together.placements, alone.placements, strict=True):
        for name in ("rows", "gradient_at", "block_at", "turn"):
            mine, other = getattr(a, name), getattr(b, name)
            assert mine.dtype == other.dtype
            np.testing.assert_array_equal(mine, other)
