"""All systems on one problem, in all their ways, by turns in several rounds."""

from __future__ import annotations

import json
import math
import os
import re
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import environment, pinned
from benchmarks.optimum.cases import Problem, write_solved
from benchmarks.peers.runner import LEFT
from benchmarks.problems import Reference
from benchmarks.systems import OURS, PROGRAMS, Plan, reason

LIMIT, QUICK_LIMIT = 300, 30
"""Iterations that a system may take."""
RUNS, ROUNDS = 5, 1
SLOW = 6.0
"""Seconds of a system in the first round after which it has no second one."""
TIMEOUT, PATIENCE, PATIENCE_AGAIN = 600, 30, 15
"""Seconds for a system, for one of its ways, and for one of its ways from a solved start."""
KEEP = "ARAEL_BENCH_KEEP"
"""Names a folder in which results of peers are kept and found again, to measure arael alone."""
AT_BEST = 1e-6
"""A cost is the best known if it is above it by no more than this part of it."""
NEAR = 1e-3
"""A peer has solved a problem if it ends no further above its best cost than this part of it."""
NOTHING = 1e-12
"""Costs below this part of the cost at the start are those of an exact solution."""


@dataclass
class Ending:
    """What one system in one way came to.

    Attributes
    ----------
    cost : at the end, as the system counts it; NaN where it came to none
    score : cost of the answer by the model in arael
    best : the least cost that any run of this system reached, its own cost function
    costs, counts : cost and attempts at the start and after each iteration
    cpu, wall : seconds to the end, of each run
    times : of each run, seconds of the processor at each of `costs`
    setup : seconds of the processor to read the problem and to build it in the system
    """

    system: str
    way: str
    settings: str
    status: str
    attempts: int
    cost: float
    costs: list[float]
    counts: list[int]
    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    times: list[list[float]] = field(default_factory=list)
    score: float = math.nan
    best: float = math.nan
    setup: float = math.nan

    @property
    def above(self) -> float:
        """How far the end is above the best known cost, as a part of it."""
        if self.costs and self.cost <= self.best + NOTHING * self.costs[0]:
            return 0.0
        return self.cost / self.best - 1

    @property
    def at_best(self) -> bool:
        """Whether the end is at the best known cost."""
        return self.above <= AT_BEST

    @property
    def near(self) -> bool:
        """Whether the problem is solved by what other suites ask."""
        return self.above <= NEAR

    @property
    def to_end(self) -> float:
        """Seconds of the processor until the system says that it is done, the median."""
        return statistics.median(self.cpu) if self.cpu else math.nan

    @property
    def with_setup(self) -> float:
        """The same with set-up."""
        return self.setup + self.to_end

    @property
    def to_end_wall(self) -> float:
        """The same by the clock."""
        return statistics.median(self.wall) if self.wall else math.nan

    def to_best(self) -> tuple[int | None, float]:
        """Attempts and seconds of the processor until the cost is the best known."""
        if not self.costs or math.isnan(self.best):
            return None, math.nan
        enough = self.best * (1 + AT_BEST) + NOTHING * self.costs[0]
        for k, cost in enumerate(self.costs):
            if cost <= enough:
                return self.counts[k], statistics.median(t[k] for t in self.times)
        return None, math.nan


@dataclass
class Solved:
    """All that was found of one problem."""

    problem: Problem
    endings: list[Ending] = field(default_factory=list)
    absent: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    residuals: dict[str, str] = field(default_factory=dict)

    @property
    def ours(self) -> Ending | None:
        """Arael at its defaults."""
        return next((e for e in self.endings if (e.system, e.way) == ("arael", "default")), None)

    @property
    def best(self) -> float:
        """The least cost by the model in arael that any answer has."""
        return min((e.score for e in self.endings if not math.isnan(e.score)), default=math.nan)

    def peers(self) -> list[Ending]:
        """What other systems solved."""
        return [e for e in self.endings if e.system != "arael" and e.near]


