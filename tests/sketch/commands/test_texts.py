"""`add_text`, `set_text`, and what other commands do with the frame of a text."""

from __future__ import annotations

import math

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch import Sketch
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json
from arael.sketch.text import height_of, width_of


def session(text: str) -> Session:
    found = Session()
    found.run(text)
    return found


def numbers(found: Session, name: str) -> list[float]:
    values: list[float] = found.document.numbers_of(name).tolist()
    return values


def length(found: Session, name: str) -> float:
    x1, y1, x2, y2 = numbers(found, name)
    return math.hypot(x2 - x1, y2 - y1)


def code(found: Session, line: str) -> str:
    before = to_json(found.document)
    with pytest.raises(AraelError) as caught:
        found.run(line)
    assert to_json(found.document) == before
    return caught.value.diagnostics[0].code


# --- add_text -------------------------------------------------------------------------------------


def test_the_frame_is_a_line_as_long_as_the_text() -> None:
    s = session('add_text 1,2 "Ø8 ±0.1" height 5 angle 90')
    frame = s.document.entities["L0"]
    assert (frame.kind, frame.text) == ("line", "Ø8 ±0.1")
    assert numbers(s, "L0") == pytest.approx([1, 2, 1, 2 + 5 * width_of("Ø8 ±0.1")])
    assert s.editor.judge.freedoms().total == 4


@pytest.mark.parametrize(("unit", "height"), [("mm", 3.5), ("cm", 0.35), ("m", 0.0035)])
def test_the_height_is_three_and_a_half_millimetres_by_default(unit: str, height: float) -> None:
    s = Session()
    with s.document.transaction("unit"):
        s.document.set_setting("unit", unit)
    s.run('add_text 0,0 "abc"')
    assert height_of("abc", length(s, "L0")) == pytest.approx(height)


def test_the_frame_takes_constraints_and_dimensions_and_the_text_follows() -> None:
    s = session('t = add_text 0,0 "abc" height 5 angle 10\nhorizontal t\nlength t 40\nlock t.p1')
    assert numbers(s, "L0") == pytest.approx([*numbers(s, "L0")[:2], *numbers(s, "L0")[2:]])
    assert length(s, "L0") == pytest.approx(40)
    assert s.editor.judge.freedoms().total == 0
    (reply,) = s.run("info t")
    assert f'text "abc", height {40 / width_of("abc"):.6g}' in reply.text
    assert reply.data["text"] == "abc"


def test_dragging_an_end_scales_and_turns_the_text() -> None:
    s = session('add_text 0,0 "abc"\nlock L0.p1\ndrag L0.p2 0,20')
    assert numbers(s, "L0") == pytest.approx([0, 0, 0, 20], abs=1e-6)
    assert s.document.entities["L0"].text == "abc"


def test_words_of_add_text_may_stand_in_any_order() -> None:
    s = session('add_text 0,0 "a" quiet height 2 constr angle 30 noconnect nocursor')
    frame = s.document.entities["L0"]
    assert frame.quiet and frame.construction and s.state.cursor is None
    s.run('add_text 0,0 "b" angle 30 height 2')
    made = [c.args for c in s.document.constraints.values()]
    assert made == [("L1.p1", "L0.p1"), ("L1.p2", "L0.p2")]


def test_lines_do_not_go_on_from_a_text() -> None:
    s = session('add_line 0,0 1,0\nadd_text 5,5 "a"\nadd_line 1,9')
    assert numbers(s, "L2") == pytest.approx([1, 0, 1, 9])


def test_a_quote_within_a_text_is_written_twice() -> None:
    s = session('add_text 0,0 "1/4"" ""BSP"""')
    assert s.document.entities["L0"].text == '1/4" "BSP"'
    (reply,) = s.run("list")
    assert 'text "1/4"" ""BSP"""' in reply.text


def test_semicolons_and_hashes_within_a_text_are_text() -> None:
    s = session('add_text 0,0 "a; delete L0 # b"; add_point 1,1')
    assert s.document.entities["L0"].text == "a; delete L0 # b"
    assert "P0" in s.document.entities


def test_characters_that_the_font_does_not_have_are_listed() -> None:
    (reply,) = Session().run('add_text 0,0 "a→שלום"')
    assert "[drawn as a box: U+2192, U+05E9, U+05DC, U+05D5, U+05DD]" in reply.text
    assert reply.data["unknown"] == "→שלום"
    (reply,) = Session().run('add_text 0,0 "M6"')
    assert "box" not in reply.text


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ('add_text 0,0 ""', "E1285"),
        ('add_text 0,0 "  "', "E1285"),
        ('add_text 0,0 "a\tb"', "E1285"),
        ('add_text 0,0 "a\u202eb"', "E1285"),
        (f'add_text 0,0 "{"x" * 201}"', "E1285"),
        ("add_text 0,0 hello", "E1252"),
        ("add_text 0,0", "E1251"),
        ('add_text "a"', "E1262"),
        ('add_text 0,0 "a', "E1258"),
        ('add_text 0,0 "a"b"', "E1258"),
        ('add_text 0,0 "a" "b"', "E1252"),
        ('add_text 0,0 "a" heigth 3', "E1252"),
        ('add_text 0,0 "a" height', "E1251"),
        ('add_text 0,0 "a" height 0', "E1257"),
        ('add_text 0,0 "a" height 3 deg', "E1261"),
        ('add_text 0,0 "a" height 1 height 2', "E1267"),
        ('add_text 0,0 "a" height 1e200', "E1220"),
        ('set_text L0 "b"', "E1256"),
        ('set_text "b"', "E1251"),
        ("set_text L1", "E1251"),
        ("set_text L1 b", "E1252"),
        ("set_text L9 b", "E1201"),
        ('set_text L1 "\n"', "E1258"),
        ('set_text L1 " "', "E1285"),
    ],
)
def test_what_is_no_text_is_refused(line: str, expected: str) -> None:
    s = session('add_line 0,9 5,9 nocursor\nadd_text 0,20 "a" nocursor')
    assert code(s, line) == expected


