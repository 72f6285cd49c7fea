"""`constr`, `quiet`, `style`, `lock`, `unlock`."""

from __future__ import annotations

import pytest

from tests.sketch.modify.drawn import at, refused, run, sketch, state

DRAWN = "add_line 0,0 5,0; add_circle 9,9 1; add_point 3,3"


@pytest.mark.parametrize(("word", "flag"), [("constr", "construction"), ("quiet", "quiet")])
def test_a_flag_toggles_and_is_set(word: str, flag: str) -> None:
    session = sketch(DRAWN)

    def flags() -> list[bool]:
        return [getattr(session.document.entities[n], flag) for n in ("L0", "A0", "P0")]

    run(session, f"{word} L0")
    assert flags() == [True, False, False]
    run(session, f"{word} L0 A0 on")
    assert flags() == [True, True, False]
    run(session, f"{word} L0 A0 P0")
    assert flags() == [False, False, True]
    session.run(f"select A0; {word} selection on")
    assert flags() == [False, True, True]
    run(session, f"{word} P0 off")
    assert flags() == [False, True, False]
    before, steps = state(session), session.document.history.position
    run(session, f"{word} L0 A0 P0")
    assert session.document.history.position == steps + 1
    session.run("undo")
    assert state(session) == before
    assert refused(session, f"{word}")[0] == "E1251"
    assert refused(session, f"{word} L9")[0::2] == ("E1201", "L9")
    assert refused(session, f"{word} L0.p1")[0::2] == ("E1256", "L0.p1")
    assert refused(session, f"{word} L0 of")[0] in ("E1252", "E1256")
    assert refused(session, f"{word} L0 on off")[0::2] == ("E1252", "off")


def test_styles_are_set_and_asked_for() -> None:
    session = sketch(DRAWN)
    for style in ("dashed", "dashdot", "solid"):
        run(session, f"style L0 A0 {style}")
        assert run(session, "style L0 A0").text == f"L0: {style}\nA0: {style}"
    session.run("select L0; style selection dashed")
    assert session.document.entities["L0"].style == "dashed"
    assert refused(session, "style L0 dotted")[0::2] == ("E1252", "dotted")
    assert refused(session, "style")[0] == "E1251"
    assert refused(session, "style L9")[0::2] == ("E1201", "L9")
    assert refused(session, "style P0 dashed")[0::2] == ("E1256", "P0")


def test_locks() -> None:
    session = sketch(DRAWN)
    run(session, "lock L0.p1")
    run(session, "drag L0.p1 1,1")
    assert at(session, "L0.p1") == pytest.approx((0, 0), abs=1e-9)
    run(session, "lock L0.p1 2,1")
    assert at(session, "L0.p1") == pytest.approx((2, 1))
    run(session, "unlock L0.p1")
    run(session, "drag L0.p1 1,1")
    assert at(session, "L0.p1") == pytest.approx((1, 1))
    assert refused(session, "unlock P0")[0::2] == ("E1268", "P0")
    assert refused(session, "lock L0")[0::2] == ("E1256", "L0")
