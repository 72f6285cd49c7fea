"""The explain pages: every code has one, and its examples do what it says."""

import re
from pathlib import Path

import pytest

import arael
from arael.diagnostics.explain import codes, explain, title
from arael.diagnostics.records import AraelError, Source
from arael.syntax.parser import parse

SYNTAX = [code for code in codes() if code.startswith("E01")]
PACKAGE = Path(arael.__file__).parent


def said(model: str) -> set[str]:
    try:
        parse(Source("page.arael", model))
    except AraelError as error:
        return {d.code for d in error.diagnostics}
    return set()


def raised_codes() -> set[str]:
    texts = (p.read_text(encoding="utf-8") for p in PACKAGE.rglob("*.py"))
    return {code for text in texts for code in re.findall(r'"([EW]\d{4})"', text)}


def test_every_syntax_code_has_a_page() -> None:
    raised = {code for code in raised_codes() if code.startswith("E01")}
    assert raised == set(SYNTAX)


@pytest.mark.parametrize("code", SYNTAX)
def test_page_begins_with_its_code_and_a_title(code: str) -> None:
    first = explain(code).split("\n")[0]
    assert re.fullmatch(rf"# {code}: [a-z`][^.]*", first)
    assert len(explain(code)) > 200
    assert title(code) == first[2:]


@pytest.mark.parametrize("code", SYNTAX)
def test_wrong_example_says_so_and_right_one_parses(code: str) -> None:
    page = explain(code)
    wrong = re.search(r"Wrong:\n\n```arael\n(.*?)```", page, re.DOTALL)
    right = re.search(r"Right:\n\n```arael\n(.*?)```", page, re.DOTALL)
    if wrong:
        assert code in said(wrong[1])
    else:
        assert code in {"E0101", "E0102", "E0103", "E0104", "E0107"}
    if right:
        assert said(right[1]) == set()


def test_unknown_code_suggests() -> None:
    with pytest.raises(AraelError) as caught:
        explain("E0216x")
    assert "E0" in caught.value.diagnostics[0].help[0]
    assert explain("e0126") == explain("E0126")
    with pytest.raises(AraelError):
        explain("../explain")
