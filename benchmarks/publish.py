"""``python -m benchmarks --publish REPORT``: tables of README and docs/speed.md from a report."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = {"README.md": "few", "docs/speed.md": "all"}
"""Pages with a table between marks, and which rows it has."""

FEW = {
    "slam: 300 poses": "SLAM, 300 poses",
    "pose_graph: M3500": "pose graph M3500",
    "pose_graph: sphere2500": "pose graph sphere2500",
    "bundle: problem-49-7776-pre": "bundle adjustment, problem-49-7776",
    "plane: 300 poses": "planes, 300 poses",
}
"""Rows of the README, with the names that they have there."""

NAMES = {"rust": "Rust framework", "gtsam": "GTSAM", "ceres": "Ceres", "g2o": "g2o"}
MARKS = re.compile(r"(<!-- measured -->\n).*?(\n<!-- /measured -->)", re.DOTALL)


def publish(report: str, page: str, rows: str) -> str:
    """The text of a page with the table of the report's summary between its marks.

    Parameters
    ----------
    rows : ``few``: those of `FEW` without the Rust framework; ``all``, with the machine above

    Raises
    ------
    ValueError
        The report has no summary, or the page no marks.
    """
    summary = re.search(r"^## Summary\n.*?^(\|.*?)\n\n", report, re.DOTALL | re.MULTILINE)
    if summary is None:
        raise ValueError("the report has no summary: it needs the suites with peers")
    head, _, *lines = (_cells(line) for line in summary[1].splitlines())
    table = _few(head, lines) if rows == "few" else _all(report, head, lines)
    found, count = MARKS.subn(lambda m: f"{m[1]}\n{table}{m[2]}", page)
    if count != 1:
        raise ValueError("the page needs the marks <!-- measured --> and <!-- /measured --> once")
    return found


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def _few(head: list[str], lines: list[list[str]]) -> str:
    kept = [k for k, name in enumerate(head) if name != "rust"]
    by_name = {cells[0]: cells for cells in lines}
    rows = [
        [name, *(_short(by_name[problem][k]) for k in kept[1:])] for problem, name in FEW.items()
    ]
    return _table([head[k] for k in kept], rows)


def _all(report: str, head: list[str], lines: list[list[str]]) -> str:
    machine = report.split("\n## ", 1)[0].partition("\n")[2].strip()
    return f"{machine}\n\n{_table(head, lines)}"


def _short(cell: str) -> str:
    """Two significant digits, without the mark of residuals of its own."""
    value = float(cell.removesuffix(" ~"))
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"


def _table(head: list[str], rows: list[list[str]]) -> str:
    names = [NAMES.get(name, name) for name in head]
    lines = [f"| {' | '.join(names)} |", "|---|" + "--:|" * (len(names) - 1)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"


def publish_all(path: Path) -> list[Path]:
    """Write the pages that differ from the report; return them."""
    report = path.read_text(encoding="utf-8")
    written = []
    for name, rows in PAGES.items():
        page = ROOT / name
        text = page.read_text(encoding="utf-8")
        made = publish(report, text, rows)
        if made != text:
            page.write_text(made, encoding="utf-8")
            written.append(page)
    return written
