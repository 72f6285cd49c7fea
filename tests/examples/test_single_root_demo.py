"""The example single_root_demo against the normal equations written out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.examples.scripts import script
from tests.optional import needs

# Rows over (x, y, z): fix_x, slope, tie, fix_z; and what they should give.
ROWS = np.array([[2, 0, 0], [-0.5, 1, 0], [0.7, 0.7, -0.7], [0, 0, 1.0]])
RIGHT = np.array([6, 0, 0, 5.0])


def test_solution_and_blocks() -> None:
    instance, result = script("single_root_demo").solved()
    expected, (cost,), *_ = np.linalg.lstsq(ROWS, RIGHT, rcond=None)
    assert result.status == "converged"
    found = [instance.x.value, instance.y.value, instance.sub.z.value]
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert result.cost == pytest.approx(cost)
    hessian = 2 * ROWS.T @ ROWS
    np.testing.assert_allclose(instance.hb, hessian[:2, :2])
    np.testing.assert_allclose(instance.sub.hb, hessian[2:, 2:])
    np.testing.assert_allclose(instance.hb_sub, hessian[:2, 2:])


@needs("matplotlib")
def test_what_it_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script("single_root_demo").main(["--plot", str(tmp_path / "out.png")])
    printed = capsys.readouterr().out
    expected = np.linalg.lstsq(ROWS, RIGHT, rcond=None)[0]
    assert f"x     = {expected[0]:.6f}" in printed
    assert "converged" in printed
    assert (tmp_path / "out.png").stat().st_size > 5000
