"""Messages of commands, as the Markdown files in ``cases`` show them, and their pages."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.explain import codes, explain
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render
from arael.sketch.commands.session import Session
from tests.mdtest import Case, check_case, find_cases
from tests.sketch.stand_in import StandIn

ROOT = Path(__file__).parents[3]
CASES = find_cases(Path(__file__).parent / "cases")
OWN = [code for code in codes() if re.fullmatch(r"E12[5-7]\d|E1240|E1290", code)]
# What one small script does not show.
ELSEWHERE = {
    "E1260": "tests/sketch/commands/test_hostile.py",
    "E1270": "tests/sketch/commands/test_files.py",
    "E1290": "tests/cli/test_sketch.py",
}


def session(folder: Path) -> Session:
    return Session(StandIn(), folder=folder, make_editor=StandIn)


def errors(text: str, folder: Path) -> list[str]:
    try:
        session(folder).run(text)
    except AraelError as error:
        return [d.code for d in error.diagnostics]
    return []


@pytest.mark.parametrize("case", CASES, ids=str)
def test_message(case: Case, update: bool, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()

    def run(name: str, text: str) -> str:
        with pytest.raises(AraelError) as caught:
            session(folder).run(text, "script.cmd")
        return render(caught.value.diagnostics)

    check_case(case, run, update)


def test_there_are_cases() -> None:
    assert len(CASES) > 80


@pytest.mark.parametrize("code", OWN)
def test_page_has_a_title_and_examples_that_do_what_it_says(code: str, tmp_path: Path) -> None:
    page = explain(code)
    assert re.match(rf"# {code}: [^\n]+[^\n.]\n", page)
    wrong = re.search(r"Wrong:\n\n```\n(.*?)```", page, re.DOTALL)
    right = re.search(r"Right:\n\n```\n(.*?)```", page, re.DOTALL)
    if wrong:
        assert code in errors(wrong[1], tmp_path)
    else:
        assert code in ELSEWHERE
    if right:
        assert errors(right[1], tmp_path) == []


def raised() -> list[str]:
    folders = ("sketch/commands", "sketch/expressions")
    paths = [path for f in folders for path in (ROOT / "arael" / f).rglob("*.py")]
    found = {
        code
        for path in [*paths, ROOT / "arael/sketch/sketch.py", ROOT / "arael/cli/sketch.py"]
        for code in re.findall(r'"(E1[2-3]\d\d)"', path.read_text(encoding="utf-8"))
    }
    return sorted(code for code in found if re.fullmatch(r"E12[5-7]\d|E1240", code))


@pytest.mark.parametrize("code", raised())
def test_every_code_that_commands_raise_has_a_page(code: str) -> None:
    assert code in codes()


@pytest.mark.parametrize("code", OWN)
def test_every_code_is_shown_by_a_case_or_tested_elsewhere(code: str) -> None:
    if code in ELSEWHERE:
        assert code in (ROOT / ELSEWHERE[code]).read_text(encoding="utf-8")
        return
    shown = "".join(case.expected for case in CASES)
    assert f"[{code}]" in shown
