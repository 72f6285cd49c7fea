"""Lines, chains, variables, cursor: what a session does around commands."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json
from arael.sketch.expressions.vectors import Vec
from tests.sketch.stand_in import StandIn


@pytest.fixture
def session() -> Session:
    return Session(StandIn(), make_editor=StandIn)


def said(session: Session, text: str) -> list[str]:
    return [reply.text for reply in session.run(text)]


def test_a_line_is_one_step_of_undo(session: Session) -> None:
    session.run("add_line 0,0 5,0; horizontal L0; length L0 3  # three commands")
    assert session.document.history.labels == ["add_line 0,0 5,0; horizontal L0; length L0 3"]
    session.run("undo")
    assert not session.document.entities


def test_a_line_that_fails_changes_nothing(session: Session) -> None:
    session.run("cursor 1,1\nx = 3")
    before, state = to_json(session.document), session.state.copy()
    with pytest.raises(AraelError):
        session.run("add_line 0,0 5,0; x = 4; select L0; length L7 3")
    assert to_json(session.document) == before
    assert session.state == state


def test_lines_before_the_one_that_fails_stay(session: Session) -> None:
    with pytest.raises(AraelError) as caught:
        session.run("add_line 0,0 5,0\n\nlength L7 3\nadd_line 0,0 1,1", "part.cmd")
    assert list(session.document.entities) == ["L0"]
    assert str(caught.value.diagnostics[0].span) == "part.cmd:3:8"


def test_comments_and_quotes(session: Session) -> None:
    session.run('add_line 0,0 5,0 # a comment; length L0 3\n# another\nlength L0 "2 * 2"')
    assert session.document.dimensions["d0"].value.number == 4  # type: ignore[union-attr]


def test_history_commands_in_a_chain_are_steps_of_their_own(session: Session) -> None:
    session.run("add_line 0,0 5,0; undo; add_line 0,0 1,1")
    assert session.document.numbers_of("L0").tolist() == [0, 0, 1, 1]
    assert session.document.history.labels == ["add_line 0,0 1,1"]


def test_names_of_what_was_made(session: Session) -> None:
    session.run("add_line 0,0 5,0; vertical _; length _ 3")
    assert set(session.document.constraints) == {"CL0V"}
    session.run("base = _")
    session.run("a, b, c = add_line 0,0 @1,0 @0,1 @-1,0")
    assert [session.variable(name) for name in "abc"] == ["L1", "L2", "L3"]
    assert [session.variable(f"_{i}") for i in range(3)] == ["L1", "L2", "L3"]
    assert session.variable("_") == "L1"
    session.run("perpendicular a b; coincident a.p2 c.p2 force")
    made = list(session.document.constraints.values())[-2:]
    assert [one.args for one in made] == [("L1", "L2"), ("L1.p2", "L3.p2")]


def test_dimensions_are_named_by_assignment_only(session: Session) -> None:
    session.run("add_line 0,0 5,0; ia = length L0 5")
    assert session.variable("ia") == "d0"
    assert session.variable("_") == "L0"
    session.run("add_line 0,0 1,1; length _ ia*2")
    made = session.document.dimensions["d1"]
    assert made.args == ("L1",)
    assert made.value is not None
    assert (made.value.text, made.value.number) == ("d0*2", 10.0)


def test_variables_of_every_sort(session: Session) -> None:
    session.run("base = add_line 0,0 4,0")
    assert said(session, "p = base.p2; let n = normal(base); d = dist(p, base) + 2") == [
        "p = (4, 0)",
        "n = (0, 1)",
        "d = 2",
    ]
    session.run("top = add_line p p + n * d")
    assert session.document.numbers_of("L1").tolist() == [4, 0, 4, 2]
    assert said(session, "print p.x*2 base.length top d")[0].split("\n") == [
        "p.x*2 = 8",
        "base.length = 4",
        "L1: line (4, 0)-(4, 2), length 2",
        "d = 2",
    ]


def test_a_dimension_keeps_what_a_variable_is_now(session: Session) -> None:
    session.run("base = add_line 0,0 4,0; n = 2; p = 3,-4; length base n*base.p2.x - p.y")
    value = session.document.dimensions["d0"].value
    assert value is not None
    assert (value.text, value.number) == ("2*L0.p2.x - (-4)", 12.0)


def test_coordinates_of_every_form(session: Session) -> None:
    session.run("add_line 0,0 4,0; param w 3; q = 7,8")
    forms = {
        "5,3": (5, 3),
        "@1,1": (5, 1),
        "cursor": (4, 0),
        "@cursor": (4, 0),
        "L0.p1": (0, 0),
        "q": (7, 8),
        "midpoint(L0)": (2, 0),
        "w,L0.length*2": (3, 8),
        "w + 1, 2": (4, 2),
        "L0.p2+normal(L0)*3": (4, 3),
        "(1 + 1),(2*3)": (2, 6),
        "1 cm,0.5 in": (10, 12.7),
        "cursor + @tangent": (5, 0),
        "-1.5,.5": (-1.5, 0.5),
        "rotate(L0.p2, L0.p1, 90)": (0, 4),
        "mirror(q, L0)": (7, -8),
        "along(L0, 0.25)": (1, 0),
        "project(q, L0)": (7, 0),
        "q - L0.p2*2": (-1, 8),
    }
    for form, expected in forms.items():
        session.run(f"add_point {form} nocursor noconnect")
        found = session.document.numbers_of(list(session.document.entities)[-1])
        assert found.tolist() == pytest.approx(expected), form


def test_relative_coordinates_go_on_from_the_one_before(session: Session) -> None:
    session.run("add_line 1,1 @2,0 @0,3")
    assert session.document.numbers_of("L1").tolist() == [3, 1, 3, 4]
    session.run("add_line @1,0")
    assert session.document.numbers_of("L2").tolist() == [3, 4, 4, 4]


def test_units_are_joined_with_their_number_unless_they_are_names(session: Session) -> None:
    session.run("add_line 0,0 5,0; add_line 0,1 5,2; length L0 2 cm; m = 7,7; add_line 0,5 m")
    assert session.document.dimensions["d0"].value.number == 20  # type: ignore[union-attr]
    assert session.document.numbers_of("L2").tolist() == [0, 5, 7, 7]


def test_the_unit_of_the_sketch_counts(session: Session) -> None:
    session.run("settings unit in; add_line 0,0 5,0; length L0 25.4 mm")
    assert session.document.dimensions["d0"].value.number == pytest.approx(1.0)  # type: ignore[union-attr]


def test_selection_forgets_what_is_gone(session: Session) -> None:
    session.run("add_line 0,0 5,0; add_line 5,0 5,5; select L0 L1.p2")
    session.run("delete L1")
    assert session.selection == ["L0"]


def test_a_message_is_shown_as_it_is_written(session: Session) -> None:
    assert said(session, r"msg # Title (1 \n- item") == ["# Title (1 \n- item"]


def test_cursor(session: Session) -> None:
    assert said(session, "cursor") == ["Cursor: not set"]
    assert said(session, "cursor 5,3; cursor @1,1; cursor") == [
        "Cursor: (5, 3)",
        "Cursor: (6, 4)",
        "Cursor: (6, 4)",
    ]
    session.run("add_line 0,0 0,5")
    assert (session.state.cursor, session.state.tangent) == (Vec(0, 5), Vec(0, 1))
    session.run("add_line 0,0 1,0 nocursor")
    assert session.state.cursor == Vec(0, 5)
    session.run("hide")
    assert not session.state.cursor_shown
    session.run("cursor on")
    assert session.state.cursor_shown


def test_view(session: Session) -> None:
    session.run("add_circle 3,4 1; center A0; zoom 2; zoom +")
    assert session.state.view.center == (3, 4)
    assert session.state.view.zoom == 2.5
    session.run("center")
    assert (session.state.view.center, session.state.view.zoom) == (None, 1.0)


@pytest.mark.parametrize("word", ["L0", "L0.p1", "C0", "d0", "a"])
def test_a_bare_name_is_answered_by_the_command_that_shows_it(word: str) -> None:
    session = Session()
    session.run("a, b = add_line 0,0 5,0 5,3; length a 5")
    with pytest.raises(AraelError) as caught:
        session.run(word)
    assert caught.value.diagnostics[0].help == (f"`info {word}` shows what it is",)
