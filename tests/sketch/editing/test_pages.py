"""The pages of what the editor refuses: their examples do what they say."""

from __future__ import annotations

import re

import pytest

from arael.diagnostics.explain import codes, explain
from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session

OWN = [code for code in codes() if re.fullmatch(r"E12[23]\d", code)]


def errors(text: str) -> list[str]:
    try:
        Session().run(text)
    except AraelError as error:
        return [d.code for d in error.diagnostics]
    return []


def test_there_are_pages() -> None:
    assert len(OWN) >= 8


@pytest.mark.parametrize("code", OWN)
def test_page(code: str) -> None:
    page = explain(code)
    assert re.match(rf"# {code}: [^\n]+[^\n.]\n", page)
    for heading, raised in (("Wrong", True), ("Right", False)):
        found = re.search(rf"{heading}:\n\n```\n(.*?)```", page, re.DOTALL)
        if found:
            assert (code in errors(found[1])) == raised
            assert raised or errors(found[1]) == []
