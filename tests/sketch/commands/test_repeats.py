"""Lines that differ from earlier ones in a number alone do the same as if they were read anew."""

from __future__ import annotations

import pytest

from arael import AraelError
from arael.sketch import Sketch
from arael.sketch.document.saved import to_json

DRAWN = """
add_rect 0,0 40,30
add_line 60,0 90,10
add_line 60,0 70,30
length L0 40
length L1 30
hdistance L4.p1 L4.p2 30
angle L4 L5 50
xangle L4 15
area L0 L1 L2 L3 derived
"""

LINES = (
    ["length L0 40"]
    + [f"length L0 {value}" for value in (41, 42.5, "4e1", "-3", 0, 40)]
    + [f"hdistance L4.p1 L4.p2 {value}" for value in (31, -32, -31, 29)]
    + [f"angle L4 L5 {value}" for value in (51, 52, -53, 200)]
    + ["angle L4 L5 60 supplement", "angle L4 L5 61", "angle L4 L5 62"]
    + [
        "length L0 45 # why",
        "length L0 46",
        "undo",
        "length L0 47",
        "undo 2",
        "redo",
        "length L0 48",
    ]
    + ["length L0 1e999", "length L0 12 mm", "length L0 13", "length L0 >= 12", "length L0 14"]
    + ["length L2 14", "length L0 15", "length L0", "length L0 x", "length L0 15"]
    + ["delete d0", "length L0 16", "length L0 17", "delete L0", "length L0 18"]
    + ["clear", "add_line 0,0 3,0", "length L0 19", "length L0 20", "length L0 21"]
)


def ran(sketch: Sketch, line: str) -> str:
    try:
        return "\n".join(reply.text for reply in sketch.run(line))
    except AraelError as refused:
        return str(refused)


def test_repeated_lines_do_what_lines_do_that_are_read_anew():
    repeating, reading = Sketch(), Sketch()
    hits = 0
    for line in [*DRAWN.strip().splitlines(), *LINES]:
        hits += repeating.session.repeats.find(line, repeating.document) is not None
        reading.session.repeats._known.clear()
        assert ran(repeating, line) == ran(reading, line)
        assert to_json(repeating.document) == to_json(reading.document)
        assert repeating.document.history.labels == reading.document.history.labels
    assert hits >= 12


def test_a_refused_repetition_names_the_place_in_the_line():
    sketch = Sketch()
    sketch.run("add_line 0,0 3,0\nlength L0 4\nlength L0 5")
    with pytest.raises(AraelError) as refused:
        sketch.run("length L0 0", "script")
    assert refused.value.diagnostics[0].code == "E1220"
    assert "script:1:1" in str(refused.value)


def test_faces_are_called_after_a_repetition():
    sketch = Sketch()
    sketch.run("add_line 0,0 3,0\nlength L0 4\nlength L0 5")
    called = []
    sketch.session.after_line = lambda: called.append(1)
    sketch.run("length L0 6")
    assert called == [1]


def test_a_dimension_that_was_put_back_is_read_anew():
    sketch = Sketch()
    sketch.run("add_line 0,0 3,0\nlength L0 4\nlength L0 5")
    repeats = sketch.session.repeats
    assert repeats.find("length L0 6", sketch.document) is not None
    sketch.run("undo")
    assert repeats.find("length L0 6", sketch.document) is None


def called(sketch: Sketch, line: str) -> str:
    """A line by the method of its word: what it made, or why it was refused."""
    word, *words = line.split()
    try:
        return str(getattr(sketch, word)(*words))
    except AraelError as refused:
        return str(refused)


def test_a_method_that_repeats_does_what_one_does_that_is_read_anew():
    """It makes no reply, which is the one thing that is left out."""
    repeating, reading = Sketch(), Sketch()
    for sketch in (repeating, reading):
        sketch.run(DRAWN)
    lines = [f"length L0 {value}" for value in (41, 42.5, 0, 43, 44, 1e9, 45)]
    lines += [f"angle L4 L5 {value}" for value in (51, 52, 200, 53)]
    lines += [f"hdistance L4.p1 L4.p2 {value}" for value in (31, -32, 33)]
    for line in [*lines, "undo", *lines]:
        reading.session.repeats._known.clear()
        assert called(repeating, line) == called(reading, line)
        assert to_json(repeating.document) == to_json(reading.document)
        assert repeating.document.history.labels == reading.document.history.labels
        assert repeating.session.editor.notices == reading.session.editor.notices == []


def test_a_method_that_repeats_gives_the_dimension():
    sketch = Sketch()
    sketch.run("add_line 0,0 3,0")
    first, *others = (sketch.length("L0", value) for value in (4, 5, 6))
    assert [str(one) for one in (first, *others)] == ["d0"] * 3
    assert first.value == 6
    assert all(type(one) is type(first) for one in others)
