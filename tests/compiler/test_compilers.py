"""Compilers that fail, now and then or always: what is reported, and when it is tried again."""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from arael.cli.doctor import examine
from arael.cli.main import run
from arael.compiled_model import CompiledModel
from arael.compiler import build, cache, progress
from arael.diagnostics.model_warnings import InterpretedWarning
from arael.diagnostics.records import AraelError
from arael.loading import load_compiled

pytestmark = pytest.mark.skipif(
    sys.platform == "win32" or shutil.which("cc") is None,
    reason="wraps a C compiler called `cc` in shell scripts: install gcc",
)

Wrap = Callable[[str], Path]


@pytest.fixture
def wrap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Wrap:
    """Make CC a script: the given lines, then the real compiler; returns its folder.

    The lines see the arguments in ``$*``; each call adds a line to the file `calls`.
    """
    folder = tmp_path / "compiler"
    folder.mkdir()

    def make(lines: str) -> Path:
        script = folder / "wrapped-cc"
        script.write_text(
            f'#!/bin/sh\nhere={folder}\necho "$*" >> $here/calls\n'
            f'[ "$1" = --version ] && exec cc --version\n{lines}\nexec cc "$@"\n'
        )
        script.chmod(0o700)
        monkeypatch.setenv("CC", str(script))
        return folder

    return make


def interpreted(model: Path, match: str) -> CompiledModel:
    with pytest.warns(InterpretedWarning, match=match):
        found = load_compiled(model)
    assert found.kernels is None
    return found


def calls(folder: Path) -> int:
    """Compilations so far, without the questions for the version."""
    text = (folder / "calls").read_text() if (folder / "calls").exists() else ""
    return sum("--version" not in line for line in text.splitlines())


def doctor() -> tuple[str, str]:
    (found,) = (f for f in examine() if f.name == "C compiler")
    return found.state, found.advice


def modules() -> list[Path]:
    return list((cache.directory() / "arael-kernels").rglob("*.so"))


