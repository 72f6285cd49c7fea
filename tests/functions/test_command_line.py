"""Models with native functions on the command line, which binds nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arael.cli.main import run

MODEL = """# A fit through native code.
extern fn half(x) derivs [0.5]
root Fit {
    param a: real
    constraint c { half(a) - 1 }
}
"""


@pytest.fixture
def model(tmp_path: Path) -> str:
    (tmp_path / "data.json").write_text('{"a": 0}')
    path = tmp_path / "fit.arael"
    path.write_text(MODEL)
    return str(path)


def test_a_solve_says_how_to_bind(
    model: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["solve", model, str(tmp_path / "data.json"), "--interpret"]) == 2
    told = capsys.readouterr().err
    assert "error[E0820]: nothing is bound to the native function `half`" in told
    assert "`Fit.c` calls it" in told
    assert "the command line does not" in " ".join(told.split())
    assert 'functions={"half": ...}' in told.replace("\n", "")


@pytest.mark.parametrize(
    "command", [["check"], ["fmt", "--check"], ["info"], ["emit", "--stage", "pyx"]]
)
def test_what_needs_no_value_works(
    model: str, command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([command[0], model, *command[1:]]) == 0, capsys.readouterr()


def test_its_native_functions_are_shown(model: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["info", model]) == 0
    assert "  extern fn half(x) derivs [0.5]\n" in capsys.readouterr().out
    assert run(["info", model, "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["functions"]
    assert (found["name"], found["native"], found["derivatives"]) == ("half", True, ["0.5"])
