"""Nothing that was acknowledged is lost: the journal and the file beside it. Also E1408, E1410."""

from __future__ import annotations

import os
import random
import shutil
import time
from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, save, to_json
from arael.sketch.server import keeping
from arael.sketch.server.differences import Moment, difference, make
from arael.sketch.server.keeping import Keeper
from arael.sketch.server.shared import SharedSketch
from tests.sketch.server.shared import Local, shared_sketch

LINES = [
    "add_rect 0,0 50,30 hv",
    "length L0 60",
    "hole = add_circle 20,15 5",
    "param w 3",
    "radius hole w",
    "fillet L0 L1 4",
    "undo",
    "delete L2",
    "undo",
    "add_spline 0,40 10,50 20,30 40,40",
    "pattern rect hole 2 12",
    "add_ellipse 80,0 9 4 10",
    "param w 2",
    "settings unit cm",
    "rename_param w width",
    "rename A0 bore1",
    "rename L0 base1; rename base1 L0",
    "mirror L0 about L1",
    "clear",
    "undo",
    "drag L0.p1 3,4",
    "style L1 dashed",
    "redo",
    "delete L1",
]


def crash(shared: SharedSketch, folder: Path, to: Path) -> Path:
    """Everything as it would be on disk after a crash, in another folder."""
    assert shared.keeper is not None
    shutil.copytree(folder, to)
    return to / shared.keeper.path.name


def journal_of(path: Path) -> Path:
    return path.with_name(f"{path.name}.journal")


def state(shared: SharedSketch) -> bytes:
    return to_json(shared.session.document)


@pytest.mark.parametrize("saved_after", [(), (3,), (0, 5, 9, 17)])
def test_after_a_crash_everything_is_there_bit_by_bit(
    tmp_path: Path, saved_after: tuple[int, ...]
) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    shared = shared_sketch(folder / "a.json")
    page = Local(shared)
    for k, line in enumerate(LINES):
        page.run(line)
        if k in saved_after:
            assert shared.save() == ""
        there = crash(shared, folder, tmp_path / f"crash{k}")
        keeper = Keeper(there)
        assert to_json(keeper.document) == state(shared), line
        assert to_json(from_json(there.read_bytes())) == state(shared)
        assert not journal_of(there).exists()
        keeper.close(keeper.document)
    shared.finish()


def test_the_lines_change_the_sketch(tmp_path: Path) -> None:
    """The test above would pass with commands that are refused."""
    page = Local(shared_sketch())
    assert [line for line in LINES if not page.run(line)["ok"]] == ["redo"]