# --- set_text -------------------------------------------------------------------------------------


def test_a_changed_text_keeps_its_height_if_the_frame_is_free() -> None:
    s = session('add_text 1,2 "first" height 5\nset_text L0 "the second"')
    assert s.document.entities["L0"].text == "the second"
    assert numbers(s, "L0") == pytest.approx([1, 2, 1 + 5 * width_of("the second"), 2])


def test_a_changed_text_in_a_held_frame_leaves_the_frame_where_it_is() -> None:
    s = session('add_text 1,2 "first" height 5\nlength L0 30')
    before = numbers(s, "L0")
    s.run('set_text L0 "the second"')
    assert numbers(s, "L0") == before
    assert s.document.entities["L0"].text == "the second"


def test_several_texts_change_in_one_step() -> None:
    s = session('add_text 0,0 "a"\nadd_text 0,9 "b"\nset_text L0 L1 "c"')
    assert [e.text for e in s.document.entities.values()] == ["c", "c"]
    s.document.undo()
    assert [e.text for e in s.document.entities.values()] == ["a", "b"]


def test_undo_and_redo_are_exact() -> None:
    s = session('add_line 0,0 10,0\nadd_text 3,1 "first" height 2 angle 20\nparallel L0 L1')
    states = [to_json(s.document)]
    for line in ('set_text L1 "second one"', "length L1 30", 'set_text L1 "→"', "delete L1"):
        s.run(line)
        states.append(to_json(s.document))
    for state in reversed(states[:-1]):
        s.document.undo()
        assert to_json(s.document) == state
    for state in states[1:]:
        s.document.redo()
        assert to_json(s.document) == state


# --- other commands -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line", ["trim L0 1,0", "trim L0 by L1 forward", "split L0 by L1", "fillet L0 L2 1",
             "chamfer L0.p2 1"]
)  # fmt: skip
def test_a_text_is_not_cut(line: str) -> None:
    s = session('add_text 0,0 "title" height 5\nadd_line 5,-5 5,5 nocursor noconnect')
    s.run(f"add_line {length(s, 'L0')!r},0 40,30")
    assert code(s, line) == "E1286"


def test_a_mirrored_text_can_be_read() -> None:
    s = session('add_text 0,0 "title" height 5\nadd_line 40,-5 40,5\nmirror L0 about L1 strict')
    x1, _, x2, _ = numbers(s, "L0")
    assert numbers(s, "L2") == pytest.approx([80 - x2, 0, 80 - x1, 0])
    assert s.document.entities["L2"].text == "title"
    before = s.editor.judge.freedoms().total
    s.run("delete L2")
    assert s.editor.judge.freedoms().total == before


def test_a_mirrored_text_follows_its_source() -> None:
    s = session('add_text 0,0 "title" height 5\nadd_line 40,-5 40,5\nmirror L0 about L1 strict')
    s.run("lock L1.p1; lock L1.p2; length L0 10; lock L0.p1 3,4; horizontal L0")
    assert numbers(s, "L2") == pytest.approx([80 - 13, 4, 80 - 3, 4])


def test_a_text_mirrored_up_and_down_runs_the_same_way() -> None:
    s = session('add_text 0,0 "title" height 5\nadd_line 0,-9 5,-9\nmirror L0 about L1 strict')
    x1, _, x2, _ = numbers(s, "L0")
    assert numbers(s, "L2") == pytest.approx([x1, -18, x2, -18])


def test_copies_of_a_pattern_have_the_text() -> None:
    s = session('add_text 5,0 "a"\nadd_point 0,0\npattern circular L0 about P0 4')
    assert [e.text for e in s.document.entities.values()] == ["a", "", "a", "a", "a"]


def test_the_offset_of_a_text_is_a_plain_line() -> None:
    s = session('add_text 0,0 "abc"\noffset L0 3\noffset_line L0 2')
    assert [e.text for e in s.document.entities.values()] == ["abc", "", ""]


def test_scaling_a_text_scales_its_lettering() -> None:
    s = session('add_text 0,0 "abc" height 5\nscale L0 about 0,0 2')
    assert height_of("abc", length(s, "L0")) == pytest.approx(10)


# --- in Python ------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["plain", "5 to 10", ">= 3", 'a "b"; delete L0 # c', '"', "L0"])
def test_any_text_can_be_given_in_python(text: str) -> None:
    sketch = Sketch()
    frame = sketch.add_text((0, 0), "first", height=5, angle=30)
    sketch.set_text(frame, text)
    other = sketch.add_text((0, 20), text, quiet=True)
    assert [e.text for e in sketch.document.entities.values()] == [text, text]
    assert sketch.document.entities[str(other)].quiet


@pytest.mark.parametrize("text", ["", "a\nb", "a\x00", 5, None])
def test_what_is_no_text_is_refused_in_python(text: object) -> None:
    sketch = Sketch()
    with pytest.raises(AraelError) as caught:
        sketch.add_text((0, 0), text)  # type: ignore[arg-type]
    assert caught.value.diagnostics[0].code == "E1285"
    with pytest.raises(AraelError):
        sketch.set_text(text)  # type: ignore[arg-type]
