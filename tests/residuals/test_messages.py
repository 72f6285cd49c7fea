"""Messages about formulas given at run time, as messages.md shows them.

``pytest --update`` writes the present output into the file.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.diagnostics.explain import explain
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render

PAGE = Path(__file__).parent / "messages.md"
CASE = re.compile(
    r"^## (?P<title>[^\n]*)\n\n```python\n(?P<code>.*?)^```\n\n```text\n(?P<said>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
CASES = list(CASE.finditer(PAGE.read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def sketch(tmp_path_factory: pytest.TempPathFactory) -> type:
    model = re.search(r"```arael\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert model is not None
    path = tmp_path_factory.mktemp("models") / "sketch.arael"
    path.write_text(model[1], encoding="utf-8")
    return arael.load(path, interpret=True)


def filled(sketch: type) -> Any:
    model = sketch()
    model.points.extend(pos=[[0, 0], [1, 0], [2, 1]])
    return model


@pytest.mark.parametrize("number", range(len(CASES)), ids=[c["title"] for c in CASES])
def test_message(number: int, sketch: type, update: bool) -> None:
    text = PAGE.read_text(encoding="utf-8")
    case = list(CASE.finditer(text))[number]
    with pytest.raises(AraelError) as caught:
        exec(compile(case["code"], case["title"], "exec"), {"model": filled(sketch)})
    said = render(caught.value.diagnostics)
    said = re.sub(r"/\S*/sketch.arael", "sketch.arael", said)
    if said != case["said"] and update:
        start, end = case.span("said")
        PAGE.write_text(text[:start] + said + text[end:], encoding="utf-8")
        return
    assert said == case["said"]


def test_all_codes_of_the_room_are_shown_and_explained() -> None:
    package = Path(arael.__file__).parent / "residuals"
    raised = {
        code
        for path in package.glob("*.py")
        for code in re.findall(r'"(E076\d)"', path.read_text(encoding="utf-8"))
    }
    said = set(re.findall(r"error\[(E076\d)\]", PAGE.read_text(encoding="utf-8")))
    assert raised == said == {f"E076{k}" for k in range(7)}
    for code in raised:
        assert "Right:" in explain(code)


def test_a_mistake_leaves_the_model_as_it_was(sketch: type) -> None:
    model = filled(sketch)
    good = model.residuals.add("scale - 2", label="goal")
    before = model.hessian()
    for text in ("scale - ", "nothing", "scale - [1, 2]"):
        with pytest.raises(AraelError):
            model.residuals.add(text, label="bad")
        with pytest.raises(AraelError):
            good.text = text
    assert good.text == "scale - 2"
    assert list(model.residuals) == ["goal"]
    assert (model.hessian() == before).all()
