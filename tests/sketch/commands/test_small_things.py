"""What commands say of what they did: nothing where nothing changed, and no sentence twice."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch import Sketch


def text(sketch: Sketch, line: str) -> str:
    return "\n".join(reply.text for reply in sketch.run(line))


def test_the_value_that_a_dimension_has_changes_nothing() -> None:
    sketch = Sketch()
    sketch.run("add_line 0,0 5,0.1; length L0 5")
    position = sketch.document.history.position
    assert text(sketch, "length L0 5") == "Unchanged d0: length L0 = 5"
    assert sketch.document.history.position == position
    assert text(sketch, "length L0 6") == "Updated d0: length L0 = 6"


def test_no_free_motion_is_said_twice() -> None:
    sketch = Sketch()
    sketch.run("add_line 0,0 5,0.1 noconnect; add_arc 5,0 6,1 5.8,0.3 noconnect notangent")
    sketch.run("coincident L0.p2 A0.start; horizontal L0")
    said = text(sketch, "free").splitlines()[1:]
    assert len(said) == len(set(said)) == 6


def test_a_group_of_nothing_else_is_described_by_what_it_has() -> None:
    sketch = Sketch()
    sketch.run("s = add_slot 20,0 30,0 2")
    assert text(sketch, "info s").startswith("M0: slot: L0 L1 A0 A1")


def test_a_sketch_is_exported_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    sketch = Sketch()
    sketch.run("add_line 0,0 5,0; export part.json")
    again = Sketch()
    again.run("load part.json")
    assert again.document.numbers_of("L0").tolist() == [0, 0, 5, 0]


@pytest.mark.parametrize("x", [3, -3])
@pytest.mark.parametrize("kind", ["hdistance", "vdistance"])
def test_a_negative_distance_along_an_axis_is_to_the_other_side(kind: str, x: float) -> None:
    sketch = Sketch()
    place = f"{x},1" if kind == "hdistance" else f"1,{x}"
    sketch.run(f"add_point 0,0; lock P0; add_point {place} noconnect")
    at = 0 if kind == "hdistance" else 1
    for line, found in (
        (f"{kind} P0 P1 -5", -5),
        (f"{kind} P0 P1 4", -4),  # a value without a sign keeps the side
        (f"{kind} P1 P0 -3", 3),
    ):
        sketch.run(line)
        assert sketch.document.numbers_of("P1")[at] == pytest.approx(found)


def test_a_negative_angle_is_clockwise() -> None:
    sketch = Sketch()
    sketch.run("add_line 0,0 5,0; add_line 0,0 4,3; lock L0.p1; lock L0.p2; angle L0 L1 -20")
    x, y = (float(x) for x in sketch["L1.p2"])
    assert y / x == pytest.approx(-0.36397023426620234)


def test_a_lock_beyond_a_tangent_is_on_the_other_side() -> None:
    sketch = Sketch()
    sketch.run("add_line -5,3 5,3 noconnect; add_circle 0,0 3 noconnect; tangent L0 A0")
    sketch.run("lock L0.p1; lock L0.p2; radius A0 3")
    with pytest.raises(AraelError) as caught:
        sketch.run("lock A0.center 0,6")
    assert caught.value.diagnostics[0].code == "E1233"
    with pytest.raises(AraelError) as caught:
        sketch.run("lock A0.center 0,7")
    assert caught.value.diagnostics[0].code == "E1231"
