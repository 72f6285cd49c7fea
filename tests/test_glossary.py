"""Terms that documents use and that users of other solvers may not know are in the glossary."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
GLOSSARY = (DOCS / "glossary.md").read_text(encoding="utf-8")
ENTRIES = [
    term.strip()
    for terms in re.findall(r"^- \*\*([^*]+)\*\*:", GLOSSARY, re.MULTILINE)
    for term in terms.split(",")
]
TERMS = (
    "tie",
    "derived parameter",
    "profile",
    "secant step",
    "relaxation",
    "tape",
    "chart",
    "retraction",
    "last factor",
    "group",
    "connected component",
    "dogleg",
    "predicted decrease",
    "gain ratio",
    "expression machine",
    "reduced chi-square",
    "variable projection",
    "scatter plan",
    "hoisting",
    "frine",
)


@pytest.mark.parametrize("term", TERMS)
def test_terms_of_the_documents_are_in_the_glossary(term: str) -> None:
    assert term in ENTRIES


def test_no_term_has_two_entries() -> None:
    assert len(ENTRIES) == len(set(ENTRIES))


def test_code_in_the_glossary_exists() -> None:
    from arael.config import LmConfig
    from arael.result import Result

    for name in ("rel_precision", "strategy"):
        assert name in LmConfig.__dataclass_fields__
    assert "noise_floor" in Result.__dataclass_fields__
