"""The shared sketch: commands, steps, drags, questions, several windows."""

from __future__ import annotations

import base64
import math
from pathlib import Path

import pytest

from arael.sketch.document.saved import to_json
from arael.sketch.server import shared as shared_module
from arael.sketch.server.shared import SharedSketch
from tests import optional
from tests.sketch.server.shared import Local, contradictory, shared_sketch

RECTANGLE = "add_rect 0,0 50,30 hv"


@pytest.fixture
def shared() -> SharedSketch:
    return shared_sketch()


@pytest.fixture
def page(shared: SharedSketch) -> Local:
    return Local(shared)


# --- windows ------------------------------------------------------------------------------------


def test_a_window_is_greeted_and_gets_the_document(page: Local) -> None:
    kinds = [message["type"] for message in page.messages]
    assert kinds[:2] == ["hello", "snapshot"]
    assert {"history", "presence"} <= set(kinds)
    assert page.hello["unit"] == "mm" and page.last("permissions")["agents"] == []


def test_what_one_window_changes_the_other_shows(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    reply = page.run(RECTANGLE)
    assert reply["ok"] and reply["names"] == ["L0", "L1", "L2", "L3"]
    assert {"L0", "C0", "CL0H"} <= set(reply["created"])
    change = other.last("change")
    assert (change["by"], change["title"]) == ("w1", RECTANGLE)
    assert page.is_in_step() and other.is_in_step()
    assert not any(message["type"] == "reply" for message in other.messages)
    assert other.last("history")["done"] == [RECTANGLE]


def test_each_edit_keeps_the_mirror_in_step(page: Local) -> None:
    lines = [
        RECTANGLE,
        "length L0 60",
        "add_circle 20,15 5",
        "param w 3",
        "radius A0 w",
        "fillet L0 L1 4",
        "delete L2",
        "undo",
        "undo 2",
        "redo",
        "add_spline 0,40 10,50 20,30 40,40",
        "add_line 30,-5 30,5",
        "split L0 by _",
        "settings unit cm",
        "rename_param w width",
        "rename A0 bore1",
        "clear",
        "undo",
        "constr L1",
        "goto 2",
    ]
    for line in lines:
        reply = page.run(line)
        assert reply["ok"], (line, reply["text"])
        assert page.is_in_step(), line


def test_variables_and_selection_are_of_one_window(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run("side = add_line 0,0 50,0")
    page.ask("view", selection=["L0"], cursor=[3, 4])
    assert page.run("print side.length")["ok"]
    assert not other.run("print side.length")["ok"]
    assert not other.run("delete selection")["ok"]
    assert page.run("print cursor.x")["text"].endswith("3")
    assert page.run("delete selection")["ok"] and "L0" not in page.tables["entities"]


def test_a_command_that_selects_is_followed_by_its_window(page: Local) -> None:
    page.run(RECTANGLE)
    page.run("select L0")
    assert page.last("view")["selection"] == ["L0"]
    page.run("zoom 2")
    assert page.last("view")["zoom"] == 2.0


def test_a_window_that_comes_back_gets_what_it_missed(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    page.run("side = add_line 0,40 9,40")
    kept = (page.tables, list(page.values), page.revision)
    shared.close(page.window)
    other = Local(shared, "w2")
    other.run("length L0 70")
    other.run("delete L4")
    again = Local.__new__(Local)
    again.__dict__.update(page.__dict__, messages=[])
    again.tables, again.values, again.revision = kept
    again.window = shared.open("w1", again, kept[2])
    assert not any(message["type"] == "snapshot" for message in again.messages)
    assert again.is_in_step()
    assert "side" in again.window.state.variables


@pytest.mark.parametrize("since", [0, 3, 2**31])
def test_an_unknown_revision_gets_a_snapshot(shared: SharedSketch, page: Local, since: int) -> None:
    page.run(RECTANGLE)
    assert Local(shared, "w2", since).is_in_step()


def test_kept_changes_are_bounded(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_module, "MAX_KEPT", 2)
    first = page.revision
    for k in range(4):
        page.run(f"add_point {k},0")
    assert len(shared._kept) == 2
    late = Local(shared, "w2", first)
    assert any(message["type"] == "snapshot" for message in late.messages) and late.is_in_step()


def test_a_page_can_ask_for_everything(page: Local) -> None:
    page.run(RECTANGLE)
    page.tables, page.values = {}, []
    page.ask("refresh")
    assert page.is_in_step()


def test_too_many_windows_are_refused(
    shared: SharedSketch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shared_module, "MAX_WINDOWS", 1)
    Local(shared)
    Local(shared)  # the same window once more takes its place
    with pytest.raises(shared_module.AraelError, match="E1403"):
        Local(shared, "w2")


# --- commands -----------------------------------------------------------------------------------


def test_a_refusal_has_its_place_and_names_the_culprits(page: Local) -> None:
    page.run(RECTANGLE)
    page.run("length L0 50")
    reply = page.run("length L2 40")
    assert not reply["ok"]
    error = reply["error"]
    assert error["code"] == "E1231"
    assert "d0" in error["names"] and error["hint"].startswith("`delete")
    reply = page.run("add_line 0,0 5,0; length L99 3")
    assert (reply["error"]["from"], reply["error"]["to"]) == (25, 28)
    assert "L4" not in page.tables["entities"]


def test_a_step_is_taken_back_as_a_whole(page: Local) -> None:
    page.run("add_line 0,0 50,0\nadd_line 0,9 50,9", step="two lines")
    assert page.history["done"] == ["two lines"]
    page.run("undo")
    assert not page.tables["entities"] and page.is_in_step()


def test_a_step_with_a_line_that_fails_changes_nothing(page: Local) -> None:
    assert not page.run("add_line 0,0 50,0\nlength L7 9", step="two")["ok"]
    assert not page.tables["entities"] and page.history["done"] == []


def test_lines_before_one_that_fails_stay(page: Local) -> None:
    assert not page.run("add_line 0,0 50,0\nlength L7 9")["ok"]
    assert list(page.tables["entities"]) == ["L0"] and page.is_in_step()


def test_automatic_constraints_are_tried_and_left_out(page: Local) -> None:
    reply = page.run(
        "add_line 0,0 50,1", extras=["horizontal _", "vertical _", "length _ 50"], step="line"
    )
    assert reply["ok"] and {"CL0H", "d0"} <= set(reply["created"])
    assert len(reply["notes"]) == 1 and reply["notes"][0].startswith("left out: vertical _: ")
    assert page.history["done"] == ["line"]
    page.run("undo")
    assert not page.tables["constraints"]


@pytest.mark.parametrize("word", ["undo", "load other.json", "goto 0"])
def test_history_is_not_a_part_of_a_step(page: Local, word: str) -> None:
    page.run("add_point 1,1")
    assert page.run(f"add_point 2,2\n{word}", step="x")["error"]["code"] == "E1404"
    assert list(page.tables["entities"]) == ["P0"]


def test_a_text_for_people_is_sent_to_every_window(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run("msg hello")
    assert other.last("message") == {"type": "message", "level": "info", "text": "hello"}


def test_a_sketch_is_loaded_as_one_step(tmp_path: Path) -> None:
    shared = shared_sketch(tmp_path / "a.json")
    page = Local(shared)
    page.run(RECTANGLE)
    page.run("length L0 44")
    page.run("save b.json")
    page.run("clear")
    page.run("add_circle 0,0 9")
    before = to_json(shared.session.document)
    assert page.run("load b.json")["ok"] and page.is_in_step()
    assert to_json(shared.session.document) == (tmp_path / "b.json").read_bytes()
    assert page.run("length L0 45")["ok"]
    page.run("undo 2")
    assert to_json(shared.session.document) == before
    shared.finish()


def test_a_mistake_of_arael_is_a_message(
    page: Local, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(self: object, line: object) -> None:
        raise ZeroDivisionError("oops")

    monkeypatch.setattr("arael.sketch.commands.session.Session.run_line", broken)
    reply = page.run("add_point 1,1")
    assert reply["error"]["code"] == "E1409" and "oops" in reply["text"]
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_a_reply_that_is_not_json_is_a_message(
    page: Local, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(SharedSketch, "run", lambda *_: {"ok": True, "data": object()})
    assert page.run("add_point 1,1")["error"]["code"] == "E1409"
    assert "NotImplementedError" in capsys.readouterr().err


@pytest.mark.parametrize(
    "message",
    [
        {"type": "dance"},
        {"type": "run"},
        {"type": "run", "text": 3},
        {"type": "run", "text": "x", "extras": "y"},
        {"type": "run", "text": "x", "extras": [3]},
        {"type": "ask", "what": "everything"},
        {"type": "drag", "handles": ["L0"], "at": [1]},
        {"type": "drag", "handles": ["L0"], "at": ["a", "b"]},
        {"type": "drag", "handles": {}, "at": None},
        {"type": "file", "do": "format"},
        {"type": "file", "do": "import", "format": "exe"},
        {"type": "file", "do": "import", "format": "dxf", "data": "%%"},
        {"type": "file", "do": "import", "format": "dxf", "data": 7},
    ],
)
def test_a_message_without_what_it_needs_is_refused(
    page: Local, message: dict[str, object]
) -> None:
    kind = str(message.pop("type"))
    assert page.ask(kind, **message)["error"]["code"] == "E1401"


# --- drags --------------------------------------------------------------------------------------


def test_a_drag_is_one_step(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run(RECTANGLE)
    revision = page.revision
    assert page.ask("drag", handles=["L2.p1"], at=[50, 30])["ok"]
    for k in range(1, 6):
        page.drag_to(k, 50 + k, 30 + 2 * k)
        assert page.numbers("L2")[:2] == pytest.approx([50 + k, 30 + 2 * k], abs=1e-9)
        assert page.is_in_step() and other.is_in_step()
    assert page.revision == revision and page.frames[-1] == 5
    assert page.ask("drop")["ok"]
    assert page.history["done"] == [RECTANGLE, "drag L2.p1"]
    assert page.is_in_step() and other.is_in_step() and page.revision == revision + 1
    page.run("undo")
    assert page.numbers("L2")[:2] == [50.0, 30.0]


ARM = """
add_line 0,0 10,0
add_line L0.p2 20,0
add_line L1.p2 30,0
length L0 10
length L1 10
length L2 10
fix L0.p1
"""


def _grip(page: Local) -> tuple[float, float]:
    """The end of the arm, as the page shows it."""
    at = page.tables["entities"]["L2"]["at"]
    return page.values[at + 2], page.values[at + 3]


def test_a_frame_whose_time_is_over_is_gone_on_with_while_the_pointer_rests(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("arael.sketch.server.dragging.OpenDrag.to.__defaults__", (0.0,))
    monkeypatch.setattr("arael.sketch.server.shared.RESTS_AFTER", 0.0)
    page.run(ARM)
    page.ask("drag", handles=["L2.p2"], at=[30, 0])
    page.drag_to(1, 5, 15)
    first = math.dist(_grip(page), (5, 15))
    assert first > 1e-3
    frames = 0
    while shared.idle() is not None:
        frames += 1
        assert frames < 200
    assert frames > 0
    assert math.dist(_grip(page), (5, 15)) < 1e-4


def test_a_frame_whose_time_is_over_is_finished_when_the_pointer_lets_go(
    shared: SharedSketch, page: Local, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("arael.sketch.server.dragging.OpenDrag.to.__defaults__", (0.0,))
    page.run(ARM)
    page.ask("drag", handles=["L2.p2"], at=[30, 0])
    page.drag_to(1, 5, 15)
    assert shared.idle() > 0.0  # type: ignore[operator]  # until the pointer rests
    page.ask("drop")
    assert math.dist(_grip(page), (5, 15)) < 1e-4
    assert page.history["done"][-1] == "drag L2.p2" and page.is_in_step()


def test_a_cancelled_drag_leaves_nothing(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run(RECTANGLE)
    before, revision = to_json(shared.session.document), page.revision
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    page.drag_to(1, 70, 80)
    page.ask("drop", cancel=True)
    assert to_json(shared.session.document) == before and page.revision == revision
    assert page.is_in_step() and other.is_in_step() and len(page.history["done"]) == 1


def test_a_curve_moves_as_a_whole(page: Local) -> None:
    page.run("add_line 0,0 50,10")
    page.ask("drag", handles=["L0"], at=[25, 5])
    page.drag_to(1, 26, 8)
    page.ask("drop")
    assert page.numbers("L0") == pytest.approx([1, 3, 51, 13])


@pytest.mark.parametrize("make", ["add_circle 0,0 5", "add_arc 5,0 -5,0 0,5"])
def test_a_radius_follows_the_pointer(page: Local, make: str) -> None:
    page.run(make)
    page.run("lock A0.center 0,0")
    page.ask("drag", handles=["A0.radius"], at=[5, 0])
    page.drag_to(1, 0, 8)
    page.ask("drop")
    assert page.numbers("A0")[-1] == pytest.approx(8)
    assert page.is_in_step() and page.history["done"][-1] == "drag A0.radius"


def test_what_is_defined_does_not_move(page: Local) -> None:
    page.run("add_line 0,0 50,0\nlock L0.p1 0,0\nlock L0.p2 50,0")
    page.ask("drag", handles=["L0.p2"], at=[50, 0])
    page.drag_to(1, 60, 60)
    page.ask("drop")
    assert page.numbers("L0") == [0, 0, 50, 0] and page.frames[-1] == 1


@pytest.mark.parametrize(
    ("handles", "code"),
    [([], "E1402"), (["L9"], "E1201"), (["L0.p7"], "E1202"), (["L0.radius"], "E1402")],
)
def test_what_cannot_be_dragged_is_refused(page: Local, handles: list[str], code: str) -> None:
    page.run("add_line 0,0 50,0")
    assert page.ask("drag", handles=handles, at=[0, 0])["error"]["code"] == code
    page.drag_to(1, 3, 3)  # answered, so that the page goes on
    assert page.frames == [1]


def test_an_edit_of_another_window_ends_a_drag(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run(RECTANGLE)
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    page.drag_to(1, 55, 35)
    assert other.run("add_point 5,5")["ok"]
    page.drag_to(2, 99, 99)
    assert page.frames[-1] == 2
    assert page.history["done"] == [RECTANGLE, "drag L2.p1", "add_point 5,5"]
    assert page.numbers("L2")[:2] == pytest.approx([55, 35])
    assert page.is_in_step() and other.is_in_step()


def test_a_window_that_closes_takes_its_drag_back(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run(RECTANGLE)
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    page.drag_to(1, 55, 35)
    shared.close(page.window)
    assert other.is_in_step() and other.numbers("L2")[:2] == [50.0, 30.0]
    assert len(other.history["done"]) == 1


def test_frames_are_left_out_for_a_window_that_is_behind(shared: SharedSketch, page: Local) -> None:
    other = Local(shared, "w2")
    page.run(RECTANGLE)
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    other.is_behind = True
    for k in range(1, 9):
        page.drag_to(k, 50 + k, 30)
    assert other.frames == [] and page.frames == list(range(1, 9))
    other.is_behind = False
    page.drag_to(9, 50.0, 33.0)
    assert other.is_in_step()


def test_dragging_out_and_back_is_no_change(page: Local) -> None:
    page.run("add_line 0,0 50,0")
    revision = page.revision
    page.ask("drag", handles=["L0.p2"], at=[50, 0])
    page.drag_to(1, 60, 5)
    page.drag_to(2, 50, 0)
    page.ask("drop")
    assert page.numbers("L0") == pytest.approx([0, 0, 50, 0], abs=1e-9) and page.is_in_step()
    assert page.revision - revision in (0, 1)


# --- verdicts and questions -----------------------------------------------------------------------


def test_verdicts_come_when_nothing_else_is_to_do(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    assert not page.verdict
    assert shared.idle() == 0.0
    assert page.verdict["freedoms"] == 4 and page.verdict["revision"] == page.revision
    assert set(page.verdict["entities"].values()) == {"free"}
    assert shared.idle() is None
    page.run("lock L0.p1 0,0\nlength L0 50\nlength L1 30\nlength L2 50 force")
    shared.idle()
    assert page.verdict["freedoms"] == 0
    assert page.verdict["constraints"] == {"d2": "redundant"}
    assert page.verdict["entities"]["L3"] == "defined"
    assert page.verdict["entities"]["L2"] == "redundant"


def test_constraints_that_contradict_are_impossible_and_so_is_what_they_act_on(
    tmp_path: Path,
) -> None:
    page = Local(shared_sketch(contradictory(tmp_path / "plate.json")))
    page.shared.idle()
    assert page.verdict["constraints"] == {"d0": "impossible", "d1": "impossible"}
    entities = page.verdict["entities"]
    assert (entities["L0"], entities["L1"]) == ("impossible", "free")
    conflicts = page.ask("ask", what="conflicts")["data"]["conflicts"]
    assert [one["members"] for one in conflicts] == [["d1"], ["d0"]]
    assert conflicts[1]["sentence"].endswith("is impossible together with d0")
    page.run("delete d1")
    page.shared.idle()
    assert page.verdict["constraints"] == {} and page.verdict["entities"]["L0"] == "free"


def test_what_is_redundant_in_this_position_only_is_sent_as_such(
    shared: SharedSketch, page: Local
) -> None:
    page.run("add_line 0,0 5,0; add_line 5,0 10,0; length L0 5; length L1 5")
    page.run("hdistance L0.p1 L1.p2 10")
    shared.idle()
    assert page.verdict["constraints"] == {"d2": "here"}
    assert set(page.verdict["entities"].values()) == {"free"}
    sentence = page.ask("ask", what="conflicts")["data"]["conflicts"][0]["sentence"]
    assert sentence.endswith("follows from d0, d1 in this position")


def test_defined_points_of_entities_that_are_free_are_sent(
    shared: SharedSketch, page: Local
) -> None:
    page.run("add_line 0,0 5,3; lock L0.p1; add_circle 9,9 2; lock A0.center; add_point 3,3")
    page.run("add_line 0,9 5,9")
    shared.idle()
    assert page.verdict["points"] == {"L0.p1": "defined", "A0.center": "defined"}
    page.run("length L0 9; xangle L0 0")
    shared.idle()
    assert page.verdict["entities"]["L0"] == "defined"
    assert page.verdict["points"] == {"A0.center": "defined"}


def test_counters_of_names_come_with_changes(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    page.run("length L0 50; length L1 30; delete d1")
    assert page.last("change")["settings"] == {"counter:d": 2}
    page.run("undo")
    assert page.last("change")["settings"] == {"counter:d": None}


def test_a_window_that_opens_gets_the_verdict(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    shared.idle()
    other = Local(shared, "w2")
    shared.idle()
    assert other.verdict["freedoms"] == 4


def test_no_verdict_during_a_drag(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    assert shared.idle() is None and not page.verdict


def test_questions_are_answered(page: Local) -> None:
    page.run(f"{RECTANGLE}\nparam w 7\nlength L0 50\nlength L2 50 force")
    revision = page.revision
    free = page.ask("ask", what="free")["data"]
    assert free["freedoms"] == 3 and "L0" in free["motions"][0]["entities"]
    (conflict,) = page.ask("ask", what="conflicts")["data"]["conflicts"]
    assert conflict["name"] == "d1" and "d0" in conflict["members"]
    assert "follows from" in conflict["sentence"]
    assert "d0" in page.ask("ask", what="why", name="L0")["data"]["holds"]
    assert page.ask("ask", what="info", name="L0")["ok"]
    assert "Length of a line" in page.ask("ask", what="help", word="length")["text"]
    assert page.ask("ask", what="history")["data"]["position"] == 4
    assert page.ask("ask", what="evaluate", text="w*2 + L0.length")["data"]["value"] == 64.0
    table = page.ask("ask", what="table")["data"]
    assert {"add_line", "undo"} <= {one["name"] for one in table["commands"]}
    assert page.revision == revision and len(page.history["done"]) == 4


def test_a_question_does_not_end_a_drag(shared: SharedSketch, page: Local) -> None:
    page.run(RECTANGLE)
    page.ask("drag", handles=["L2.p1"], at=[50, 30])
    assert page.ask("ask", what="free")["ok"] and shared.is_dragging


def test_a_name_with_another_command_is_refused(page: Local) -> None:
    page.run(RECTANGLE)
    assert page.ask("ask", what="why", name="L0\nclear")["error"]["code"] == "E1401"
    assert page.ask("ask", what="info", name="L0; clear")["error"]["code"] == "E1401"
    assert "L0" in page.tables["entities"]


@pytest.mark.parametrize(
    ("text", "word"),
    [("add_li", "add_line"), ("length L", "L0"), ("length L0.p", "L0.p1"), ("x; len", "length")],
)
def test_words_are_completed(page: Local, text: str, word: str) -> None:
    page.run(RECTANGLE)
    data = page.ask("ask", what="complete", text=text)["data"]
    assert word in data["words"] and data["to"] == len(text)
    assert all(one.startswith(text[data["from"] :]) for one in data["words"])


def test_explain_changes_nothing(page: Local) -> None:
    page.run(RECTANGLE)
    revision = page.revision
    reply = page.ask("explain", text="length L0 90")
    assert reply["ok"] and "accepts" in reply["text"] and page.revision == revision
    assert "rejects" in page.ask("explain", text="horizontal L0")["text"]


# --- files --------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["json", "svg", "dxf"])
def test_a_drawing_is_exported_and_imported_as_one_step(page: Local, ending: str) -> None:
    if ending == "dxf":
        optional.require("ezdxf")
    page.run(RECTANGLE)
    reply = page.ask("file", do="export", format=ending, name="../../plate")
    assert reply["file"]["name"] == f"plate.{ending}"
    data = base64.b64decode(reply["file"]["data"])
    assert len(data) > 100
    if ending == "json":
        return
    page.run("clear")
    reply = page.ask("file", do="import", format=ending, name="plate", data=reply["file"]["data"])
    assert reply["ok"], reply
    assert len(page.tables["entities"]) == 4 and page.is_in_step()
    page.run("undo")
    assert not page.tables["entities"]


def test_a_damaged_file_is_refused(page: Local) -> None:
    data = base64.b64encode(b"<svg").decode()
    reply = page.ask("file", do="import", format="svg", data=data)
    assert reply["error"]["code"].startswith("E13") and not page.tables["entities"]


def test_a_sketch_without_a_file_is_not_saved(page: Local) -> None:
    assert page.ask("file", do="save")["error"]["code"] == "E1406"


def test_commands_name_files_below_the_folder_only(tmp_path: Path) -> None:
    shared = (
        shared_sketch(tmp_path / "in" / "a.json") if (tmp_path / "in").mkdir() is None else None
    )
    assert shared is not None
    page = Local(shared)
    for name in ("../out.json", "/tmp/out.json", "~/out.json"):
        assert page.run(f"save {name}")["error"]["code"] == "E1264"
    shared.finish()
