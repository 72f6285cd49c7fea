"""arael beside its peers: one problem, one start, one cost by which every answer is scored."""

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
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.cases import SUITES, Case, cases
from benchmarks.measure import environment, pinned
from benchmarks.peers.runner import LEFT, AbsentError, missing
from benchmarks.problems import Reference

PEERS = ("rust", "gtsam", "ceres", "g2o")
PROGRAMS = {
    "arael": ("arael_peer",),
    "rust": ("rust_peer",),
    "gtsam": ("gtsam_peer",),
    # What the wheel has no compiled cost functions or edges for, a program of ours has.
    "ceres": ("ceres_program", "ceres_peer"),
    "g2o": ("g2o_program", "g2o_peer"),
}
OURS = ("arael_peer", "rust_peer", "ceres_program", "g2o_program")
"""Programs that run in this interpreter; the others in the one that has the peers' wheels."""
TIMEOUT = 300
RUNS, QUICK_RUNS = 7, 3


@dataclass(frozen=True)
class Outcome:
    """What one system made of one problem; without slopes, `reason` says why there are none.

    `residuals` says what it minimises instead of the model, if it does.
    """

    slopes: tuple[float, ...] = ()
    memory: float = math.nan
    cost: float = math.nan
    iterations: int = 0
    version: str = ""
    settings: str = ""
    reason: str = ""
    facts: Mapping[str, float] = field(default_factory=dict)
    residuals: str = ""

    @property
    def median(self) -> float:
        """Seconds per iteration."""
        return statistics.median(self.slopes) if self.slopes else math.nan


@dataclass(frozen=True)
class Measured:
    """All systems on one problem at a number of threads."""

    case: Case
    threads: int
    found: dict[str, Outcome]

    @property
    def best(self) -> float:
        """The lowest cost any system reached."""
        costs = [o.cost for o in self.found.values() if math.isfinite(o.cost)]
        return min(costs, default=math.nan)


@dataclass(frozen=True)
class Plan:
    """How to measure.

    Attributes
    ----------
    peers : which of `PEERS`, beside arael
    python : the interpreter that has the peers' wheels
    threads : numbers of threads; from the second on only the largest case of a suite is measured
    quick : small problems and few runs: whether everything works, not how fast it is
    sketchers : which peers of the suite `sketch`, beside arael
    """

    peers: tuple[str, ...] = PEERS
    python: str = sys.executable
    threads: tuple[int, ...] = (1,)
    quick: bool = False
    sketchers: tuple[str, ...] = ()
    systems: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "systems", ("arael", *self.peers))


def measure_suite(suite: str, plan: Plan) -> list[Measured]:
    """Measure all systems on all problems of a suite."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for case in cases(suite, Path(folder), plan.quick):
            if not case.path.exists():
                absent = Outcome(reason="the file is not there (ARAEL_DATA names its folder)")
                found.append(Measured(case, 1, dict.fromkeys(plan.systems, absent)))
                continue
            reference = Reference(suite, str(case.path))
            for count in plan.threads:
                if count > 1 and not case.large:
                    continue
                outcomes = {}
                for name in plan.systems:
                    outcomes[name] = run_system(name, case, reference, plan, count, Path(folder))
                found.append(Measured(case, count, outcomes))
    return found


def run_system(
    name: str,
    case: Case,
    reference: Reference | None,
    plan: Plan,
    threads: int,
    folder: Path,
    **env: str,
) -> Outcome:
    """Run one system on one problem; whatever fails is an outcome with a reason.

    Without a reference answers are not scored.
    """
    began = time.perf_counter()
    reasons = []
    for program in PROGRAMS[name]:
        outcome = _run(program, case, reference, plan, threads, folder, env)
        if outcome.slopes:
            break
        reasons.append(outcome.reason)
    else:
        own = [reason for reason in reasons if not reason.startswith(LEFT)]
        outcome = Outcome(reason="; ".join(own), cost=outcome.cost)
    said = f"{1e3 * outcome.median:.2f} ms"
    if math.isfinite(outcome.cost):
        said += f", cost {outcome.cost:.6g}"
    if not outcome.slopes:
        said = f"- {outcome.reason}"
    elapsed = time.perf_counter() - began
    sys.stderr.write(f"  {case.name}, {threads} t, {name}: {said} [{elapsed:.0f} s]\n")
    return outcome


def _run(
    program: str,
    case: Case,
    reference: Reference | None,
    plan: Plan,
    threads: int,
    folder: Path,
    changes: dict[str, str],
) -> Outcome:
    out = folder / "answer.npz"
    python = sys.executable if program in OURS else plan.python
    runs = QUICK_RUNS if plan.quick else RUNS
    numbers = (case.short, case.long, runs, threads, case.limit)
    command = [python, "-m", f"benchmarks.peers.{program}", case.suite, str(case.path)]
    command += [*(str(n) for n in numbers), str(out)]
    root = str(Path(__file__).parents[1])
    env = environment(threads, PYTHONPATH=root, ARAEL_BENCH_COLUMNS=str(folder), **changes)
    env["ARAEL_BENCH_PEER_PYTHON"] = plan.python
    try:
        done = subprocess.run(
            command,
            env=env,
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
            check=True,
            preexec_fn=pinned(threads),
        )
        said = json.loads(done.stdout.strip().splitlines()[-1])
        if "absent" in said:
            return Outcome(reason=said["absent"])
        cost = math.nan
        if reference is not None:
            with np.load(out) as answer:
                cost = reference.cost({name: np.asarray(answer[name]) for name in answer.files})
        if not said["slopes"]:
            return Outcome(reason=f"stopped before {case.long} iterations", cost=cost)
    except subprocess.TimeoutExpired:
        return Outcome(reason=f"not done in {TIMEOUT} s")
    except (subprocess.SubprocessError, OSError, ValueError, IndexError, KeyError) as error:
        return Outcome(reason=reason(error))
    return Outcome(
        tuple(said["slopes"]),
        said["memory"],
        cost,
        said["iterations"],
        said["version"],
        said["settings"],
        facts=said.get("facts", {}),
        residuals=said.get("residuals", ""),
    )


def reason(error: Exception) -> str:
    """Why a program failed: the last line it said; what to install where a wheel is missing."""
    words = (getattr(error, "stderr", None) or str(error)).strip().splitlines()[-1:]
    said = " ".join(words) or type(error).__name__
    found = re.fullmatch(r"ModuleNotFoundError: No module named '(\w+)'", said)
    return missing(found.group(1)) if found else said


def prepare(plan: Plan) -> None:
    """Build the programs of peers before anything is timed; a failed build shows again later."""
    from benchmarks.peers import ceres_program, g2o_program, rust_peer

    os.environ["ARAEL_BENCH_PEER_PYTHON"] = plan.python
    for name, module in (("rust", rust_peer), ("ceres", ceres_program), ("g2o", g2o_program)):
        if name in plan.peers:
            sys.stderr.write(f"building the program for {name} ...\n")
            try:
                module.program()
            except AbsentError as reason:
                sys.stderr.write(f"  {reason}\n")


__all__ = ["PEERS", "SUITES", "Measured", "Outcome", "Plan", "measure_suite", "prepare"]
