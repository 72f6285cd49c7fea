"""`offset`: curves beside a sequence, which follow it and bring no freedom of their own."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.importing import take_over
from arael.sketch.commands.session import Session
from tests.sketch.groups.support import at, code, freedom, number, sketch

_L = "add_line 0,0 10,0 10,6"
_RECT = "add_rect 0,0 10,6"
_ROUNDED = "add_rect 0,0 10,6\nfillet L0 L1 L1 L2 L2 L3 L3 L0 1"
_SLOT = "add_slot 0,0 10,0 2"
_MIXED = (
    "add_line 0,0 6,0\nadd_arc 6,0 10,4 8.82842712474619,1.1715728752538097\nadd_line 10,4 14,4"
)


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("add_line 0,0 5,0", "L0 2"),
        ("add_circle 0,0 3", "A0 1"),
        ("add_circle 0,0 3", "A0 1 symmetric"),
        ("add_circle 0,0 3", "A0 1 outward"),
        ("add_arc 5,0 0,5 3.5355339,3.5355339", "A0 1 2"),
        (_L, "L0 L1 1"),
        (_L, "L0 L1 1 right"),
        (_L, "L0 L1 1 right round"),
        (_L, "L0 L1 1 symmetric caps line"),
        (_L, "L0 L1 1 symmetric caps round"),
        (_L, "L0 L1 1 2 caps line round"),
        (_L, "L0 L1 1 symmetric caps round right round"),
        (_RECT, "L0 L1 L2 L3 1 inward"),
        (_RECT, "L0 L1 L2 L3 1 outward"),
        (_RECT, "L0 L1 L2 L3 1 outward round"),
        (_RECT, "L0 L1 L2 L3 1 inward round"),
        (_RECT, "L0 L1 L2 L3 1 symmetric round"),
        (_ROUNDED, "sequence L0 0.5 inward"),
        (_ROUNDED, "sequence L0 0.5 outward"),
        (_ROUNDED, "sequence L0 2 inward"),
        (_SLOT, "sequence L0 1 symmetric"),
        (_MIXED, "sequence L0 1 symmetric"),
        (_MIXED, "sequence L0 1 symmetric caps round"),
        ("add_ellipse 0,0 5 3 30", "EA0 1"),
        ("add_ellipse 0,0 5 3 30", "EA0 1 outward"),
        ("add_earc 5,0 0,3 5 3 0", "EA0 1 symmetric"),
    ],
)
def test_an_offset_has_no_freedom_of_its_own_and_undo_takes_it_back(
    script: str, words: str
) -> None:
    s = sketch(script)
    before, values = freedom(s), s.document.values.tobytes()
    s.run(f"offset {words}")
    assert freedom(s) == before
    s.document.undo()
    assert s.document.values.tobytes() == values
    assert not any(one.kind == "offset" for one in s.document.groups.values())


@pytest.mark.parametrize(
    ("words", "corner"),
    [
        ("L0 L1 1", (9, 1)),
        ("L0 L1 1 right", (11, -1)),
        ("L0 L1 -1", (11, -1)),
        ("L0 L1 1 flip", (11, -1)),
        ("L1 L0 1", (9, 1)),
    ],
)
def test_sides_of_an_open_sequence(words: str, corner: tuple[float, float]) -> None:
    s = sketch(f"{_L}\noffset {words}")
    ends = [at(s, f"{line}.{end}") for line in ("L2", "L3") for end in ("p1", "p2")]
    assert sum(end == pytest.approx(corner) for end in ends) == 2


@pytest.mark.parametrize(("word", "low"), [("inward", 1), ("outward", -1)])
@pytest.mark.parametrize("first", ["L0 L1 L2 L3", "L2 L1 L0 L3"])
def test_inside_and_outside_of_a_closed_sequence(first: str, word: str, low: float) -> None:
    s = sketch(f"{_RECT}\noffset {first} 1 {word}")
    points = [at(s, f"L{k}.p1") for k in range(4, 8)]
    assert min(x for x, _ in points) == pytest.approx(low)
    assert min(y for _, y in points) == pytest.approx(low)


def test_two_distances_make_two_sides() -> None:
    s = sketch("add_line 0,0 5,0\noffset L0 2 3")
    assert at(s, "L1.p1") == pytest.approx((0, 2))
    assert at(s, "L2.p1") == pytest.approx((0, -3))


def test_a_round_corner_is_an_arc_about_the_corner() -> None:
    s = sketch(f"{_L}\nm = offset L0 L1 1 right round")
    assert at(s, "A0.center") == pytest.approx((10, 0))
    assert number(s, "A0.radius") == pytest.approx(1)
    assert at(s, "A0.start") == pytest.approx((10, -1))


def test_an_offset_follows_its_source_and_a_parameter() -> None:
    s = sketch(f"param w 0.5\n{_ROUNDED}\noffset sequence L0 w inward; lock L0.p1")
    group = s.document.groups["M0"]
    assert len(group.results) == 8
    for script, distance in (("drag L1.p2 14,9", 0.5), ("param w 0.25", 0.25)):
        s.run(script)
        for pair in zip(group.sources, group.results, strict=True):
            assert s.editor.measure("distance", pair) == pytest.approx(distance)


def test_one_dimension_has_the_distance_and_the_others_read_it() -> None:
    s = sketch(f"{_RECT}\noffset L0 L1 L2 L3 1 inward")
    texts = [one.value.text for one in s.document.dimensions.values() if one.value]
    assert texts == ["1", "d0", "d0", "d0"]


def test_an_arc_of_a_smaller_radius_vanishes() -> None:
    s = sketch(f"{_ROUNDED}\n")
    reply = s.run("offset sequence L0 2 inward")[-1]
    assert "vanished: A0 A1 A2 A3" in reply.text
    assert len(s.document.groups["M0"].results) == 4


def test_an_ellipse_is_approximated_and_that_is_shown() -> None:
    s = sketch("add_ellipse 0,0 5 3 0")
    assert "approximate" in s.run("offset EA0 1 outward")[-1].text
    assert number(s, "EA1.radius") == pytest.approx(6)
    s.run("radius EA0 7")
    assert number(s, "EA1.radius") == pytest.approx(8)


@pytest.mark.parametrize(
    ("script", "command", "said"),
    [
        (_RECT, "offset L0 L1 L2 L3 4 inward", "less than 3"),
        ("add_circle 0,0 3", "offset A0 4", "less than 3"),
        (_L, "offset L0 L1 7", "less than 6"),
        ("add_line 0,0 4,0 4,3 3,3 3,1", "offset L0 L1 L2 L3 0.7", "less than 0.5"),
        ("add_ellipse 0,0 5 3 0", "offset EA0 4", "less than 3"),
        ("add_spline 0,0 1,2 3,2 4,0", "offset S0 1", "a spline"),
        ("add_line 0,0 5,0", "offset L0 1 symmetric caps round one caps line", "one side"),
        (_RECT, "offset L0 L1 L2 L3 1 symmetric caps line", "closed"),
        ("add_line 0,0 5,0 1,0", "offset L0 L1 1", "doubles back"),
    ],
)
def test_offsets_that_do_not_exist(script: str, command: str, said: str) -> None:
    s = sketch(script)
    values = s.document.values.tobytes()
    with pytest.raises(AraelError) as caught:
        s.run(command)
    one = caught.value.diagnostics[0]
    assert one.code == "E1273"
    assert said in " ".join([one.message, *one.help])
    assert s.document.values.tobytes() == values
    assert not s.document.groups


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("offset", "E1251"),
        ("offset L0", "E1251"),
        ("offset L0 0", "E1257"),
        ("offset L0 2 -3", "E1257"),
        ("offset L0 2 3 4", "E1252"),
        ("offset L0 L3 2", "E1256"),
        ("offset L0 2 inward", "E1256"),
        ("offset L0 L1 A0 2", "E1256"),
        ("offset L0 2 caps square", "E1252"),
        ("offset L0 2 wide", "E1262"),
        ("offset P0 2", "E1256"),
    ],
)
def test_mistakes_in_an_offset(command: str, expected: str) -> None:
    s = sketch(
        "add_line 0,0 5,0 5,5; add_line 20,0 25,0; add_line 30,0 31,0\n"
        "add_circle 9,9 1; add_point 1,1"
    )
    assert code(s, command) == expected
    assert not s.document.groups


@pytest.mark.parametrize(
    ("script", "edit"),
    [
        ("offset L0 L1 1", "2"),
        ("offset L0 L1 1", "flip"),
        ("offset L0 L1 1", "right round"),
        ("offset L0 L1 1 right round", "sharp"),
        ("offset L0 L1 1", "symmetric"),
        ("offset L0 L1 1 symmetric", "one"),
        ("offset L0 L1 1", "two 2 3"),
        ("offset L0 L1 1 2", "symmetric 1.5"),
        ("offset L0 L1 1 symmetric", "caps line"),
        ("offset L0 L1 1 symmetric caps line", "2"),
        ("offset L0 L1 1 symmetric caps line", "caps round"),
        ("offset L0 L1 1 symmetric caps round", "caps none"),
        ("offset L0 L1 1 symmetric caps round", "2 flip"),
        ("offset L0 L1 1 symmetric round", "flip"),
        ("offset L0 L1 1 nopin", "pin"),
    ],
)
def test_an_edited_offset_is_what_would_have_been_made(script: str, edit: str) -> None:
    s = sketch(_L)
    before = freedom(s)
    s.run(script)
    values = s.document.values.tobytes()
    s.run(f"offset M0 {edit}")
    assert freedom(s) == before
    group = s.document.groups["M0"]
    options = group.options
    words = [str(options["distance"]), str(options["distance2"])]
    words += ["left" if options["side"] == 1 else "right"]
    words += ["symmetric"] if options["form"] == "symmetric" else []
    words += ["round"] if options["round"] else []
    words += ["caps", str(options["caps"])]
    fresh = sketch(f"{_L}\noffset L0 L1 {' '.join(filter(None, words))}")

    def shapes(of: Session) -> list[float]:
        results = of.document.groups["M0"].results
        found = sorted(of.document.numbers_of(n).round(9).tolist() for n in results)
        return [x for numbers in found for x in numbers]

    assert shapes(s) == pytest.approx(shapes(fresh))
    s.document.undo()
    assert s.document.values.tobytes() == values


def test_entities_of_a_side_that_stays_keep_their_names() -> None:
    s = sketch(f"{_L}\noffset L0 L1 1")
    s.run("offset M0 2; offset M0 flip; offset M0 symmetric; offset M0 nopin; offset M0 pin")
    assert s.document.groups["M0"].results[:2] == ("L2", "L3")


def test_pins_are_taken_off_and_put_back() -> None:
    s = sketch(_L)
    before = freedom(s)
    s.run("offset L0 L1 1 nopin")
    assert freedom(s) == before + 2
    s.run("offset M0 pin")
    assert freedom(s) == before


def test_a_selected_group_is_edited_and_a_selected_sequence_offset() -> None:
    s = sketch(f"{_L}\nselect L0 L1; offset selection 1; deselect; select M0; offset selection 2")
    assert at(s, "L2.p1") == pytest.approx((0, 2))


def test_the_group_and_its_results_are_captured() -> None:
    s = sketch(f"{_L}\nm = offset L0 L1 2\nlist metas")
    assert s.resolve("m") == "M0"
    assert s.resolve("_0") == "L2"


@pytest.mark.parametrize(
    ("script", "dissolves"),
    [
        ("length L2 12 force", False),
        ("param w 2", False),
        ("drag L0.p1 1,1", False),
        ("dim_pos d0 offset 2", False),
        ("add_circle 20,20 1", False),
        ("delete C2", True),
        ("distance L0 L2 2", True),
        ("set_derived d0", True),
        ("set_driven d1 2", True),
        ("delete d1", True),
        ("delete L2", True),
        ("delete L0", True),
        ("add_line 4,-5 4,5; split L2 4,1", True),
        ("add_line 4,-5 4,5; split L0 4,0", True),
        ("delete M0", True),
    ],
)
def test_what_dissolves_an_offset(script: str, dissolves: bool) -> None:
    s = sketch(f"param w 1\n{_L}\nlock L0.p2\noffset L0 L1 w")
    replies = s.run(script)
    assert ("M0" not in s.document.groups) == dissolves
    told = "M0" in " ".join(reply.text for reply in replies)
    assert told == dissolves
    s.document.undo()
    assert "M0" in s.document.groups


def test_deleting_a_pin_keeps_the_group() -> None:
    s = sketch(f"{_L}\noffset L0 L1 1")
    pins = s.document.groups["M0"].options["pins"]
    assert isinstance(pins, tuple)
    before = freedom(s)
    s.run(f"delete {pins[0]}")
    assert freedom(s) == before + 1
    s.run("offset M0 2; offset M0 round; offset M0 nopin; offset M0 pin")
    assert "M0" in s.document.groups
    assert freedom(s) == before


def test_deleting_with_all_takes_the_results() -> None:
    s = sketch(f"{_L}\noffset L0 L1 1 symmetric caps round; delete M0 all")
    assert list(s.document.entities) == ["L0", "L1"]
    assert not s.document.dimensions


def test_groups_taken_over_from_another_sketch_can_be_edited() -> None:
    s = sketch("add_line 50,0 60,0\nadd_circle 50,9 1; offset L0 1")
    other = sketch(
        f"param w 1\n{_L}\nadd_point 0,0\noffset L0 L1 w\npattern circular L0 about P0 3 partial 40"
    )
    names = take_over(s, other.document)
    before = freedom(s)
    s.run(f"offset {names['M0']} w*2; offset {names['M0']} nopin; offset {names['M0']} pin")
    s.run(f"pattern {names['M1']} 5")
    assert freedom(s) == before
    assert at(s, f"{names['L2']}.p1") == pytest.approx((0, 2))
    assert s.document.groups[names["M1"]].options["about"] == names["P0"]
