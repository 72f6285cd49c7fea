"""Messages about native functions, as messages.md shows them.

``pytest --update`` writes the present output into the file.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import re
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.diagnostics.render import render
from tests.functions.models import libm

PAGE = Path(__file__).parent / "messages.md"
CASE = re.compile(
    r"^## (?P<title>[^\n]*)\n(?:(?!^```|^#)[^\n]*\n)*?"
    r"^```python\n(?P<code>.*?)^```\n\n```text\n(?P<said>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
CASES = list(CASE.finditer(PAGE.read_text(encoding="utf-8")))


@pytest.mark.parametrize("number", range(len(CASES)), ids=[c["title"] for c in CASES])
def test_message(
    number: int, tmp_path: Path, update: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = PAGE.read_text(encoding="utf-8")
    case = list(CASE.finditer(text))[number]
    model = re.search(r"```arael\n(.*?)```", text, re.DOTALL)
    assert model is not None

    def load(text: str = "", **functions: Any) -> Any:
        path = Path("fit.arael")
        path.write_text(f"{text}\n{model[1]}" if text else model[1], encoding="utf-8")
        return arael.load(path, functions=functions, interpret=True)

    monkeypatch.chdir(tmp_path)
    names = {"load": load, "libm": libm, "ctypes": ctypes}
    with pytest.raises(arael.AraelError) as caught:
        exec(compile(case["code"], case["title"], "exec"), names)
    said = render(caught.value.diagnostics)
    if said != case["said"] and update:
        start, end = case.span("said")
        PAGE.write_text(text[:start] + said + text[end:], encoding="utf-8")
        return
    assert said == case["said"]


def test_every_heading_is_a_case_and_every_code_is_shown() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert len(CASES) == text.count("\n## ")
    assert {"E0820", "E0821", "E0822"} <= set(re.findall(r"error\[(E\d+)\]", text))
