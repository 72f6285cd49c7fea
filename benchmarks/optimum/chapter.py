"""The words and tables of the suite `optimum`."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import demo_seeds
from benchmarks.measure import table
from benchmarks.optimum.cases import all_problems
from benchmarks.optimum.solving import AT_BEST, NEAR, Ending, Solved, solve_problem
from benchmarks.systems import Plan

MORE, HALF = 1.25, 0.5
"""What is aimed for: attempts and time to the end, as parts of those of the best peer."""
EXPLAINED = """\
Every system starts from the values in the file and solves in each of its documented ways, on one
processor, to its own end: default tolerances, at most 300 iterations; a way that is not done in 10
to 15 s is given up. arael does what `arael solve` does (`--init auto`; of the generated scenes the
last pass, which is the whole problem).

- **What counts.** Seconds of the processor from the problem built in the system to the end of the
  solve: start values (initialisation), numbering of the unknowns, block pattern, ordering, symbolic
  analysis, steps and end, for every system. Nothing that a solve computed is kept for the next;
  imports and first allocations do not count, for no system. Peers put start values back and solve
  the same objects again, which leaves program and data in the processor's caches; of arael all is
  read and built again, and before a solve of less than 30 ms two copies are solved, so that
  it finds the caches likewise. Every system reads the same clock, the
  processor's, at the end, and the peers at each attempt; when an attempt of arael ended follows
  from the seconds it records itself, as a callback in Python takes as long as a small step. `by the
  clock` includes what other processes of the machine took meanwhile. Times are medians of all runs
  in two rounds by turns.
- **Set-up** is apart: to read the file and to build the problem in the system, where peers add
  their factors, edges or residual blocks and arael lays out the rows of its tables for the kernels
  (`model.prepare(analyse=False)`). As that call also numbers the unknowns and computes block
  pattern and scatter offsets, which peers do in their solve, arael does both once more within the
  clock; no part of its linear solver is in set-up. `set-up` and the sums `with set-up` are beside
  the times of every system. They compare less well than times to the end: set-up is measured once,
  first allocations included; programs in C++ and Rust read columns, all others, and arael, the
  text of the file.
- **Attempts** at a step, rejected ones counted; of Gauss-Newton and dogleg in GTSAM, and of
  dogleg in g2o, iterations. The step that arael may take at its end, without a linearisation and a
  factorisation, belongs to the attempt before.
- **Best known.** Systems weigh errors of rotation differently, so each is measured by its own cost:
  the best known is the least that any of its runs reached, one that starts from the best answer of
  all systems included (graphs and bundles). `above` is how far the end lies above it; `to best`
  is when it is within 1e-6. `cost` is that of the answer by arael's model, so it differs from the
  best where a system minimises something else.
