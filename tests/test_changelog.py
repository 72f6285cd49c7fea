"""The changelog: few entries, each of one line, with links that lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LONGEST = 230
MOST = {"": 60, "Performance": 5}
"""Entries of a release, and of its Performance."""


def releases() -> dict[str, str]:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    title, *parts = re.split(r"^## (.*)\n", text, flags=re.MULTILINE)
    assert title.startswith("# Changelog")
    return dict(zip(parts[::2], parts[1::2], strict=True))


def entries(text: str) -> list[str]:
    return re.findall(r"^- .*", text, flags=re.MULTILINE)


@pytest.mark.parametrize("release", releases())
def test_a_release_is_few_entries_of_one_line(release: str) -> None:
    text = releases()[release]
    groups = re.split(r"^### (.*)\n", text, flags=re.MULTILINE)
    assert 0 < len(entries(text)) <= MOST[""]
    for name, group in zip(groups[1::2], groups[2::2], strict=True):
        lines = [line for line in group.splitlines() if line]
        assert lines and all(line.startswith("- ") and line.endswith(".") for line in lines), name
        assert len(lines) <= MOST.get(name, MOST[""]), name
        assert [line for line in lines if len(line) > LONGEST] == []


def test_links_lead_somewhere() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert [p for p in re.findall(r"\]\(([^)#:]+)", text) if not (ROOT / p).exists()] == []
