"""Pages of problems: models, code and output are those of the examples."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path

import pytest

import arael
from arael.cli.main import run
from benchmarks.by_scipy import __main__ as beside
from tests.examples.scripts import EXAMPLES, printed
from tests.examples.test_readmes import test_model_script_readme_picture as check_folder

NAMES = beside.NAMES
PAGES = EXAMPLES.parent / "docs" / "problems"


def blocks(name: str, language: str) -> list[str]:
    """Blocks of a language on the page of an example."""
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def commands(block: str) -> list[tuple[str, list[str]]]:
    """Commands of a console, and the lines that each prints."""
    parts = re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]
    return [(part.splitlines()[0], part.splitlines()[1:]) for part in parts]


@pytest.mark.parametrize("name", NAMES)
def test_folder(name: str) -> None:
    check_folder(name)
    assert f"`{name}`" in (EXAMPLES / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_models_and_code_are_those_of_the_example(name: str) -> None:
    models = [path.read_text(encoding="utf-8") for path in (EXAMPLES / name).glob("*.arael")]
    assert blocks(name, "arael")
    for block in blocks(name, "arael"):
        assert any(block in model for model in models), block
    script = (EXAMPLES / name / f"{name}.py").read_text(encoding="utf-8")
    for block in blocks(name, "py"):
        assert block in script, block


@pytest.mark.parametrize("name", NAMES)
def test_commands_print_what_the_page_shows(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))
    for command, lines in [one for block in blocks(name, "console") for one in commands(block)]:
        program, *args = shlex.split(command.replace("examples/", f"{EXAMPLES.as_posix()}/"))
        if program == "python":
            shown = printed(name, args[1:], monkeypatch, capsys)
        else:
            more = ["--interpret"] if args[0] == "solve" else []
            assert run([*args, *more]) == (1 if args[0] == "diagnose" else 0)
            shown = capsys.readouterr().out
        for line in lines:
            assert line == "..." or line in shown.splitlines(), line


@pytest.mark.parametrize("name", NAMES)
def test_lines_are_those_of_the_programs(name: str) -> None:
    module = __import__(f"benchmarks.by_scipy.{name}", fromlist=["PROGRAM"])
    counts = beside.lines_of_model(module), beside.lines_of_program(module)
    text = " ".join((PAGES / f"{name}.md").read_text(encoding="utf-8").split())
    assert "have {} and {} lines".format(*counts) in text
    table = (PAGES.parent / "internals" / "problems.md").read_text(encoding="utf-8")
    assert re.search(rf"problems/{name}\.md\).*\| {counts[0]} \| {counts[1]} \|", table)
