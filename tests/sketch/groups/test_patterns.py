"""`pattern`: copies are rigid images, editing keeps those that stay."""

from __future__ import annotations

import math

import pytest

from tests.sketch.groups.support import at, code, freedom, number, sketch

_SET = "add_line 2,0 3,0 3,1\nadd_circle 4,4 1\nadd_point 0,0"


def test_circular_copies_follow_their_source() -> None:
    s = sketch(_SET)
    before = freedom(s)
    s.run("m = pattern circular L0 L1 A0 about P0 4")
    assert freedom(s) == before
    assert at(s, "L2.p1") == pytest.approx((0, 2))
    s.run("lock P0; drag L0.p1 2,1")
    x, y = at(s, "L0.p1")
    assert at(s, "L2.p1") == pytest.approx((-y, x))
    assert at(s, "L3.p1") == at(s, "L2.p2")


@pytest.mark.parametrize(
    ("words", "turns"),
    [("full", [120, 240]), ("partial 90", [45, 90]), ("symmetric 90", [-45, 45])],
)
def test_spreads_of_circular_patterns(words: str, turns: list[float]) -> None:
    s = sketch(f"add_line 2,0 3,0\nadd_point 0,0\npattern circular L0 about P0 3 {words}")
    found = [math.degrees(math.atan2(*at(s, f"L{i}.p1")[::-1])) % 360 for i in (1, 2)]
    assert found == pytest.approx([turn % 360 for turn in turns])


@pytest.mark.parametrize(
    ("words", "places"),
    [
        ("3 10", [(12, 0), (22, 0)]),
        ("2 10 by 2 5", [(12, 0), (2, 5), (12, 5)]),
        ("3 30 extent along L1", [(2, 15), (2, 30)]),
        ("3 4 symmetric", [(-2, 0), (6, 0)]),
        ("2 -10", [(-8, 0)]),
    ],
)
def test_forms_of_rectangular_patterns(words: str, places: list[tuple[float, float]]) -> None:
    s = sketch("add_line 2,0 3,0\nadd_line 9,9 9,12")
    before = freedom(s)
    s.run(f"m = pattern rect L0 {words}")
    assert freedom(s) == before
    found = [at(s, f"{name}.p1") for name in s.document.groups["M0"].results]
    for there, place in zip(sorted(found), sorted(places), strict=True):
        assert there == pytest.approx(place)


def test_an_edit_keeps_copies_and_what_hangs_on_them() -> None:
    s = sketch("add_line 2,0 3,0\npattern rect L0 3 10\nadd_line 13,0 13,5")
    kept = s.document.groups["M0"].results[0]
    s.run("pattern M0 2 12")
    assert s.document.groups["M0"].results == (kept,)
    assert at(s, f"{kept}.p1") == pytest.approx((14, 0))
    assert at(s, "L3.p1") == pytest.approx(at(s, f"{kept}.p2"))
    s.run("pattern M0 by 2 6")
    assert len(s.document.groups["M0"].results) == 3
    s.document.undo()
    assert s.document.groups["M0"].results == (kept,)


def test_another_centre_and_angle() -> None:
    s = sketch("add_line 2,0 3,0\nadd_point 0,0\nadd_point 1,0\npattern circular L0 about P0 2")
    s.run("pattern M0 about P1")
    assert at(s, "L1.p1") == pytest.approx((0, 0))
    s.run("pattern M0 partial 90")
    assert at(s, "L1.p1") == pytest.approx((1, 1))


def test_life_of_a_pattern() -> None:
    s = sketch("add_line 2,0 3,0\npattern rect L0 2 10\npattern rect L0 2 20")
    assert "M0" in s.run("info M0")[0].text
    assert "M1" in s.run("list metas")[0].text
    s.run("select M0")
    assert "notice: M0" in s.run("delete L1")[0].text
    s.run("delete M1 all")
    assert list(s.document.entities) == ["L0"]
    assert not s.document.constraints


def test_dissolving_keeps_images() -> None:
    s = sketch("add_line 2,0 3,0\npattern rect L0 2 10\ndelete M0")
    assert not s.document.groups
    assert number(s, "L1.length") == pytest.approx(1)
    assert [one.kind for one in s.document.constraints.values()] == ["image"]


@pytest.mark.parametrize(
    "words",
    ["rect L0 1 10", "rect L0 2 0", "circular L0 about P0 1", "circular L0 about P0 3 partial 0"],
)
def test_patterns_without_extent_are_refused(words: str) -> None:
    s = sketch("add_line 2,0 3,0\nadd_point 0,0")
    assert code(s, f"pattern {words}") == "E1257"
    assert list(s.document.entities) == ["L0", "P0"]


@pytest.mark.parametrize("words", ["rect L0 2 5 along L0", "circular L0 P0 about P0 3"])
def test_a_reference_in_the_set_is_refused(words: str) -> None:
    s = sketch("add_line 2,0 3,0\nadd_point 0,0")
    assert code(s, f"pattern {words}") == "E1256"


def test_distances_and_angles_of_a_pattern_follow_parameters() -> None:
    s = sketch("param w 10; param turn 90\nadd_line 2,0 3,0\nadd_point 0,0")
    before = freedom(s)
    s.run("pattern rect L0 3 w by 2 w/2\npattern circular L0 about P0 2 partial turn")
    rect, turned = s.document.groups["M0"].results, s.document.groups["M1"].results
    values, steps = s.document.values.tobytes(), len(s.document.history.done)
    s.run("param w 20")
    assert sorted(at(s, f"{name}.p1") for name in rect) == [
        pytest.approx(place) for place in [(2, 10), (22, 0), (22, 10), (42, 0), (42, 10)]
    ]
    s.run("param turn 180")
    assert at(s, f"{turned[0]}.p1") == pytest.approx((-2, 0))
    assert freedom(s) == before
    s.run("rename_param w step; param step 1")
    assert s.document.groups["M0"].options["distance2_text"] == "step/2"
    assert at(s, f"{rect[0]}.p1") == pytest.approx((3, 0))
    s.run("pattern M0 4 step*2; pattern M1 full")
    assert at(s, f"{rect[0]}.p1") == pytest.approx((4, 0))
    assert "broken: M0" in s.run("del_param step")[0].text
    s.run("drag L0 @1,0")
    while len(s.document.history.done) > steps:
        s.document.undo()
    assert s.document.values.tobytes() == values


def test_a_pattern_does_not_follow_geometry() -> None:
    s = sketch("add_line 2,0 3,0\nadd_line 9,9 9,12")
    assert code(s, "pattern rect L0 3 L1.length") == "E1257"
    s.run("pattern rect L0 3 =L1.length")
    assert at(s, "L2.p1") == pytest.approx((5, 0))
