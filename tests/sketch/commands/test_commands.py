"""What commands do to a document, on an editor without a solver."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands import table
from arael.sketch.commands.session import Session
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from arael.sketch.document.saved import to_json
from tests.sketch.stand_in import StandIn

SCENE = """
add_line 0,0 5,0 noconnect           # L0
add_line 1,1 4,3 noconnect           # L1
add_line 6,0 6,5 noconnect           # L2
add_line 8,0 9,4 noconnect           # L3
add_circle 2,6 1 noconnect           # A0
add_circle 7,7 2 noconnect           # A1
add_arc 10,0 10,2 11,1 noconnect     # A2
add_ellipse 15,0 3 1 20 noconnect    # EA0
add_ellipse 15,9 3 1 20 noconnect    # EA1
add_point 3,9 noconnect              # P0
add_point 4,9 noconnect              # P1
add_point 5,9 noconnect              # P2
add_spline 20,0 21,1 22,1 23,0 noconnect
param w 4
"""


@pytest.fixture
def session() -> Session:
    made = Session(StandIn(), make_editor=StandIn)
    made.run(SCENE)
    return made


def said(session: Session, text: str) -> str:
    return "\n".join(reply.text for reply in session.run(text))


def last(session: Session, table_: str) -> object:
    return list(getattr(session.document, table_).values())[-1]


CONSTRAIN = {
    "horizontal L0": ("horizontal", ("L0",)),
    "vertical L0.p1 P0": ("vertical", ("L0.p1", "P0")),
    "parallel L0 L1": ("parallel", ("L0", "L1")),
    "parallel L0 EA0": ("parallel", ("L0", "EA0")),
    "perpendicular EA0 EA1": ("perpendicular", ("EA0", "EA1")),
    "perp L0 L1": ("perpendicular", ("L0", "L1")),
    "collinear L0 L1": ("collinear", ("L0", "L1")),
    "equal A0 A1": ("equal", ("A0", "A1")),
    "equal_radius A0 A1": ("equal", ("A0", "A1")),
    "equal_length L0 L1": ("equal", ("L0", "L1")),
    "equal_angle L0 L1 L2 L3": ("equal_angle", ("L0", "L1", "L2", "L3")),
    "tangent L0 A0": ("tangent", ("L0", "A0")),
    "tangent L0.p2 S0.p1": ("tangent", ("L0.p2", "S0.p1")),
    "smooth S0.p2 L0.p1": ("smooth", ("S0.p2", "L0.p1")),
    "coincident L0.p2 L1.p1": ("coincident", ("L0.p2", "L1.p1")),
    "concentric A0 A1": ("concentric", ("A0", "A1")),
    "point_on P0 L0": ("point_on", ("P0", "L0")),
    "point_on A0.center L0": ("point_on", ("A0.center", "L0")),
    "midpoint P0 L0": ("midpoint", ("P0", "L0")),
    "midpoint L0.p1 A2": ("midpoint", ("L0.p1", "A2")),
    "symmetry P0 L0 P1": ("symmetry", ("P0", "L0", "P1")),
    "symmetry L0 L1 L2": ("symmetry", ("L0", "L1", "L2")),
    "symmetric A0 L0 A1": ("symmetry", ("A0", "L0", "A1")),
    "symmetry P0 P1 P2": ("symmetry", ("P0", "P1", "P2")),
    "on_normal L1.p2 L0.p2": ("on_normal", ("L1.p2", "L0.p2")),
    "fix L0": ("fix", ("L0",)),
}


@pytest.mark.parametrize("line", CONSTRAIN)
def test_constraint(session: Session, line: str) -> None:
    (reply,) = session.run(line)
    made = last(session, "constraints")
    assert (made.kind, made.args) == CONSTRAIN[line]  # type: ignore[attr-defined]
    assert reply.text.startswith(f"Added {made.name}: ")  # type: ignore[attr-defined]
    assert reply.names == (made.name,)  # type: ignore[attr-defined]


def test_every_kind_of_constraint_has_a_command() -> None:
    made_otherwise = {"image", "lock"}
    assert {kind for kind, _ in CONSTRAIN.values()} == set(CONSTRAINTS) - made_otherwise


@pytest.mark.parametrize(
    ("line", "pairs"),
    [
        ("horizontal L0 L1 L2", [("L0",), ("L1",), ("L2",)]),
        ("equal L0 L1 L2", [("L0", "L1"), ("L0", "L2")]),
        ("parallel L0 L1 L2", [("L0", "L1"), ("L0", "L2")]),
        ("concentric A0 A1 A2", [("A0", "A1"), ("A0", "A2")]),
        ("fix L0 A0", [("L0",), ("A0",)]),
    ],
)
def test_several_at_once(session: Session, line: str, pairs: list[tuple[str, ...]]) -> None:
    before = len(session.document.constraints)
    session.run(line)
    made = list(session.document.constraints.values())[before:]
    assert [one.args for one in made] == pairs


def test_constraints_with_words(session: Session) -> None:
    session.run("tangent A0 A1 inside force")
    made = last(session, "constraints")
    assert (made.mode, made.forced) == ("inside", True)  # type: ignore[attr-defined]
    assert "[forced]" in said(session, "list tangent")


DIMENSION = {
    "length L0": ("L0",),
    "distance L0.p1 P0": ("L0.p1", "P0"),
    "distance P0 L0": ("P0", "L0"),
    "distance L0 L1": ("L0", "L1"),
    "distance A0 A1": ("A0", "A1"),
    "hdistance P0 L0.p1": ("P0", "L0.p1"),
    "vdistance P0 A0.center": ("P0", "A0.center"),
    "radius A0": ("A0",),
    "diameter A0": ("A0",),
    "radius_b EA0": ("EA0",),
    "sweep A2": ("A2",),
    "arc_length A2": ("A2",),
    "angle L0 L1": ("L0", "L1"),
    "xangle L0": ("L0",),
    "xangle EA0": ("EA0",),
    "total_length L0 L1 A2": ("L0", "L1", "A2"),
    "area L0 L1 L2": ("L0", "L1", "L2"),
}
FORMS = {
    "5": ("5", 5, None, None),
    "2*w + 1": ("2*w + 1", 9, None, None),
    "=2*w": ("8", 8, None, None),
    ">= 2": (None, None, 2, None),
    "<= 10": (None, None, None, 10),
    "2 to 5": (None, None, 2, 5),
    "w to w*2": (None, None, 4, 8),
    ">= =w": (None, None, 4, None),
    '"w * 2"': ("w * 2", 8, None, None),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("line", DIMENSION)
def test_dimension(session: Session, line: str, form: str) -> None:
    (reply,) = session.run(f"{line} {form}")
    made = last(session, "dimensions")
    text, value, low, high = FORMS[form]
    assert (made.kind, made.args) == (line.split()[0], DIMENSION[line])  # type: ignore[attr-defined]
    found = [
        amount.number if amount else None
        for amount in (made.value, made.low, made.high)  # type: ignore[attr-defined]
    ]
    assert found == [value, low, high]
    if text is not None:
        assert made.value.text == text  # type: ignore[attr-defined]
    assert reply.text.startswith("Added d0: ")
    assert not made.derived  # type: ignore[attr-defined]


def test_every_kind_of_dimension_has_a_command() -> None:
    assert {line.split()[0] for line in DIMENSION} == set(DIMENSIONS)


def test_derived_and_driven(session: Session) -> None:
    session.run("length L0 derived; radius A0 driven; length L1 7 derived")
    records = list(session.document.dimensions.values())
    assert [(one.derived, one.value.number) for one in records] == [  # type: ignore[union-attr]
        (True, 5),
        (False, 1),
        (True, 7),
    ]
    assert said(session, "list dims").splitlines()[0] == "d0: length L0 = (5) [derived]"
    session.run("set_driven d0; set_derived d1; set_driven d2 w*2")
    records = list(session.document.dimensions.values())
    assert [one.derived for one in records] == [False, True, False]
    assert records[2].value.text == "w*2"  # type: ignore[union-attr]
    session.run("set_driven d0 2 to 9")
    assert session.document.dimensions["d0"].is_range


@pytest.mark.parametrize("mode", ["supplement", "closest", "acute", "obtuse"])
def test_words_of_angles(session: Session, mode: str) -> None:
    session.run(f"angle L0 L1 40 {mode}")
    assert session.document.dimensions["d0"].mode == mode


def test_a_second_value_updates(session: Session) -> None:
    assert said(session, "length L0 3").startswith("Added d0")
    assert said(session, "length L0 w").startswith("Updated d0: length L0 = 4 (w)")
    assert len(session.document.dimensions) == 1


def test_place_of_text(session: Session) -> None:
    session.run("length L0 3; dim_pos d0 offset 1.5; dim_pos d0 offset @0.5; dim_pos d0 along -0.3")
    made = session.document.dimensions["d0"]
    assert (made.offset, made.along) == (2.0, -0.3)
    assert "text: offset 2, along -0.3" in said(session, "info d0")


def test_freeze(session: Session) -> None:
    session.run("length L0 5")
    session.run("freeze L0 A2")
    assert [d.kind for d in session.document.dimensions.values()] == ["length", "radius", "sweep"]
    session.run("freeze")
    kinds = [d.kind for d in session.document.dimensions.values()]
    assert kinds.count("length") == 4
    assert kinds.count("radius_b") == 2
    assert said(session, "freeze") == "Nothing to freeze"


def test_parameters(session: Session) -> None:
    assert said(session, "param width 10") == "Added width = 10 (10)"
    assert said(session, "param height width * 2") == "Added height = width * 2 (20)"
    assert said(session, "param width 15") == "Updated width = 15 (15)"
    assert said(session, "param half =width/2") == "Added half = 7.5 (7.5)"
    session.run("length L0 height + width")
    assert said(session, "rename_param width b") == "Renamed width to b; changed: height, d0"
    assert session.document.parameters["height"].amount.text == "b * 2"
    assert session.document.dimensions["d0"].value.text == "height + b"  # type: ignore[union-attr]
    assert list(session.document.parameters) == ["w", "b", "height", "half"]
    assert said(session, "info b").splitlines()[-1] == "  read by: height, d0"
    assert said(session, "del_param b") == (
        "Deleted parameter b\n  broken: height, d0 (they keep their last value)"
    )


def test_delete_by_name_lists_what_goes_too(session: Session) -> None:
    session.run("coincident L1.p1 L0.p2; horizontal L0; length L0 4")
    assert said(session, "delete L0") == (
        "Deleted line L0\n  cascade:\n    C0: coincident L1.p1 L0.p2\n    CL0H: horizontal L0\n"
        "    d0: length L0 = 4"
    )
    session.run("undo")
    assert "CL0H" in session.document.constraints
    assert said(session, "delete C0 d0 w") == (
        "Deleted constraint C0\nDeleted dimension d0\nDeleted parameter w"
    )


@pytest.mark.parametrize("line", [one for one in CONSTRAIN if "fix" not in one])
def test_delete_by_what_is_related(session: Session, line: str) -> None:
    before = to_json(session.document).count(b'"kind"')
    session.run(line)
    word, *operands = line.split()
    session.run(f"delete {' '.join(reversed(operands))} {word}")
    assert to_json(session.document).count(b'"kind"') == before


def test_delete_selection(session: Session) -> None:
    session.run("select L0 A0 L1.p1; delete selection")
    assert "L0" not in session.document.entities
    assert "A0" not in session.document.entities
    assert "L1" in session.document.entities


def test_selection_of_what_hangs_together() -> None:
    session = Session(StandIn(), make_editor=StandIn)
    session.run("add_line 0,0 1,0 2,0 3,0; add_line 2,0 2,5; add_circle 9,9 1; equal L3 L0")
    session.run("add_line 20,0 21,0; parallel L4 L0; add_line 0,0 0,-5")
    assert said(session, "select L0 sequence") == "Selected: L5, L0, L1"
    assert said(session, "select L0 chain") == "Selected: L0, L1, L2, L3, L5"
    assert said(session, "select L4 linked") == "Selected: L0, L1, L2, L3, L4, L5"
    assert said(session, "select A0") == "Selected: L0, L1, L2, L3, L4, L5, A0"
    assert said(session, "deselect L0 L1") == "Selected: L2, L3, L4, L5, A0"
    assert said(session, "select all").count("L") == 6
    assert said(session, "list selection").splitlines()[0] == "L0"
    assert said(session, "deselect") == "Nothing is selected"


def test_a_spline_through_points(session: Session) -> None:
    text = "Added S1: (30, 0)-(32, 0), 5 poles through 3 points"
    assert said(session, "add_spline 30,0 31,1 32,0 through") == text
    entity = session.document.entities["S1"]
    assert entity.kind == "bspline"
    assert session.document.numbers_of("S1")[1::2] == pytest.approx([0, 0.5, 1.5, 0.5, 0])
    with pytest.raises(AraelError, match="3 points that it goes through, found 2"):
        session.run("add_spline 30,0 31,1 through")
    with pytest.raises(AraelError, match="exclude each other"):
        session.run("add_spline 1,0 2,1 3,0 4,1 bezier through")


def test_lists(session: Session) -> None:
    session.run("horizontal L0; length L0 4; radius A0 1; add_line 30,0 31,0 constr quiet")
    assert said(session, "list lines").splitlines()[0] == "L0: line (0, 0)-(5, 0), length 5"
    assert said(session, "list constr") == "L4: line (30, 0)-(31, 0), length 1 [constr] [quiet]"
    assert said(session, "list points").count("\n") == 2
    assert said(session, "list arcs").count("\n") == 2
    assert said(session, "list ellipses").count("\n") == 1
    assert said(session, "list splines") == "S0: bezier (20, 0)-(23, 0), 4 poles"
    assert said(session, "list dims") == "d0: length L0 = 4\nd1: radius A0 = 1"
    assert said(session, "list params") == "w = 4 (4)"
    assert said(session, "list horizontal") == "CL0H: horizontal L0"
    assert said(session, "list radius") == "d1: radius A0 = 1"
    assert said(session, "list parallel") == "No parallel"
    everything = said(session, "list").splitlines()
    assert len(everything) == 13 + 1 + 1 + 2 + 1
    assert said(session, "list all").splitlines() == everything


def test_info(session: Session) -> None:
    session.run("horizontal L0; length L0 w; coincident L1.p1 P0; x = 3")
    assert said(session, "info L0").splitlines() == [
        "L0: line (0, 0)-(5, 0), length 5",
        "  angle 0 deg",
        "  CL0H: horizontal L0",
        "  d0: length L0 = 4 (w)",
    ]
    assert said(session, "info L1.p1").splitlines()[1] == "  C0: coincident L1.p1 P0"
    assert said(session, "info C0") == "C0: coincident L1.p1 P0"
    assert said(session, "info P0").splitlines()[0] == "P0: point (3, 9)"
    assert said(session, "info x") == "x: variable = 3"


def test_measure_and_find(session: Session) -> None:
    assert "length: 5" in said(session, "measure L0")
    assert said(session, "measure P0 L0") == "perpendicular distance: 9\ndistance: 9"
    assert said(session, "measure P0 P1") == "distance: 1\ndx: 1\ndy: 0"
    assert "perpendicular: yes" in said(session, "measure L0 L2")
    assert "gap: 5" in said(session, "measure L0 A0")
    assert "concentric: no" in said(session, "measure A0 A1")
    session.run("a = add_circle 50,50 5 noconnect; b = add_circle 58,50 4 noconnect")
    assert "overlap: 1" in said(session, "measure a b")
    assert said(session, "find 5,0 0.5").splitlines() == ["L0: distance 0", "L0.p2: distance 0"]
    assert said(session, "find 100,100 1") == "Nothing within 1 of (100, 100)"


def test_history(session: Session) -> None:
    session.run("clear\nadd_line 0,0 1,0\nadd_line 1,0 2,0\nadd_line 2,0 3,0")
    steps = session.document.history.position
    assert said(session, "undo 2").splitlines() == [
        "Undid: add_line 2,0 3,0",
        "Undid: add_line 1,0 2,0",
    ]
    assert said(session, "redo") == "Redid: add_line 1,0 2,0"
    assert said(session, "history 1").splitlines()[-1] == f"> {steps - 1}: add_line 1,0 2,0"
    assert said(session, "goto 0") == f"At step 0 of {steps}"
    assert not session.document.entities
    session.run(f"goto {steps}")
    assert len(session.document.entities) == 3


def test_a_dry_run_changes_nothing(session: Session) -> None:
    before, state = to_json(session.document), session.state.copy()
    assert said(session, "explain length L0 9") == (
        "'length L0 9': accepts -- Added d0: length L0 = 9"
    )
    assert said(session, "explain length L9 9").startswith("'length L9 9': rejects -- no entity")
    assert to_json(session.document) == before
    assert session.state == state


def test_switches(session: Session) -> None:
    assert said(session, "timing on; timing") == "Timing is on\nTiming is on"
    assert "structural_dof off" in said(session, "settings structural_dof off")
    assert said(session, "settings unit cm").splitlines()[-1] == "unit cm"


def test_leaving(session: Session) -> None:
    assert session.run("exit")[0].leaves
    assert session.run("quit")[0].leaves


def test_every_command_has_its_help(session: Session) -> None:
    full = said(session, "help full")
    short = said(session, "help")
    for name, command in table.commands().items():
        assert f"### {name}\n" in full
        assert f"  {name} " in short
        assert command.summary.endswith(".")
        page = said(session, f"help {name}")
        assert all(line in page for line in command.usage)
        for line in command.usage:
            words = (name, *command.aliases)
            assert line.split()[0] in words, line
        for alias in command.aliases:
            assert said(session, f"help {alias}") == page


@pytest.mark.parametrize(
    "topic", ["language", "names", "coordinates", "expressions", "functions", "variables", "create"]
)
def test_topics_of_help(session: Session, topic: str) -> None:
    assert len(said(session, f"help {topic}")) > 200
