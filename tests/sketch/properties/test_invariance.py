"""The same sketch at another scale or place: the same verdicts, the same drawing."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


def drawn(scale: float, shift: float) -> tuple[list[object], np.ndarray]:
    """Verdicts, and the numbers of the lines at scale 1."""
    session = Session()
    places = [(0, 0), (5, 0.3), (4, 3.2), (-1, 2.9)]
    text = [f"{shift + scale * x:.17g},{shift + scale * y:.17g}" for x, y in places]
    verdicts: list[object] = []
    lines = [f"add_line {text[k]} {text[(k + 1) % 4]} noconnect" for k in range(4)]
    lines += [f"coincident L{k}.p2 L{(k + 1) % 4}.p1" for k in range(4)]
    lines += [f"lock L0.p1 {text[0]}", "horizontal L0", "parallel L0 L2", "parallel L1 L3"]
    lines += ["equal L0 L2", f"length L0 {5 * scale:.17g}", f"length L1 {3 * scale:.17g}"]
    lines += [f"length L3 {4 * scale:.17g}", "perpendicular L0 L1", "perpendicular L2 L3"]
    for line in lines:
        try:
            session.run(line)
        except AraelError as error:
            verdicts.append((line.split()[:2], error.diagnostics[0].code))
        verdicts.append(session.editor.judge.freedoms().total)
    return verdicts, (session.document.values - shift) / scale


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("far", [0.0, 1e3, 1e6, -3e6])
def test_scale_and_place_change_nothing(scale: float, far: float) -> None:
    verdicts, numbers = drawn(scale, far * scale)
    expected, reference = drawn(1.0, 0.0)
    assert verdicts == expected
    assert numbers == pytest.approx(reference, abs=1e-8)
