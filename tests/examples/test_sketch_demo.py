"""The bracket: its sizes follow two parameters, and it is fully defined throughout."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.sketch import Sketch
from tests.examples.scripts import EXAMPLES, printed


def test_sizes_are_those_of_the_formulas() -> None:
    sketch = Sketch()
    sketch.run((EXAMPLES / "sketch_demo" / "bracket.cmd").read_text(encoding="utf-8"))
    for width, height in ((80, 50), (120, 60), (100, 90), (80, 50)):
        sketch.param("width", width)
        sketch.param("height", height)
        bore, slot = sketch["bore"], sketch["upper"]
        assert sketch.dof()["freedoms"] == 0
        assert (bore.center.x, bore.center.y) == pytest.approx((width / 2, height / 2))
        assert bore.radius == pytest.approx(min(width, height) / 4)
        assert slot.length == pytest.approx(width / 10)
        far = sketch["far"].center
        assert (far.x, far.y) == pytest.approx((width - 10, height - 10))
        assert sketch["top"].length == pytest.approx(width - 12)


def test_the_script_draws_and_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = printed("sketch_demo", ["--output", str(tmp_path)], monkeypatch, capsys)
    assert "drawn: 20 entities, 0 degrees of freedom" in said
    assert "impossible together with" in said
    assert (tmp_path / "bracket.svg").read_text(encoding="utf-8").startswith("<svg")
