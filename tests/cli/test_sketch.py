"""`arael sketch`: scripts, standard input, JSON, exports, the prompt. Also E1290."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from arael.sketch.commands import session
from tests.cli.conftest import Arael
from tests.sketch.stand_in import StandIn

SCRIPT = """\
# a plate with a hole
param w 10
bottom, right, top, left = add_rect 0,0 w,5 hv
hole = add_circle 5,2.5 1
length bottom w; length right w/2
radius hole 1.5
print hole.center
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Editors without a solver: the command is the point."""
    monkeypatch.setattr(session, "_make_editor", StandIn)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ARAEL_HISTORY", str(tmp_path / "history"))
    return tmp_path


def test_a_script_runs(arael: Arael, folder: Path) -> None:
    (folder / "plate.cmd").write_text(SCRIPT)
    done = arael("sketch", "plate.cmd")
    assert (done.code, done.err) == (0, "")
    assert done.out.splitlines()[0] == "Added w = 10 (10)"
    assert done.out.splitlines()[-1] == "hole.center = (5, 2.5)"


def test_a_script_stops_at_the_first_error(arael: Arael, folder: Path) -> None:
    (folder / "bad.cmd").write_text("add_line 0,0 5,0\n\nlength L7 3\nadd_line 0,0 1,1\n")
    done = arael("sketch", "bad.cmd")
    assert done.code == 1
    assert "error[E1201]: no entity `L7` in the sketch" in done.err
    assert "--> bad.cmd:3:8" in done.err
    assert done.err.splitlines()[-1] == "note: 1 command line before this one is done"
    assert "L1" not in done.out


def test_a_sketch_is_loaded_and_a_script_run_on_it(arael: Arael, folder: Path) -> None:
    (folder / "plate.cmd").write_text(SCRIPT)
    assert arael("sketch", "plate.cmd", "--export", "out/../plate.json").code == 0
    (folder / "more.cmd").write_text("list params\nadd_point 1,1\nsave more.json\n")
    done = arael("sketch", "plate.json", "more.cmd", "--export", "again.json")
    assert done.code == 0, done.err
    assert done.out.splitlines()[0] == "w = 10 (10)"
    assert (folder / "more.json").read_bytes() == (folder / "again.json").read_bytes()


def test_files_of_a_script_are_beside_it(arael: Arael, folder: Path) -> None:
    (folder / "part").mkdir()
    (folder / "part" / "a.cmd").write_text("add_line 0,0 1,1\nsave a.json\n")
    assert arael("sketch", "part/a.cmd").code == 0
    assert (folder / "part" / "a.json").exists()
    (folder / "part" / "b.cmd").write_text("save ../b.json\n")
    assert arael("sketch", "part/b.cmd").code == 1


def test_json(arael: Arael, folder: Path) -> None:
    (folder / "a.cmd").write_text("add_line 0,0 5,0\nmeasure L0\nlength L9 3\n")
    done = arael("sketch", "a.cmd", "--json")
    first, second, third = map(json.loads, done.out.splitlines())
    assert first["status"] == "ok"
    assert first["names"] == ["L0"]
    assert second["data"][0]["length"] == 5
    assert third["status"] == "error"
    assert third["diagnostics"][0]["code"] == "E1201"
    assert third["done"] == "2 command lines before this one are done"
    assert done.code == 1


def test_timing(arael: Arael, folder: Path) -> None:
    (folder / "a.cmd").write_text("timing on\nadd_line 0,0 5,0\n")
    assert arael("sketch", "a.cmd").out.count(" ms\n") == 2


def test_standard_input(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("add_line 0,0 5,0\nmeasure L0\nexit\nfoo\n"))
    done = arael("sketch")
    assert done.code == 0
    assert "length: 5" in done.out
    monkeypatch.setattr("sys.stdin", io.StringIO("add_line 0,0 5,0\nfoo\n"))
    done = arael("sketch")
    assert done.code == 1
    assert "--> <stdin>:2:1\n" in done.err
    assert "1 | foo" not in done.err and "2 | foo" in done.err


def test_a_dash_is_standard_input(
    arael: Arael, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "a.cmd").write_text("add_line 0,0 5,0\n")
    monkeypatch.setattr("sys.stdin", io.StringIO("length L0 7\n\nlength L9 4\n"))
    done = arael("sketch", "a.cmd", "-")
    assert done.code == 1
    assert "Added d0" in done.out
    assert "--> <stdin>:3:8\n" in done.err
    assert "1 command line before this one is done" in done.err


def test_exit_ends_a_script(arael: Arael, folder: Path) -> None:
    (folder / "a.cmd").write_text("add_line 0,0 5,0\nexit\nfoo\n")
    assert arael("sketch", "a.cmd").code == 0


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00\x01", "folder"])
def test_a_script_that_cannot_be_read(
    arael: Arael, folder: Path, content: bytes | str | None
) -> None:
    if isinstance(content, bytes):
        (folder / "a.cmd").write_bytes(content)
    elif content:
        (folder / "a.cmd").mkdir()
    done = arael("sketch", "a.cmd")
    assert done.code == 2
    assert "E1290" in done.err


def test_a_sketch_that_cannot_be_read(arael: Arael, folder: Path) -> None:
    (folder / "a.json").write_text("[]")
    done = arael("sketch", "a.json")
    assert done.code == 2
    assert "E1210" in done.err
    assert arael("sketch", "b.json").code == 2


def test_an_export_of_no_format(arael: Arael, folder: Path) -> None:
    (folder / "a.cmd").write_text("add_line 0,0 5,0\n")
    done = arael("sketch", "a.cmd", "--export", "a.txt")
    assert done.code == 2
    assert "E1265" in done.err


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_prompt_goes_on_after_errors(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = iter(["add_line 0,0 5,0", "foo", "list lines", "exit", "never"])
    monkeypatch.setattr("sys.stdin", _Terminal())
    monkeypatch.setattr("builtins.input", lambda prompt: next(lines))
    done = arael("sketch")
    assert done.code == 0
    assert "L0: line (0, 0)-(5, 0), length 5" in done.out
    assert "E1250" in done.err
    assert next(lines) == "never"


def test_completion_knows_commands_names_and_properties() -> None:
    from arael.sketch.commands.completion import completions

    made = session.Session(StandIn())
    made.run("base = add_line 0,0 5,0; length base 4; param width 3")
    found = completions(made)
    assert {"add_line", "noconnect", "L0", "L0.p1", "L0.length", "base.p2", "d0", "width"} <= set(
        found
    )
