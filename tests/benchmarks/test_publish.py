"""The tables of the README and of docs/speed.md are those of the stored report."""

from __future__ import annotations

import pytest

from benchmarks.publish import PAGES, ROOT, publish

REPORT = (ROOT / "benchmarks" / "reports" / "full.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES)
def test_pages_have_the_table_of_the_report(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert publish(REPORT, text, PAGES[page]) == text


def test_values_are_those_of_the_report() -> None:
    made = publish(
        REPORT.replace("| 1.19 |", "| 7.31 |"), "<!-- measured -->\n\n<!-- /measured -->", "few"
    )
    assert "| pose graph M3500 | 7.3 | 43 | 8.6 | 6.6 |" in made
    assert "Rust" not in made


@pytest.mark.parametrize(("report", "page"), [("# none", "x"), (REPORT, "no marks")])
def test_what_is_missing_is_named(report: str, page: str) -> None:
    with pytest.raises(ValueError, match="needs the"):
        publish(report, page, "all")
