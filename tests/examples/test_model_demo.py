"""The example model_demo against the steps put one after the other by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.examples.scripts import script
from tests.optional import needs


def test_both_stages() -> None:
    demo = script("model_demo")
    walk = demo.new_walk()
    first = demo.positions_alone(walk)
    # Without rotations every step is the same vector, and the turns remain as they were.
    along = np.arange(demo.STEPS + 1)[:, None] * demo.DELTA
    np.testing.assert_allclose(walk.poses.pos.value, along, atol=1e-6)
    step = Rotation.from_euler("ZYX", demo.TURN[::-1])
    left = step.inv().as_euler("ZYX") / 0.05
    assert first.cost == pytest.approx(demo.STEPS * left @ left, rel=1e-9)
    assert walk.poses.ea.optimize.all() and not walk.poses.ea.value.any()
    before = walk.poses[-1].pos.value.copy()
    result, seen = demo.everything(walk)
    assert result.cost < 1e-12 and len(seen) == result.iterations
    assert all(np.array_equal(one, before) for one in seen)
    position, turn = np.zeros(3), Rotation.identity()
    for pose in walk.poses:
        np.testing.assert_allclose(pose.pos.value, position, atol=1e-7)
        np.testing.assert_allclose(pose.ea.matrix, turn.as_matrix(), atol=1e-7)
        position, turn = position + turn.apply(demo.DELTA), turn * step
    assert walk.poses[0].pos.value.tolist() == [0, 0, 0]


@needs("matplotlib")
def test_what_it_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script("model_demo").main(["--plot", str(tmp_path / "out.png")])
    printed = capsys.readouterr().out
    assert "start            cost  2782.2171" in printed
    assert "last pose while it was solved: [[8.  0.  0.4]]" in printed
    assert (tmp_path / "out.png").stat().st_size > 5000
