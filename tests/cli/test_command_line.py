"""The command as a whole: help, exit codes, failures, speed of starting."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from arael.cli import main
from arael.cli.lazy import COMMANDS
from tests.cli.conftest import Arael


def test_help_lists_every_command(arael: Arael) -> None:
    done = arael("--help")
    assert done.code == 0
    for name in COMMANDS:
        assert name in done.out
    assert "0 solved, 1 not converged, 2 bad input, 3 internal error" in " ".join(done.out.split())


@pytest.mark.parametrize("name", list(COMMANDS))
def test_every_command_has_help_as_listed(arael: Arael, name: str) -> None:
    from importlib import import_module

    assert arael(name, "--help").code == 0
    command = import_module(f"arael.cli.{name}").command
    assert command.short_help == COMMANDS[name]


def test_no_command_shows_help_and_fails(arael: Arael) -> None:
    done = arael()
    assert done.code == 2
    assert "Usage: arael" in done.out


def test_misspelt_command_gets_a_suggestion(arael: Arael) -> None:
    done = arael("slove", "x")
    assert done.code == 2
    assert "did you mean 'solve'?" in done.err


def test_missing_argument_is_told(arael: Arael) -> None:
    done = arael("solve", "slam")
    assert done.code == 2
    assert "missing argument 'DATA...'" in done.err
    assert "arael solve --help" in done.err


def test_version(arael: Arael) -> None:
    import arael as package

    assert arael("--version").out == f"arael {package.__version__}\n"


def test_internal_error_is_short(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARAEL_DEBUG", raising=False)
    monkeypatch.setattr("arael.cli.explain.explain", _broken)
    done = arael("explain", "E0201")
    assert done.code == 3
    assert "internal error: ZeroDivisionError: broken" in done.err
    assert "please report it" in done.err
    assert "Traceback" not in done.err


def test_debug_shows_the_traceback(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARAEL_DEBUG", "1")
    monkeypatch.setattr("arael.cli.explain.explain", _broken)
    assert "Traceback" in arael("explain", "E0201").err


def _broken(code: str) -> str:
    raise ZeroDivisionError("broken")


def test_help_starts_without_the_heavy_libraries() -> None:
    heavy = ["numpy", "scipy", "sympy", "lark", "Cython", "setuptools", "matplotlib", "rich"]
    code = (
        "import sys; from arael.cli.main import run; run(['--help']); "
        f"print([m for m in {heavy} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n"


def test_closed_pipe_is_no_error() -> None:
    code = "from arael.cli.main import main; import sys; sys.argv = ['arael', 'explain']; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    err = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 0
    assert err == b""


def test_main_leaves_with_the_exit_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["arael", "explain", "E9999"])
    with pytest.raises(SystemExit) as leaving:
        main.main()
    assert leaving.value.code == 2


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps the current folder")
def test_a_current_folder_that_was_removed_is_named(
    arael: Arael, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "m.arael").write_text("root R { param a: real\n constraint c { a } }\n")
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    done = arael("solve", "../m.arael", "../absent.json", "--interpret")
    assert done.code == 2
    assert "internal error" not in done.err
    assert "the current folder was removed" in done.err or "no such file" in done.err