def solve_problem(problem: Problem, plan: Plan, folder: Path) -> Solved:
    """Run all systems on a problem, find the best known costs, and score all answers."""
    solved = Solved(problem)
    if not problem.path.exists():
        solved.absent = dict.fromkeys(plan.systems, "the file is not there (see ARAEL_DATA)")
        return solved
    reference = Reference(problem.suite, str(problem.path))
    best: dict[str, float] = {}
    state: dict[str, np.ndarray] | None = None
    slow: set[str] = set()
    for turn in range(1 if plan.quick else ROUNDS):
        for system in plan.systems:
            if system in solved.absent or system in slow:
                continue
            began = time.perf_counter()
            kept = _kept(system, problem, str(turn))
            said = kept or _run(system, problem, problem.path, plan, folder, RUNS, PATIENCE)
            if time.perf_counter() - began > SLOW and system != "arael":
                slow.add(system)
            if "absent" in said:
                solved.absent[system] = said["absent"]
                continue
            solved.versions[system] = said["version"]
            for number, way in enumerate(said["ways"]):
                ending = _merge(solved, system, way, said["setup"])
                _lower(best, system, ending)
                answer, found = folder / f"answer.{number}.npz", None
                if way["runs"] and answer.exists():
                    with np.load(answer) as file:
                        found = {name: np.asarray(file[name]) for name in file.files}
                    way["score"] = reference.cost(found)
                    answer.unlink()
                ending.score = way.get("score", math.nan)
                if found is not None and ending.score == solved.best:
                    state = found
            _keep(said, system, problem, str(turn))
            _tell(solved, system, time.perf_counter() - began)
    again = write_solved(problem, state, folder) if state is not None else None
    for system in plan.systems if again is not None else ():
        if system not in ("arael", *solved.absent):
            said = _kept(system, problem, "solved") or _run(
                system, problem, again, plan, folder, 0, PATIENCE_AGAIN, "1"
            )
            _keep(said, system, problem, "solved")
            for way in said.get("ways", ()):
                if way["costs"]:
                    best[system] = min(best.get(system, math.inf), *way["costs"])
    if "arael" in best:
        # Scenes tie parameters weakly to where a solve starts, and the score of a state knows of
        # no start: there only solves from the same start compare.
        least = solved.best if again is not None else reference.least()
        best["arael"] = min(best["arael"], least)
    for ending in solved.endings:
        ending.best = best.get(ending.system, math.nan)
    return solved


def _place(system: str, problem: Problem, turn: str) -> Path | None:
    folder = os.environ.get(KEEP)
    name = re.sub(r"\W+", "-", f"{problem.name}-{system}-{turn}")
    return Path(folder) / f"{name}.json" if folder and system != "arael" else None


def _kept(system: str, problem: Problem, turn: str) -> dict[str, Any] | None:
    place = _place(system, problem, turn)
    if place is None or not place.exists():
        return None
    found: dict[str, Any] = json.loads(place.read_text(encoding="utf-8"))
    return found


def _keep(said: dict[str, Any], system: str, problem: Problem, turn: str) -> None:
    place = _place(system, problem, turn)
    if place is not None:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(said), encoding="utf-8")


def _lower(best: dict[str, float], system: str, ending: Ending) -> None:
    if not math.isnan(ending.cost):
        best[system] = min(best.get(system, math.inf), ending.cost)


def _merge(solved: Solved, system: str, way: dict[str, Any], setup: float) -> Ending:
    """Add the runs of a way to those of the rounds before."""
    for ending in solved.endings:
        if (ending.system, ending.way) == (system, way["name"]):
            break
    else:
        cost = math.nan if way["cost"] is None else way["cost"]
        names = ("settings", "status", "attempts")
        words = {name: way[name] for name in names}
        ending = Ending(system, way["name"], **words, cost=cost, costs=way["costs"],
                        counts=way["counts"], setup=setup)  # fmt: skip
        solved.endings.append(ending)
    for run in way["runs"]:
        if len(run["times"]) == len(ending.costs):
            ending.cpu.append(run["cpu"])
            ending.wall.append(run["wall"])
            ending.times.append(run["times"])
    return ending


def _run(
    system: str,
    problem: Problem,
    path: Path,
    plan: Plan,
    folder: Path,
    runs: int,
    patience: int,
    first: str = "",
) -> dict[str, Any]:
    """What the first program of a system that has such problems printed."""
    reasons = []
    for program in PROGRAMS[system]:
        python = sys.executable if program in OURS else plan.python
        limit = QUICK_LIMIT if plan.quick else LIMIT
        words = ["optimum", problem.suite, path, runs, limit, folder / "answer"]
        env = environment(
            1,
            PYTHONPATH=str(Path(__file__).parents[2]),
            ARAEL_BENCH_COLUMNS=str(folder),
            ARAEL_BENCH_PEER_PYTHON=plan.python,
            ARAEL_BENCH_PATIENCE=str(patience),
            ARAEL_BENCH_FIRST=first,
        )
        try:
            done = subprocess.run(
                [python, "-m", f"benchmarks.peers.{program}", *(str(w) for w in words)],
                env=env,
                capture_output=True,
                text=True,
                timeout=TIMEOUT,
                check=True,
                preexec_fn=pinned(1),
            )
            said: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
        except subprocess.TimeoutExpired:
            said = {"absent": f"not done in {TIMEOUT} s"}
        except (subprocess.SubprocessError, OSError, ValueError, IndexError) as error:
            said = {"absent": reason(error)}
        if "absent" not in said:
            return said
        reasons.append(said["absent"])
    own = [words for words in reasons if not words.startswith(LEFT)]
    return {"absent": "; ".join(own)}


def _tell(solved: Solved, system: str, seconds: float) -> None:
    found = [e for e in solved.endings if e.system == system]
    words = ", ".join(f"{e.way} {e.attempts}/{1e3 * e.to_end:.1f} ms" for e in found)
    sys.stderr.write(f"  {solved.problem.name}, {system}: {words} [{seconds:.0f} s]\n")
