"""Skips: a summary of what is missing, and `--no-skips`, which makes a skip a failure."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

import pytest

Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--no-skips",
        action="store_true",
        help="a skipped test fails: for machines that have all optional parts",
    )


def _judged(report: Report, config: pytest.Config) -> Report:
    """Turn a skip into a failure; expected failures (`xfail`) also count as skipped and remain."""
    if config.getoption("--no-skips") and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome = "failed"
        report.longrepr = f"{report.nodeid}: --no-skips forbids this skip: {reason}"
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print each part that is missing, with the number of its tests and how to get it."""
    missing: dict[str, list[str]] = {}
    for report in terminalreporter.stats.get("skipped", []):
        part, colon, remedy = report.longrepr[2].removeprefix("Skipped: ").partition(": ")
        if colon and part.startswith("needs "):
            missing.setdefault(part, []).append(remedy)
    for part, remedies in sorted(missing.items()):
        terminalreporter.write_line(f"{len(remedies)} skipped, {part}: {remedies[0]}")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    return _judged((yield), item.config)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    return _judged((yield), collector.config)
