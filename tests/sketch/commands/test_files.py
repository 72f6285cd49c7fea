"""Files of commands stay below the folder; what is read and written. Also E1270."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension, Group, Parameter
from arael.sketch.document.saved import to_json
from tests.sketch.stand_in import StandIn


@pytest.fixture
def session(tmp_path: Path) -> Session:
    folder = tmp_path / "folder"
    folder.mkdir()
    return Session(StandIn(), folder=folder, make_editor=StandIn)


def code(session: Session, text: str) -> str:
    with pytest.raises(AraelError) as caught:
        session.run(text)
    return caught.value.diagnostics[0].code


def test_a_sketch_is_saved_and_loaded(session: Session) -> None:
    session.run("add_rect 0,0 5,3 hv; param w 5; length L0 w")
    session.run("save drawing.json")
    before = to_json(session.document)
    session.run("clear")
    assert not session.document.entities
    (reply,) = session.run("load drawing.json")
    assert reply.text == "Loaded drawing.json: 4 entities"
    assert to_json(session.document) == before
    assert session.document.history.position == 0


def test_clear_begins_names_anew_and_can_be_undone(session: Session) -> None:
    session.run("add_line 0,0 5,0; a = _")
    before = to_json(session.document)
    session.run("clear\nadd_line 1,1 2,2")
    assert list(session.document.entities) == ["L0"]
    session.run("undo 2")
    assert to_json(session.document) == before


def test_subfolders_are_allowed(session: Session) -> None:
    (session.folder / "parts").mkdir()
    session.run("add_line 0,0 5,0\nsave parts/a.json")
    assert (session.folder / "parts" / "a.json").exists()


@pytest.mark.parametrize("name", ["../x.json", "/tmp/x.json", "~/x.json", "a/../../x.json"])
def test_files_elsewhere_are_refused(session: Session, name: str) -> None:
    assert code(session, f"save {name}") == "E1264"
    assert code(session, f"load {name}") == "E1264"


def test_links_that_lead_out_are_refused(session: Session, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    (session.folder / "link").symlink_to(outside)
    (session.folder / "one.json").symlink_to(outside / "one.json")
    assert code(session, "save link/x.json") == "E1264"
    assert code(session, "save one.json") == "E1264"
    assert not list(outside.iterdir())


def test_what_is_no_sketch_is_refused(session: Session) -> None:
    (session.folder / "x.json").write_text("{}")
    (session.folder / "d.json").mkdir()
    assert code(session, "load x.json") == "E1210"
    assert code(session, "load d.json") == "E1265"


def test_other_formats_without_their_library(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "arael.sketch.exchange", None)
    assert code(session, "export a.dxf") == "E1270"
    assert code(session, "import a.dxf") == "E1270"


def other() -> Document:
    """A sketch with one of everything, whose names are taken in the other one."""
    document = Document()
    with document.transaction("make"):
        document.add_entity("line", (0, 0, 5, 0), construction=True)
        document.add_entity("line", (5, 0, 5, 5))
        document.put("parameters", Parameter("w", Amount("5", 5.0)))
        document.put("constraints", Constraint("CL0H", "horizontal", ("L0",)))
        document.put(
            "constraints",
            Constraint(document.next_name("C"), "coincident", ("L0.p2", "L1.p1")),
        )
        document.put(
            "dimensions",
            Dimension(document.next_name("d"), "length", ("L1",), Amount("w + L0.length", 10.0)),
        )
        document.put("groups", Group("M0", "offset", ("L0",), ("L1",), ("d0",)))
    return document


def test_import_adds_everything_under_free_names(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    exchange = ModuleType("arael.sketch.exchange")
    suggestion = SimpleNamespace(kind="perpendicular", args=("L0", "L1"))
    exchange.read = lambda path: SimpleNamespace(  # type: ignore[attr-defined]
        document=other(), suggestions=[suggestion]
    )
    monkeypatch.setitem(sys.modules, "arael.sketch.exchange", exchange)
    (session.folder / "a.dxf").write_text("")
    session.run("add_line 9,9 8,8; horizontal L0; param w 3; length L0 w")
    steps = session.document.history.position
    (reply,) = session.run("import a.dxf")
    document = session.document
    assert reply.names == ("L1", "L2")
    assert "perpendicular L1 L2" in reply.text
    assert document.entities["L1"].construction
    assert document.constraints["CL1H"].args == ("L1",)
    assert document.parameters["w_"].amount.number == 5
    made = list(document.dimensions.values())[-1]
    assert (made.args, made.value) == (("L2",), Amount("w_ + L1.length", 10.0))
    group = list(document.groups.values())[-1]
    assert (group.sources, group.results, group.owned) == (("L1",), ("L2",), (made.name,))
    assert document.history.position == steps + 1


def test_pipes_are_refused_at_once(session: Session) -> None:
    for name in ("pipe.json", "pipe.svg"):
        os.mkfifo(session.folder / name)
    for line in ("save pipe.json", "load pipe.json", "import pipe.svg", "export pipe.svg"):
        assert code(session, line) == "E1265"


def test_links_that_lead_in_a_circle_are_refused(session: Session) -> None:
    (session.folder / "a.json").symlink_to("b.json")
    (session.folder / "b.json").symlink_to("a.json")
    for line in ("save a.json", "load a.json"):
        assert code(session, line) in ("E1264", "E1265")


def test_a_link_to_a_device_and_a_folder_that_leads_out_are_refused(session: Session) -> None:
    (session.folder / "zero.json").symlink_to("/dev/zero")
    (session.folder / "up").symlink_to("..")
    (session.folder / "up" / "secret.json").write_text("{}")
    for line in ("load zero.json", "save zero.json", "load up/secret.json", "save up/new.json"):
        assert code(session, line) == "E1264"
    assert not (session.folder / "up" / "new.json").exists()


def test_a_file_that_is_too_large_is_not_read(session: Session) -> None:
    with open(session.folder / "large.json", "wb") as file:
        file.truncate(10**11)
    assert code(session, "load large.json") == "E1210"
