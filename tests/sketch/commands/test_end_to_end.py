"""Scripts on the real editor: solved, judged, undone."""

from __future__ import annotations

import json
import random
from pathlib import Path

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch import Sketch
from arael.sketch.commands import table
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json
from arael.sketch.expressions.properties import property_of
from tests.cli.conftest import Arael, arael  # noqa: F401 - a fixture

PLATE = """\
# a rectangle with a hole, every dimension of which follows two parameters
param w 10
param h w/2
bottom, right, top, left = add_rect 0.1,-0.2 9,4 hv
hole = add_circle 5,2 1
length bottom w; length right h
radius hole h/4
distance hole.center bottom h/2
distance hole.center left w/2
lock bottom.p1 0,0
"""


@pytest.fixture
def session() -> Session:
    return Session()


def said(session: Session, text: str) -> str:
    return "\n".join(reply.text for reply in session.run(text))


def value(session: Session, path: str) -> float:
    name, _, rest = path.partition(".")
    document = session.document
    found = property_of(document, document.entity(session.resolve(name)), rest)
    assert found is not None
    return found


def test_a_rectangle_with_a_hole(session: Session) -> None:
    session.run(PLATE)
    assert said(session, "dof") == "0 degrees of freedom"
    for path, expected in {
        "bottom.length": 10,
        "right.length": 5,
        "hole.radius": 1.25,
        "hole.center.x": 5,
        "hole.center.y": 2.5,
        "top.p1.x": 10,
    }.items():
        assert value(session, path) == pytest.approx(expected, abs=1e-9), path


def test_parameters_move_the_drawing_and_undo_is_exact(session: Session) -> None:
    session.run(PLATE)
    before = to_json(session.document)
    session.run("param w 14")
    assert value(session, "hole.center.x") == pytest.approx(7)
    assert value(session, "hole.radius") == pytest.approx(1.75)
    session.run("undo")
    assert to_json(session.document) == before


def test_a_line_that_contradicts_changes_nothing(session: Session) -> None:
    session.run(PLATE)
    before, state = to_json(session.document), session.state.copy()
    with pytest.raises(AraelError) as caught:
        session.run("param w 12; perpendicular bottom top")
    assert caught.value.diagnostics[0].code in ("E1230", "E1231", "E1232")
    assert to_json(session.document) == before
    assert session.state == state


def test_a_dry_run_tells_and_leaves_no_trace(session: Session) -> None:
    session.run(PLATE)
    before = to_json(session.document)
    assert said(session, "explain param w 12").startswith("'param w 12': accepts -- Updated w")
    rejected = said(session, "explain parallel bottom top")
    assert rejected.startswith("'parallel bottom top': rejects -- ")
    assert "CL0H" in rejected
    assert to_json(session.document) == before


def test_what_is_free_and_what_holds(session: Session) -> None:
    session.run("a = add_line 0,0 5,0; horizontal a; length a 5")
    assert said(session, "dof") == "2 degrees of freedom"
    free = said(session, "free")
    assert "L0 can move along x" in free
    assert said(session, "dof analyze") == free
    assert said(session, "why L0").splitlines()[0] == "L0 is held by:"
    (reply,) = session.run("sensitivity d0")
    assert sum(reply.data["moved"].values()) == pytest.approx(1, abs=0.51)
    (reply,) = session.run("what_if lock L0.p1")
    assert (reply.data["before"], reply.data["after"]) == (2, 0)
    (reply,) = session.run("what_if length L0 9")
    assert reply.data["moved"]["L0"] == pytest.approx(4, abs=2.1)
    assert session.run("cost")[0].data["largest"] < 1e-9


@pytest.mark.parametrize("what", ["eigenvalues", "singular", "jacobian"])
def test_tables_of_the_jacobian(session: Session, what: str) -> None:
    session.run("a = add_line 0,0 5,0; horizontal a; length a 5")
    (reply,) = session.run(f"dof {what}")
    data = reply.data
    if what == "jacobian":
        assert data == {"rows": 2, "columns": 4}
        assert "CL0H" in reply.text
        return
    values = np.array(data[what])
    assert np.count_nonzero(np.abs(values) < 1e-9) == 2
    assert values.max() == pytest.approx(2 if what == "eigenvalues" else np.sqrt(2))


def test_live_values_follow_geometry(session: Session) -> None:
    session.run("a = add_line 0,0 5,0; b = add_line 0,3 4,4; length a 5; length b a.length*2")
    session.run("param k b.length/5; c = add_line 0,9 3,9; length c k + 1; length a 7")
    found = [value(session, f"{name}.length") for name in "abc"]
    assert found == pytest.approx([7, 14, 3.8], rel=1e-9)
    session.run("undo")
    assert value(session, "b.length") == pytest.approx(10)


def test_what_is_deleted_breaks_what_reads_it(session: Session) -> None:
    session.run("a = add_line 0,0 5,0; b = add_line 0,3 4,4; length a 5; length b a.length*2")
    assert said(session, "delete a").splitlines()[-1] == "  broken: d1 (they keep their last value)"
    assert value(session, "b.length") == pytest.approx(10)
    session.run("undo")
    assert session.document.dimensions["d1"].broken == ""


