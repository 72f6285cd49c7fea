"""One process per system, task and sketch; each answer checked by one formula."""

from __future__ import annotations

import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.measure import environment, pinned
from benchmarks.peers import native, rust_peer
from benchmarks.peers.runner import AbsentError
from benchmarks.sketch import check, sketches, writing
from benchmarks.systems import Plan, reason

PEERS = ("ezpz", "rust", "slvs", "planegcs")
PROJECT = Path(__file__).parent / "rust"
CRATES = {"ezpz": ("ezpz", "ezpz"), "rust": ("Rust framework", "arael-sketch-backend")}
BUDGET, QUICK_BUDGET = 2.0, 0.1
TIMEOUT = 240
"""Seconds for a process: what takes longer is reported as that."""
KEEP = "ARAEL_BENCH_KEEP"


@dataclass(frozen=True)
class Case:
    """A task on a sketch; `aim` are the milliseconds that the design wants, or their words."""

    task: str
    sketch: str
    aim: str = ""


@dataclass(frozen=True)
class Outcome:
    """What a system made of a case; without times, `reason` says why there are none.

    Attributes
    ----------
    times : seconds of the runs
    residual : largest residual of the answer, by `check`; as a length
    moved : largest distance of a point from where it was drawn
    said : the system's own words
    """

    times: tuple[float, ...] = ()
    residual: float = math.nan
    moved: float = math.nan
    said: str = ""
    freedoms: int | None = None
    version: str = ""
    settings: str = ""
    reason: str = ""

    @property
    def median(self) -> float:
        """Seconds of the middle run."""
        return statistics.median(self.times) if self.times else math.nan


@dataclass
class Measured:
    """All systems on one case."""

    case: Case
    found: dict[str, Outcome] = field(default_factory=dict)


def measure(cases: Sequence[Case], plan: Plan) -> list[Measured]:
    """Measure every case in every system."""
    measured = []
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            one = Measured(case)
            for system in ("arael", *plan.sketchers):
                began = time.perf_counter()
                one.found[system] = run(system, case, plan, Path(folder))
                said = f"{1e3 * one.found[system].median:.3g} ms"
                if not one.found[system].times:
                    said = f"- {one.found[system].reason}"
                spent = time.perf_counter() - began
                sys.stderr.write(f"  {case.task} {case.sketch}, {system}: {said} [{spent:.0f} s]\n")
            measured.append(one)
    return measured


def run(system: str, case: Case, plan: Plan, folder: Path) -> Outcome:
    """Run one case in one system; what fails is an outcome with a reason."""
    said = _kept(system, case)
    try:
        if said is None:
            said = _said(system, case, plan, folder)
    except AbsentError as why:
        return Outcome(reason=str(why))
    except subprocess.TimeoutExpired:
        said = {"absent": f"not done in {TIMEOUT} s"}
    except (subprocess.SubprocessError, OSError, ValueError, IndexError) as error:
        return Outcome(reason=reason(error))
    _keep(said, system, case)
    return outcome(sketches.make(case.sketch), case.task, said)


def outcome(sketch: sketches.Sketch, task: str, said: Mapping[str, Any]) -> Outcome:
    """What a system's report comes to; its answer is checked here."""
    if "absent" in said:
        return Outcome(reason=said["absent"])
    found = check.state(sketch, said["answer"])
    rules: tuple[sketches.Rule, ...] = sketch.rules
    if task == "resolve":
        rules = sketch.with_target(sketch.targets[1])
    return Outcome(
        tuple(said["times"]),
        check.largest(sketch, found, rules),
        check.moved(sketch.points, found.points),
        said["said"],
        said.get("freedoms"),
        said.get("version", ""),
        said["settings"],
    )


def _said(system: str, case: Case, plan: Plan, folder: Path) -> dict[str, Any]:
    budget = str(QUICK_BUDGET if plan.quick else BUDGET)
    if system in CRATES:
        path = folder / f"{case.sketch}.sketch"
        if not path.exists():
            lines = writing.lines(sketches.make(case.sketch))
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        command = [str(program()), system, case.task, str(path), budget]
    else:
        module = "ours" if system == "arael" else f"{system}_peer"
        python = sys.executable if system == "arael" else plan.python
        command = [python, "-m", f"benchmarks.sketch.{module}", case.task, case.sketch, budget]
    done = subprocess.run(
        command,
        env=environment(1, PYTHONPATH=str(Path(__file__).parents[2])),
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=True,
        preexec_fn=pinned(1),
    )
    said: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    if system in CRATES:
        name, crate = CRATES[system]
        said["version"] = f"{name} {rust_peer.locked(PROJECT, crate)}"
    return said


def program() -> Path:
    """The program that drives the two crates, built where that is not yet done."""
    return rust_peer.built(PROJECT, "sketch", "sketch-peer")


def prepare(plan: Plan) -> None:
    """Build what has to be built before anything is timed."""
    if any(name in CRATES for name in plan.sketchers):
        sys.stderr.write(f"building the program for ezpz and rust (in {native.BUILD}) ...\n")
        try:
            program()
        except AbsentError as why:
            sys.stderr.write(f"  {why}\n")


def _place(system: str, case: Case) -> Path | None:
    folder = os.environ.get(KEEP)
    name = re.sub(r"\W+", "-", f"sketch-{case.task}-{case.sketch}-{system}")
    return Path(folder) / f"{name}.json" if folder and system != "arael" else None


def _kept(system: str, case: Case) -> dict[str, Any] | None:
    place = _place(system, case)
    if place is None or not place.exists():
        return None
    found: dict[str, Any] = json.loads(place.read_text(encoding="utf-8"))
    return found


def _keep(said: Mapping[str, Any], system: str, case: Case) -> None:
    place = _place(system, case)
    if place is not None:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(said), encoding="utf-8")
