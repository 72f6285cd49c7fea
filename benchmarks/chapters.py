"""The chapters of a report: which suites there are, and the file that grows by them."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from benchmarks import (
    backends,
    certified,
    clocks,
    cold,
    components,
    demo_seeds,
    fit,
    kernels,
    online,
    optimum,
    parts,
    pictures,
    runtime_residuals,
    scale,
    scale_out,
    schur,
    small,
    strategies,
    threads,
)
from benchmarks.constrained import chapter as constrained
from benchmarks.export import chapter as exported
from benchmarks.measure import machine
from benchmarks.report import suite_report, summary
from benchmarks.sketch import chapter as sketch
from benchmarks.sketch import frames
from benchmarks.systems import SUITES as BESIDE
from benchmarks.systems import Measured, Plan, measure_suite

Chapter = Callable[[Plan, Path | None], list[str]]
"""Lines of a suite, given the plan and where its picture may go."""

OWN: dict[str, Chapter] = {
    "fit": fit.run,
    "components": components.run,
    "backends": backends.run,
    "kernels": lambda plan, picture: kernels.run(),
    "schur": lambda plan, picture: schur.run(plan),
    "residuals": runtime_residuals.run,
    "small": small.run,
    "threads": threads.run,
    "scale": scale.run,
    "scale-out": scale_out.run,
    "strategies": strategies.run,
    "nist": certified.run,
    "cold": cold.run,
    "optimum": optimum.run,
    "sketch": sketch.run,
    "sketch-frames": frames.run,
    "export": exported.run,
    "demo-seeds": demo_seeds.run,
    "parts": parts.run,
    "time": clocks.run,
    "online": online.run,
    "constrained": constrained.run,
}
SUITES = (*BESIDE, *OWN)


class Report:
    """A Markdown report; written anew after every suite, so that an interruption keeps the rest."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.chapters: list[list[str]] = []
        self.measured: dict[str, list[Measured]] = {}

    def add(self, name: str, plan: Plan) -> None:
        """Run a suite; one that breaks is a chapter that says so."""
        picture = self.path.with_name(f"{self.path.stem}-{name}.png") if self.path else None
        try:
            if name in BESIDE:
                lines = self._beside(name, plan, picture)
            else:
                lines = OWN[name](plan, picture)
        except Exception as error:  # one suite must not cost the others
            sys.stderr.write(traceback.format_exc())
            lines = [f"## {name}", "", f"Broke off: {type(error).__name__}: {error}"]
        self.chapters.append(lines)
        if self.path:
            self.path.write_text(self.text(), encoding="utf-8")

    def _beside(self, name: str, plan: Plan, picture: Path | None) -> list[str]:
        found = measure_suite(name, plan)
        self.measured[name] = found
        drawn = picture is not None and pictures.bars(picture, name, found)
        return suite_report(name, found, picture.name if drawn and picture else None)

    def text(self) -> str:
        """The report so far."""
        lines = ["# Benchmark report", "", *machine()]
        table = summary(self.measured)
        for part in ([table] if table else []) + self.chapters:
            lines += ["", *part]
        return "\n".join(lines) + "\n"