def test_a_value_that_chases_itself_is_refused(session: Session) -> None:
    session.run("a = add_line 0,0 5,0")
    before = to_json(session.document)
    with pytest.raises(AraelError) as caught:
        session.run("length a a.length + 1")
    assert caught.value.diagnostics[0].code in ("E1231", "E1234")
    assert to_json(session.document) == before


def test_a_distance_of_lines_keeps_them_parallel_and_leaves_nothing_behind(
    session: Session,
) -> None:
    session.run("a = add_line 0,0 5,0; b = add_line 0,3 5,4")
    assert said(session, "distance a b 4").splitlines() == [
        "Added d0: distance L0 L1 = 4",
        "notice: L0 and L1 stay parallel as long as d0 is there",
    ]
    assert not session.document.constraints
    assert said(session, "dof") == "6 degrees of freedom"
    session.run("delete d0")
    assert said(session, "dof") == "8 degrees of freedom"


def test_a_saved_sketch_goes_on(tmp_path: Path) -> None:
    session = Session(folder=tmp_path)
    session.run(PLATE)
    session.run("save plate.json\nload plate.json")
    session.run("param w 20")
    assert value(session, "L0.length") == pytest.approx(20)


def test_clear_and_undo(session: Session) -> None:
    session.run(PLATE)
    before = to_json(session.document)
    session.run("clear")
    assert said(session, "dof") == "0 degrees of freedom"
    session.run("undo")
    assert to_json(session.document) == before
    session.run("param w 12")
    assert value(session, "L0.length") == pytest.approx(12)


def test_in_python() -> None:
    sketch = Sketch()
    sketch.param("w", 10)
    bottom, right, *_ = sketch.add_rect((0, 0), (9, 4), hv=True)
    width = sketch.length(bottom, "w")
    sketch.length(right, 5)
    assert bottom.length == pytest.approx(10)
    width.value = 12
    assert bottom.length == pytest.approx(12)
    assert sketch.dof()["freedoms"] == 2
    assert sketch.what_if("length", right, 6)["accepted"]
    assert sketch._repr_svg_().startswith("<svg")


def test_on_the_command_line(
    arael: Arael,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.cmd").write_text(PLATE + "dof\n")
    done = arael("sketch", "plate.cmd", "--json", "--export", "plate.svg", "--export", "p.json")
    assert done.code == 0, done.err
    last = json.loads(done.out.splitlines()[-1])
    assert last["data"][0]["freedoms"] == 0
    assert "<svg" in (tmp_path / "plate.svg").read_text()
    assert len(Sketch("p.json")) == 5


@pytest.mark.parametrize("end", ["-5,5", "5,5", "-5,-5", "5,-5"])
@pytest.mark.parametrize("mode", ["", "supplement", "closest", "acute", "obtuse"])
def test_angles_keep_their_side(session: Session, end: str, mode: str) -> None:
    session.run(f"add_line 5,0 0,0; add_line 0,0 {end}")
    (before,) = session.run("print angle(L0,L1)")[0].data["values"]
    session.run(f"angle L0 L1 50 {mode}")
    (after,) = session.run("print angle(L0,L1)")[0].data["values"]
    assert np.sign(after) == np.sign(before)
    supplement = session.document.dimensions["d0"].mode == "supplement"
    assert abs(after) == pytest.approx(130 if supplement else 50, abs=1e-6)


def test_a_hexagon_by_angles(session: Session) -> None:
    corners = "5,0 2.5,4.33 -2.5,4.33 -5,0 -2.5,-4.33 2.5,-4.33 5,0"
    session.run(f"a, b, c, d, e, f = add_line {corners}")
    session.run("equal a b c d e f\nia = angle a b 120 closest")
    session.run("angle b c ia closest; angle c d ia closest; length a 5")
    session.run("lock a.p1 5,0; horizontal b")
    assert said(session, "dof") == "0 degrees of freedom"
    assert [value(session, f"{name}.length") for name in "abcdef"] == pytest.approx([5] * 6)
    assert value(session, "d.p1.x") == pytest.approx(-5)


def test_random_lines_are_refused_or_done(session: Session) -> None:
    choose = random.Random(11).choice
    left_out = {"save", "load", "export", "import", "total_length", "area"}
    commands = [name for name in table.commands() if name not in left_out]
    names = [
        "L0",
        "L1",
        "L2",
        "A0",
        "A1",
        "EA0",
        "P0",
        "P1",
        "L0.p1",
        "L1.p2",
        "A0.center",
        "A1.start",
        "d0",
        "C0",
        "w",
    ]
    values = [
        "0,0",
        "5,3",
        "@1,2",
        "cursor",
        "5",
        "30",
        "deg",
        "12",
        "mm",
        "w*2",
        "L0.length",
        "=w",
        ">=",
        "to",
    ]
    words = [
        "force",
        "driven",
        "derived",
        "noconnect",
        "hv",
        "closest",
        "all",
        "selection",
        "chain",
    ]
    session.run("add_line 0,0 5,0 5,5; add_circle 2,2 1; add_arc 8,0 8,2 9,1; param w 3")
    session.run("add_ellipse 15,0 3 1 20; add_point 9,9; add_point 1,7; length L0 5")
    for _ in range(400):
        count = choose(range(5))
        line = " ".join(
            [choose(commands), *(choose(choose([names, values, words])) for _ in range(count))]
        )
        before = to_json(session.document)
        try:
            session.run(line)
        except AraelError:
            assert to_json(session.document) == before, line
