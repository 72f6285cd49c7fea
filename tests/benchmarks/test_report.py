"""The report: ratios, marks of answers that are not good enough, reasons, exponents."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import pictures
from benchmarks.cases import Case
from benchmarks.chapters import Report
from benchmarks.report import suite_report, summary
from benchmarks.scale import bytes_per_observation, exponent
from benchmarks.systems import Measured, Outcome, Plan
from tests.optional import require

OURS = Outcome((0.001, 0.002, 0.003), 80.0, 100.0, 7, "arael 1", "solver band")
SLOW = Outcome((0.020, 0.022, 0.021), 50.0, 100.05, 9, "Peer 2", "LM")
BAD = Outcome((0.004,), 50.0, 100.2, 9, "Other 3", "LM")
ABSENT = Outcome(reason="cargo is not installed")


@pytest.fixture
def measured() -> list[Measured]:
    case = Case("slam", "60 poses", Path("x.npz"))
    found = {"arael": OURS, "gtsam": SLOW, "ceres": BAD, "rust": ABSENT}
    return [Measured(case, 1, found), Measured(case, 2, found)]


def test_a_suite_shows_times_ratios_costs_and_reasons(measured: list[Measured]) -> None:
    text = "\n".join(suite_report("slam", measured, "r-slam.png"))
    assert "| 60 poses | 2.00 (1.00-3.00) | 21.00 (20.00-22.00) | 4.00 (4.00-4.00) | - |" in text
    assert "| 60 poses | 1.0 | 10.5 | 2.0 | - |" in text
    assert "| 60 poses | 100 (7) | 100.05 (9) | 100.2 ! (9) | - |" in text
    assert "| 60 poses, 2 threads | 80 | 50 | 50 | - |" in text
    assert "- rust: 60 poses, 60 poses, 2 threads: cargo is not installed" in text
    assert "- Peer 2: LM" in text
    assert "![slam](r-slam.png)" in text


def test_residuals_of_ones_own_are_marked(measured: list[Measured]) -> None:
    own = replace(SLOW, residuals="of scenes: pixels instead of angles")
    own = replace(measured[0], found={**measured[0].found, "gtsam": own})
    for lines in (suite_report("slam", [own], None), summary({"slam": [own]})):
        text = "\n".join(lines)
        assert "| 10.5 ~ | 2.0 | - |" in text
        assert "`~`: with residuals of its own" in text
    assert "- Peer 2: LM; of scenes: pixels instead of angles" in "\n".join(
        suite_report("slam", [own], None)
    )
    assert "~" not in "\n".join(summary({"slam": measured}))


def test_the_summary_is_of_one_thread(measured: list[Measured]) -> None:
    lines = summary({"slam": measured})
    assert lines[-1] == "| slam: 60 poses | 2.00 | 10.5 | 2.0 | - |"
    assert sum(line.startswith("| slam") for line in lines) == 1


def test_a_suite_that_breaks_is_a_chapter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(suite: str, plan: Plan) -> list[Measured]:
        raise RuntimeError("no such luck")

    monkeypatch.setattr("benchmarks.chapters.measure_suite", broken)
    monkeypatch.setattr("benchmarks.chapters.machine", lambda: ["- a machine"])
    report = Report(tmp_path / "report.md")
    report.add("slam", Plan())
    text = (tmp_path / "report.md").read_text()
    assert "## slam\n\nBroke off: RuntimeError: no such luck\n" in text
    assert text.startswith("# Benchmark report\n\n- a machine\n")


def test_pictures_are_drawn_of_what_there_is(tmp_path: Path, measured: list[Measured]) -> None:
    require("matplotlib")
    assert pictures.bars(tmp_path / "a.png", "slam", measured)
    assert (tmp_path / "a.png").stat().st_size > 1000
    nothing = [Measured(measured[0].case, 1, {"arael": ABSENT})]
    assert not pictures.bars(tmp_path / "b.png", "slam", nothing)
    assert not (tmp_path / "b.png").exists()


def test_the_exponent_of_a_power_law() -> None:
    assert exponent([(n, 3 * n**1.25) for n in (10, 100, 1000)]) == pytest.approx(1.25)


def test_memory_stands_beside_data_and_factor() -> None:
    first = Outcome((0.001,), 70.0, facts={"data": 5_000, "factor": 6_000})
    large = Outcome((0.1,), 70.0 + 50, facts={"data": 1e6, "factor": 3e6})
    shown = bytes_per_observation(large, first, 10_000)
    assert shown == ("5243", "100", "300", "13.1")
    assert bytes_per_observation(first, first, 100) == ("-", "50", "60", "-")
    assert bytes_per_observation(ABSENT, first, 100) == ("-",) * 4