def test_without_compiler_the_interpreter_stands_in(
    model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    interpreted(model, "no-such-compiler")
    interpreted(model, "no-such-compiler")
    with pytest.raises(AraelError, match="no-such-compiler"):
        load_compiled(model, interpret=False)


def test_once_there_is_a_compiler_it_is_used(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as without:
        without.setattr(build, "find_compiler", lambda: None)
        interpreted(model, "no C compiler")
        interpreted(model, "no C compiler")
    assert load_compiled(model).origin == "compiled"


def test_a_full_disk_for_the_compiler_passes(model: Path, wrap: Wrap) -> None:
    folder = wrap('[ -e $here/full ] && { echo "No space left on device" >&2; exit 1; }')
    (folder / "full").touch()
    interpreted(model, "status 1")
    assert doctor()[0] == "broken"
    before = calls(folder)
    interpreted(model, "status 1")
    assert calls(folder) == before + 1  # a small module, not the model
    (folder / "full").unlink()
    assert doctor() == ("ok", "")
    assert load_compiled(model).origin == "compiled"
    assert not list((cache.directory() / "arael-failed").iterdir())


def test_a_compiler_that_is_killed_once_is_tried_again(model: Path, wrap: Wrap) -> None:
    wrap("[ -e $here/killed ] || { touch $here/killed; kill -9 $$; }")
    interpreted(model, "was ended by SIGKILL")
    assert load_compiled(model).origin == "compiled"


def test_temporary_files_of_the_compiler_are_private(
    model: Path, wrap: Wrap, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full or open TMPDIR is not used."""
    folder = wrap("echo $TMPDIR > $here/place")
    monkeypatch.setenv("TMPDIR", "/no/such/folder")
    assert load_compiled(model).origin == "compiled"
    assert (folder / "place").read_text().startswith(str(cache.directory()))


@pytest.mark.slow
def test_what_a_working_compiler_refuses_is_not_tried_again(model: Path, wrap: Wrap) -> None:
    folder = wrap('case "$*" in *kernels_line*) echo "error: too clever" >&2; exit 1;; esac')
    interpreted(model, "status 1")
    (log,) = (cache.directory() / "arael-failed").glob("*.log")
    assert "too clever" in log.read_text()
    before = calls(folder)
    interpreted(model, "status 1")
    assert calls(folder) == before
    with pytest.raises(AraelError, match="status 1"):
        load_compiled(model, interpret=False)
    script = folder / "wrapped-cc"  # another compiler in its place
    script.write_text('#!/bin/sh\nexec cc "$@"\n')
    os.utime(script, (1e9, 1e9))
    assert load_compiled(model).origin == "compiled"


def test_a_failure_is_forgotten_after_a_day(
    model: Path, wrap: Wrap, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrap('[ -e $here/bad ] && case "$*" in *kernels_line*) exit 1;; esac')
    (model.parent / "compiler" / "bad").touch()
    interpreted(model, "status 1")
    (model.parent / "compiler" / "bad").unlink()
    interpreted(model, "status 1")
    now = time.time()
    monkeypatch.setattr(time, "time", lambda: now + 90_000)
    assert load_compiled(model).origin == "compiled"


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    "result",
    [
        "echo nonsense > $out",
        "cp /bin/true $out",
        'cc "$@"; head -c 6000 $out > $out.part; mv $out.part $out',
        "printf 'int x;' | cc -shared -x c - -o $out",
    ],
    ids=["text", "program", "truncated", "no module"],
)
def test_garbage_is_not_kept(model: Path, wrap: Wrap, result: str) -> None:
    folder = wrap(
        'if [ -e $here/bad ]; then while [ "$1" ]; do [ "$1" = -o ] && out=$2; args="$args $1"; '
        f"shift; done; set -- $args; {result}; exit 0; fi"
    )
    (folder / "bad").touch()
    interpreted(model, "module that Python cannot load")
    assert modules() == []
    state, advice = doctor()
    assert state == "broken" and "cannot load" in advice
    (folder / "bad").unlink()
    assert load_compiled(model).origin == "compiled"


def test_a_compiler_that_makes_nothing_is_reported(model: Path, wrap: Wrap) -> None:
    wrap("exit 0")
    interpreted(model, "reported success, but made no module")


def test_a_compiler_that_hangs_is_stopped(
    model: Path, wrap: Wrap, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = wrap("sleep 300 & echo $! > $here/child; wait")
    monkeypatch.setenv("ARAEL_COMPILE_TIMEOUT", "0.5")
    seen: list[str] = []
    monkeypatch.setattr(progress, "listener", lambda what, seconds, limit: seen.append(what))
    with pytest.raises(AraelError) as caught:
        load_compiled(model, interpret=False)
    (found,) = caught.value.diagnostics
    assert found.code == "E0807"
    assert "did not end within 0.5 s" in found.message
    assert any("ARAEL_COMPILE_TIMEOUT" in text for text in found.help)
    assert any(what.startswith("compiling line, about ") for what in seen)
    child = int((folder / "child").read_text())
    for _ in range(100):  # the process is gone, or about to be
        if not _runs(child):
            break
        time.sleep(0.05)
    assert not _runs(child)
    interpreted(model, "did not end within")


def _runs(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.parametrize("text", ["soon", "-1", "0", "nan", "inf"])
def test_a_time_limit_that_is_none_is_refused(
    model: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.setenv("ARAEL_COMPILE_TIMEOUT", text)
    with pytest.raises(AraelError) as caught:
        load_compiled(model)
    assert caught.value.diagnostics[0].code == "E0809"


def test_progress_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    from arael.cli.compiling import CompilingLine

    line = CompilingLine()
    for seconds in (1.0, 31.0, 60.0, None):
        line("compiling fit", seconds, 600.0)
    assert capsys.readouterr().err == "compiling fit ... 31 s so far (at most 600 s)\n"


@pytest.mark.parametrize("value", ["   ", "\t"])
def test_blank_cc_is_no_choice(model: Path, monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    monkeypatch.setenv("CC", value)
    path = build.find_compiler()
    assert path is not None
    assert doctor()[0] == "ok"


@pytest.mark.parametrize("said", ["", "\\n\\n", "\\377\\376 1.0"])
def test_a_compiler_that_does_not_tell_its_version(
    model: Path, wrap: Wrap, monkeypatch: pytest.MonkeyPatch, said: str
) -> None:
    script = wrap("") / "wrapped-cc"
    script.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && {{ printf "{said}"; exit; }}\nexec cc "$@"'
    )
    assert build.compiler_version() in ("", "\ufffd\ufffd 1.0")
    assert doctor()[0] == "ok"


def test_a_compiler_that_cannot_be_started(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = model.with_name("not-a-program")
    script.write_bytes(b"\x7fELF nonsense")
    script.chmod(0o700)
    monkeypatch.setenv("CC", str(script))
    interpreted(model, "cannot be started")


def test_clear_leaves_a_running_compilation_alone(
    model: Path, wrap: Wrap, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = wrap("touch $here/started; while [ ! -e $here/go ]; do sleep 0.05; done")
    found: list[CompiledModel] = []
    thread = threading.Thread(target=lambda: found.append(load_compiled(model, interpret=False)))
    thread.start()
    try:
        for _ in range(600):
            if (folder / "started").exists():
                break
            time.sleep(0.05)
        assert run(["cache", "clear"]) == 0
        assert "another process is compiling" in capsys.readouterr().out
    finally:
        (folder / "go").touch()
        thread.join()
    assert [one.origin for one in found] == ["compiled"]
    assert load_compiled(model).origin == "cache"
