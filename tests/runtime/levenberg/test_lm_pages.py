"""The explain pages of solve failures: there is one per code, and their models compile."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import arael
from arael.diagnostics.explain import codes, explain
from arael.loading import load

PACKAGE = Path(arael.__file__).parent
MINE = [code for code in codes() if "E1001" <= code <= "E1012" or "E1016" <= code <= "E1019"]


def test_every_code_has_a_page():
    texts = (p.read_text(encoding="utf-8") for p in PACKAGE.rglob("*.py"))
    raised = {code for text in texts for code in re.findall(r'"(E10[01]\d)"', text)}
    assert raised == set(MINE)


@pytest.mark.parametrize("code", MINE)
def test_models_on_the_page_compile(code, tmp_path):
    for k, model in enumerate(re.findall(r"```arael\n(.*?)```", explain(code), re.DOTALL)):
        path = tmp_path / f"page{k}.arael"
        path.write_text(model, encoding="utf-8")
        assert load(path, interpret=True).layout.entities