- **Best peer**: the fewest attempts and the least time to the end of any peer in any way that ends
  within 0.1 % of its best known cost, whether or not it is within 1e-6, in favour of the peers."""


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure all problems; return the chapter."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for problem in all_problems(Path(folder), plan.quick):
            found.append(solve_problem(problem, plan, Path(folder)))
            if picture is not None:  # this takes long: what is there can be read
                part = picture.with_suffix(".md")
                part.write_text("\n".join(chapter(found)) + "\n", encoding="utf-8")
    if picture is not None:
        picture.with_suffix(".md").unlink(missing_ok=True)
    return [*chapter(found), "", *demo_seeds.run(plan, None)]


def chapter(found: Sequence[Solved]) -> list[str]:
    """Lines of the chapter."""
    lines = ["## optimum", "", EXPLAINED, "", *_versions(found), "", "### Summary", ""]
    lines += [*summary(found), "", "### Problem by problem"]
    for solved in found:
        lines += ["", *_problem(solved)]
    return lines


def summary(found: Sequence[Solved]) -> list[str]:
    """A row a problem, and what is aimed for beside what was found."""
    rows = []
    best = fewer = half = above = counted = sooner = reachable = alone = 0
    late: list[str] = []
    for solved in found:
        ours, peers = solved.ours, solved.peers()
        if ours is None:
            continue
        ended = ours.at_best and ours.status.startswith("converged")
        best += ended
        end = "yes" if ended else f"no: {_above(ours)}, {ours.status.split(',')[0]}"
        sums = f"{_ms(ours.setup)} / {_ms(ours.with_setup)}"
        row: list[object] = [solved.problem.name, end, ours.attempts, _ms(ours.to_end)]
        if peers:
            counted += 1
            few = min(peers, key=lambda e: e.attempts)
            fast = min(peers, key=lambda e: e.to_end)
            ratio = ours.to_end / fast.to_end
            fewer += ours.attempts <= MORE * few.attempts
            half += ratio <= HALF
            above += ratio > 1
            if ratio > HALF:
                late.append(f"{solved.problem.name} {ratio:.2f}")
            mark = "" if ours.attempts <= MORE * few.attempts else " !"
            row += [f"{few.attempts}{mark} ({few.system} {few.way})"]
            row += [f"{_ms(fast.to_end)} ({fast.system} {fast.way})"]
            row += [f"{ratio:.2f}" + ("" if ratio <= HALF else " !" if ratio <= 1 else " !!")]
            reached = [e.to_best() for e in peers if e.to_best()[0] is not None]
            least = min((attempts for attempts, _ in reached if attempts is not None), default=None)
            soon = min((seconds for _, seconds in reached), default=math.nan)
            mine = ours.to_best()[0]
            if least is not None:
                reachable += 1
                sooner += mine is not None and mine <= MORE * least
            row.append(f"{_count(mine)} / {_count(least)}")
            row.append(f"{_ms(ours.to_best()[1])} / {_ms(soon)}")
            row += [sums, f"{_ms(fast.setup)} / {_ms(fast.with_setup)}"]
        else:
            alone += ended
            mine = ours.to_best()[0]
            row += ["-", "-", "-", f"{_count(mine)} / -", f"{_ms(ours.to_best()[1])} / -"]
            row += [sums, "-"]
        rows.append(row)
    total = len(rows)
    head = ["problem", "at the best known cost", "attempts", "ms to the end", "fewest attempts"]
    head += ["least ms to the end", "ratio of time", "attempts to best, arael / peer"]
    head += ["ms to best, arael / peer", "ms of set-up / with set-up, arael"]
    head += ["the same of the peer that ends first"]
    lines = table(head, rows)
    lines += [
        "",
        f"- converged, and at the best known cost (within {AT_BEST:g}): {best} of {total}",
        f"- attempts at most those of the best peer plus a quarter: {fewer} of {counted}",
        f"- attempts to within {AT_BEST:g} of the best known cost, at most those of the best peer "
        f"plus a quarter: {sooner} of {reachable}",
        f"- time to the end at most half of the best peer's: {half} of {counted}; "
        f"above the best peer's: {above}",
    ]
    if alone:
        lines.append(
            f"- only arael ends there on {alone}; with these, attempts as wanted on "
            f"{fewer + alone} of {total}, time on {half + alone} of {total}"
        )
    if late:
        lines.append(f"- ratios above {HALF:g}: {', '.join(late)}")
    return lines


def _problem(solved: Solved) -> list[str]:
    rows = []
    for e in solved.endings:
        attempts, seconds = e.to_best()
        rows.append(
            [
                f"{e.system} {e.way}",
                e.attempts if e.cpu else "-",
                e.status,
                _cost(e.score),
                _above(e) if e.cpu else "-",
                "-" if attempts is None else attempts,
                _ms(seconds),
                _ms(e.to_end),
                _ms(e.to_end_wall),
                _ms(e.setup),
                _ms(e.with_setup),
            ]
        )
    head = ["way", "attempts", "end", "cost", "above", "attempts to best", "ms to best"]
    head += ["ms to the end", "by the clock", "set-up", "with set-up"]
    lines = [f"#### {solved.problem.name}", ""]
    if rows:
        lines += table(head, rows)
    if solved.absent:
        lines += ["", *(f"- {name}: {why}" for name, why in solved.absent.items())]
    return lines


def _versions(found: Sequence[Solved]) -> list[str]:
    known: dict[str, dict[str, str]] = {}
    for solved in found:
        for e in solved.endings:
            known.setdefault(solved.versions[e.system], {})[e.way] = e.settings
    return [
        f"- {version}: " + "; ".join(f"{way}: {words}" for way, words in ways.items())
        for version, ways in known.items()
    ]


def _above(ending: Ending) -> str:
    """How far above the best known cost, in words."""
    if math.isnan(ending.above):
        return "-"
    if ending.at_best:
        return "at best"
    return f"{100 * ending.above:.2g} %" if ending.above < 1 else f"{ending.above + 1:.3g} times"


def _cost(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.8g}"


def _count(attempts: int | None) -> str:
    return "-" if attempts is None else str(attempts)


def _ms(seconds: float) -> str:
    if math.isnan(seconds):
        return "-"
    ms = 1e3 * seconds
    return f"{ms:.2f}" if ms < 10 else f"{ms:.1f}" if ms < 100 else f"{ms:.0f}"


__all__ = ["NEAR", "chapter", "run", "summary"]