def test_changes_that_were_taken_up_can_be_undone(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    shared = shared_sketch(folder / "a.json")
    page = Local(shared)
    states = [state(shared)]
    for line in ("add_line 0,0 50,9", "length L0 60", "add_circle 5,5 2"):
        page.run(line)
        states.append(state(shared))
    again = shared_sketch(crash(shared, folder, tmp_path / "there"))
    assert again.keeper is not None and again.keeper.recovered == 3
    page = Local(again)
    assert page.history["done"] == ["add_line 0,0 50,9", "length L0 60", "add_circle 5,5 2"]
    for expected in reversed(states[:-1]):
        page.run("undo")
        assert state(again) == expected
    again.finish()
    shared.finish()


def test_a_cut_journal_gives_what_was_whole(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    shared = shared_sketch(folder / "a.json")
    page = Local(shared)
    states = [(0, state(shared))]
    for line in LINES[:6]:
        page.run(line)
        states.append((journal_of(folder / "a.json").stat().st_size, state(shared)))
    random.seed(7)
    whole = states[-1][0]
    sizes = [size for size, _ in states]
    for number, cut in enumerate(sorted({*random.sample(range(whole), 12), *sizes, *range(3)})):
        there = crash(shared, folder, tmp_path / f"cut{number}")
        os.truncate(journal_of(there), cut)
        keeper = Keeper(there)
        assert to_json(keeper.document) == max(s for s in states if s[0] <= cut)[1]
        keeper.close(keeper.document)
    shared.finish()


@pytest.mark.parametrize("before_rename", [True, False])
def test_a_crash_while_saving(tmp_path: Path, before_rename: bool) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    shared = shared_sketch(folder / "a.json")
    page = Local(shared)
    page.run("add_line 0,0 50,9")
    shared.save()
    page.run("length L0 60")
    assert shared.keeper is not None
    data = state(shared)
    shared.keeper._journal.note_save(keeping.fingerprint(data))
    there = crash(shared, folder, tmp_path / "there")
    if not before_rename:
        there.write_bytes(data)
    keeper = Keeper(there)
    assert to_json(keeper.document) == data
    assert keeper.recovered == (1 if before_rename else 0)
    keeper.close(keeper.document)
    shared.finish()


def test_a_journal_of_another_file_is_not_taken_up(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    shared = shared_sketch(path)
    Local(shared).run("add_line 0,0 50,9")
    there = crash(shared, tmp_path, tmp_path.with_name(f"{tmp_path.name}-there"))
    save(Document(), there)
    before = (there.read_bytes(), journal_of(there).read_bytes())
    with pytest.raises(AraelError) as caught:
        Keeper(there)
    (found,) = caught.value.diagnostics
    assert found.code == "E1408" and "another program" in found.message
    assert "a.json.journal" in found.help[0]
    assert before == (there.read_bytes(), journal_of(there).read_bytes())
    shared.finish()


DAMAGES = {
    "another format": b'{"format":"x","version":1,"base":""}\n',
    "another version": b'{"format":"arael-sketch-journal","version":9,"base":""}\n',
    "a damaged line": b'{"format":"arael-sketch-journal","version":1,"base":""}\n{"tit\n',
    "no change": b'{"format":"arael-sketch-journal","version":1,"base":""}\n{"title":"x"}\n',
    "an unknown entity": b'{"format":"arael-sketch-journal","version":1,"base":""}\n{"title":"x",'
    b'"put":{},"removed":{},"order":{},"numbers":{"L0":[1,2]},"settings":{}}\n',
    "a record that cannot be": b'{"format":"arael-sketch-journal","version":1,"base":""}\n'
    b'{"title":"x","put":{"constraints":[{"name":"C0","kind":"x","args":["L0"]}]},"removed":{},'
    b'"order":{},"numbers":{},"settings":{}}\n',
    "bytes": b"\xff\xfe\n\n",
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_journal_is_refused_and_kept(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.json"
    journal_of(path).write_bytes(DAMAGES[name])
    with pytest.raises(AraelError) as caught:
        Keeper(path)
    assert caught.value.diagnostics[0].code in ("E1408", "E1211")
    assert journal_of(path).read_bytes() == DAMAGES[name] and not path.exists()


def test_a_second_server_on_a_file_is_refused(tmp_path: Path) -> None:
    keeper = Keeper(tmp_path / "a.json")
    with pytest.raises(AraelError, match="another server edits this file"):
        Keeper(tmp_path / "a.json")
    keeper.close(keeper.document)
    again = Keeper(tmp_path / "a.json")
    again.close(again.document)


def test_the_file_is_written_after_a_pause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    shared = shared_sketch(tmp_path / "a.json")
    page = Local(shared)
    page.run("add_line 0,0 50,9")
    shared.idle()  # the verdict
    assert shared.idle() == pytest.approx(keeping.QUIET)
    assert not (tmp_path / "a.json").exists() and journal_of(tmp_path / "a.json").exists()
    now[0] += keeping.QUIET
    assert shared.idle() is None
    assert (tmp_path / "a.json").read_bytes() == state(shared)
    assert not journal_of(tmp_path / "a.json").exists()
    assert page.last("saved") == {"type": "saved", "revision": page.revision, "file": "a.json"}
    first = now[0]
    while now[0] < first + keeping.MOST + 2.0:  # also while changes come without a pause
        page.run("add_point 1,1 noconnect")
        now[0] += 1.0
        shared.idle()
        shared.idle()
    saved = [message for message in page.messages if message["type"] == "saved"]
    assert len(saved) == 2
    shared.finish()


def test_the_file_is_written_at_the_end(tmp_path: Path) -> None:
    shared = shared_sketch(tmp_path / "a.json")
    page = Local(shared)
    page.run("add_line 0,0 50,9")
    page.ask("drag", handles=["L0.p1"], at=[0, 0])
    page.drag_to(1, 9, 9)
    shared.finish()
    assert page.numbers("L0") == [0, 0, 50, 9]
    assert (tmp_path / "a.json").read_bytes() == state(shared)
    assert sorted(p.name for p in tmp_path.iterdir()) == [".a.json.lock", "a.json"]


def test_a_sketch_that_was_only_looked_at_is_not_written(tmp_path: Path) -> None:
    shared = shared_sketch(tmp_path / "a.json")
    Local(shared).run("list")
    shared.finish()
    assert not (tmp_path / "a.json").exists()


def test_a_file_that_another_program_wrote_is_not_overwritten(tmp_path: Path) -> None:
    shared = shared_sketch(tmp_path / "a.json")
    page = Local(shared)
    page.run("add_line 0,0 50,9")
    (tmp_path / "a.json").write_text("mine")
    assert "changed by another program" in shared.save()
    assert page.last("message")["level"] == "error"
    assert page.ask("file", do="save")["error"]["code"] == "E1407"
    shared.finish()
    assert (tmp_path / "a.json").read_text() == "mine"
    assert journal_of(tmp_path / "a.json").exists()


def test_a_disk_that_is_full_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shared = shared_sketch(tmp_path / "a.json")
    page = Local(shared)

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        assert page.run("add_line 0,0 50,9")["ok"]
        text = page.last("message")["text"]
        assert "the change is not on disk" in text and "no space left" in text
        assert "not saved" in shared.save()
    page.run("length L0 60")  # not without the change before it
    assert "an earlier change" in page.last("message")["text"]
    assert shared.keeper is not None and shared.keeper.due < time.monotonic()
    assert shared.save() == ""
    page.run("length L0 61")
    keeper = Keeper(crash(shared, tmp_path, tmp_path.with_name(f"{tmp_path.name}-there")))
    assert to_json(keeper.document) == state(shared)
    assert shared.save() == ""
    assert (tmp_path / "a.json").read_bytes() == state(shared)
    shared.finish()


def test_a_change_is_made_again_in_another_document() -> None:
    shared = shared_sketch()
    page = Local(shared)
    copy = Document()
    for line in LINES:
        before = Moment.of(shared.session.document)
        page.run(line)
        make(copy, difference(before, Moment.of(shared.session.document)), line)
        assert to_json(copy) == state(shared), line
    while copy.history.done:
        copy.undo()
    assert to_json(copy) == to_json(Document())


@pytest.mark.parametrize("what", ["file", "folder"])
def test_what_is_read_only_is_opened_and_never_replaced(tmp_path: Path, what: str) -> None:
    """Though a rename would do it, and the administrator may."""
    folder = tmp_path / "in"
    folder.mkdir()
    path = folder / "a.json"
    made = Document()
    with made.transaction("make"):
        made.add_entity("point", (1, 2))
    save(made, path)
    before = path.read_bytes()
    (path if what == "file" else folder).chmod(0o444 if what == "file" else 0o555)
    try:
        keeper = Keeper(path)
        assert keeper.read_only == f"the {what} is read-only"
        assert list(keeper.document.entities) == ["P0"]
        assert keeper.note("x", difference(Moment.of(Document()), Moment.of(made))) == ""
        assert "not saved" in keeper.save(made) and not keeper.is_due
        assert keeper.close(made) == ""
        with pytest.raises(AraelError, match=r"E0715.*read-only"):
            save(Document(), path)
    finally:
        folder.chmod(0o755)
    assert path.read_bytes() == before and list(folder.iterdir()) == [path]


def test_a_file_of_another_owner_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder that every user may write, by a user who may only read the file."""
    path = tmp_path / "a.json"
    save(Document(), path)
    before = path.read_bytes()
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).is_dir())
    assert Keeper(path).read_only == "the file is read-only"
    with pytest.raises(AraelError, match=r"E0715.*read-only"):
        save(Document(), path)
    assert path.read_bytes() == before
