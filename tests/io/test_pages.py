"""Each code of the data packages has a page with wrong data that raises it, and right data."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.explain import codes, explain
from tests.io.cases import found

ROOT = Path(__file__).parents[2] / "arael"
PACKAGES = (ROOT / "io", ROOT / "face", ROOT / "runtime" / "store")
RAISED = {
    code
    for package in PACKAGES
    for path in package.rglob("*.py")
    for code in re.findall(r'"([EW]0\d{3})"', path.read_text())
}
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_every_code_raised_has_a_page() -> None:
    assert len(RAISED) > 20
    assert set(codes()) >= RAISED


@pytest.mark.parametrize("code", sorted(RAISED))
def test_examples(code: str, tmp_path: Path) -> None:
    blocks = BLOCK.findall(explain(code))
    model = next((text for kind, text in blocks if kind == "arael"), "")
    data = [(kind, text) for kind, text in blocks if kind in ("json", "g2o")]
    if not data:
        examples = [text for kind, text in blocks if kind == "python"] or blocks
        assert len(examples) == 2, "a wrong and a right example"
        return
    (kind, wrong), (_, right) = data
    assert code in [d.code for d in found(model, wrong, kind, tmp_path)]
    assert found(model, right, kind, tmp_path) == []
