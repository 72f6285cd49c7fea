"""Pages of the messages of these commands: their examples do what they say."""

from __future__ import annotations

import re

import pytest

from arael.diagnostics.explain import explain
from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


@pytest.mark.parametrize("code", ["E1280", "E1281", "E1282", "E1283", "E1284", "E1285", "E1286"])
def test_examples_of_a_page(code: str) -> None:
    page = explain(code)
    assert re.match(rf"# {code}: [^\n]+[^\n.]\n", page)
    wrong, right = (
        re.search(rf"{word}:\n\n```\n(.*?)```", page, re.DOTALL) for word in ("Wrong", "Right")
    )
    assert wrong and right
    with pytest.raises(AraelError) as caught:
        Session().run(wrong[1])
    assert caught.value.diagnostics[0].code == code
    Session().run(right[1])
