"""Messages about formulas, as the Markdown files in ``cases`` show them; pages of their codes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import arael
from arael import sym
from arael.diagnostics.explain import codes, explain
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render
from tests.mdtest import Case, check_case, find_cases

CASES = find_cases(Path(__file__).parent / "cases")
PACKAGES = [Path(arael.__file__).parent / name for name in ("sym", "calculator")]
RAISED = {
    code
    for package in PACKAGES
    for path in package.glob("*.py")
    for code in re.findall(r'"([EW]\d{4})"', path.read_text())
}
OWN = sorted(c for c in RAISED if "E0650" <= c <= "E0659")
PYTHON = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def messages(name: str, text: str) -> str:
    bag = sym.FunctionBag(
        "square(x) = x^2", "pair(a, b) = a + b", "endless(x) = other(x)", "other(x) = endless(x)"
    )
    names = {"v": sym.vector("v", 3), "M": [[1, 2], [3, 4]]}
    try:
        sym.parse(text.rstrip("\n"), bag, names)
    except AraelError as error:
        return render(error.diagnostics)
    return ""


@pytest.mark.parametrize("case", CASES, ids=str)
def test_message(case: Case, update: bool) -> None:
    check_case(case, messages, update)
    assert messages(case.heading, case.model)


def test_every_code_raised_has_a_page() -> None:
    assert len(OWN) == 6
    assert set(codes()) >= RAISED


@pytest.mark.parametrize("code", [c for c in OWN if c != "E0655"])
def test_examples_of_pages(code: str) -> None:
    wrong, right = PYTHON.findall(explain(code))
    with pytest.raises(AraelError) as caught:
        exec(wrong, {})
    assert caught.value.diagnostics[0].code == code
    exec(right, {})
