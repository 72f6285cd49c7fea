"""Models of examples with the name of a standard model are copies of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.examples.scripts import EXAMPLES

STANDARD = {path.name: path for path in (EXAMPLES.parent / "arael" / "models").glob("*.arael")}
# Small sketches of their own, which do not show the standard model `sketch`.
OWN = {"jacobian_demo/sketch.arael", "runtime_sketch/sketch.arael"}
COPIES = sorted(
    path
    for path in EXAMPLES.glob("*/*.arael")
    if path.name in STANDARD and path.relative_to(EXAMPLES).as_posix() not in OWN
)


def test_there_are_copies() -> None:
    assert len(COPIES) >= 4


@pytest.mark.parametrize("path", COPIES, ids=lambda path: path.parent.name)
def test_copies_are_equal(path: Path) -> None:
    assert path.read_bytes() == STANDARD[path.name].read_bytes()
