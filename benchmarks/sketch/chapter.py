"""The cases, words and tables of the suite `sketch`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.measure import table
from benchmarks.sketch.sketches import make
from benchmarks.sketch.systems import Case, Measured, Outcome, measure, prepare
from benchmarks.systems import Plan

EXPLAINED = """\
One process per system, task and sketch, on one processor with one thread; medians of warm runs
(two do not count), each timed by itself, within two seconds. Systems end by tolerances of their
own (see the list). Whether a system solved is not taken from it: NumPy computes the largest
residual of its answer, as a length, by one formula for all (`benchmarks/sketch/check.py`).

- `chain-N`: rectangles corner to corner, a width and a height each, fully defined, N equations as
  peers count them. Drawn 0.02 off. The width of the first one changes, which moves all others.
- `polygon-128`: 128 lines and 128 circles at the corners, 254 equalities, a length, a radius; 128
  degrees of freedom remain. Its script has 512 commands.
- `plate`: round corners by tangent arcs, five holes, fully defined.
- `links-20`: a chain of 20 links, fixed at one end; the other is dragged 40 frames, out and back.

Ends that meet are one point in ezpz, SolveSpace and planegcs; arael and the Rust framework draw
lines of their own and connect them by coincidences, so they hold twice the numbers. ezpz is called
from Rust, the Rust framework from Rust by its commands (as its console and its agents do); arael,
SolveSpace and planegcs from Python.
"""

TASKS = {
    "resolve": (
        "Solve again after a dimension changed",
        "arael: the method of the dimension's name, with verdict. ezpz keeps nothing between "
        "calls. SolveSpace: the length of a line in its fixed group is set. The Rust framework: "
        "its command, which counts freedoms where that is not known.",
    ),
    "freedom": (
        "Count what is free",
        "ezpz: `solve_analysis`, which lists numbers that can move and counts no freedoms. "
        "SolveSpace: part of a solve. The Rust framework: its count, anew. arael: `dof` after a "
        "dimension changed.",
    ),
    "edit": (
        "Add or delete a constraint",
        "The width of the first rectangle, deleted and added by turns, each with a solve and what "
        "the system has of a verdict.",
    ),
    "redundant": (
        "A redundant constraint",
        "The opposite side of a rectangle is given the same length (chain), or made equal (plate).",
    ),
    "contradicting": ("A contradicting constraint", "The opposite side is given another length."),
    "script": (
        "The script that draws the polygon",
        "Commands one by one, each checked; once.",
    ),
    "drag": (
        "A chain dragged out and back",
        "Time of a frame; the table of distances says how far a point is from where it was before "
        "the drag, when the cursor is back.",
    ),
    "undo": (
        "Random commands, each undone",
        "arael alone: after every undo all numbers and records must be as before, bit by bit.",
    ),
}

CASES = (
    Case("resolve", "chain-98", "0.1"),
    Case("resolve", "chain-503", "0.25"),
    Case("resolve", "chain-2001", "1"),
    Case("resolve", "chain-10009", "6"),
    Case("resolve", "plate"),
    Case("resolve", "polygon-128"),
    Case("freedom", "chain-503", "3"),
    Case("freedom", "chain-10009", "60"),
    Case("freedom", "polygon-128", "10"),
    Case("edit", "chain-503", "5"),
    Case("redundant", "chain-98"),
    Case("redundant", "plate"),
    Case("contradicting", "chain-98"),
    Case("contradicting", "plate"),
    Case("script", "polygon-128", "1000"),
    Case("drag", "links-20", "back within 1e-9"),
    Case("undo", "plate", "all bit-identical"),
)
QUICK = tuple(
    Case(task, {"script": "polygon-8", "drag": "links-5", "undo": "plate"}.get(task, "chain-20"))
    for task in TASKS
)


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Lines of the chapter."""
    prepare(plan)
    return report(measure(QUICK if plan.quick else CASES, plan))


def report(measured: Sequence[Measured]) -> list[str]:
    """Lines about what was measured."""
    names = list(measured[0].found)
    lines = ["## sketch", "", EXPLAINED, *_systems(measured), "", *_sizes(measured)]
    for task, (title, words) in TASKS.items():
        same = [m for m in measured if m.case.task == task]
        if not same:
            continue
        head = ["sketch", *names]
        rows = _rows(same, lambda o, _: _time(o))
        if any(m.case.aim for m in same):
            head.append("wanted")
            rows = [[*row, m.case.aim] for row, m in zip(rows, same, strict=True)]
        lines += ["", f"### {title}", "", words, "", "Milliseconds, median (min-max):", ""]
        lines += table(head, rows)
        if any(m.found["arael"].times for m in same) and len(names) > 1:
            lines += ["", "Relative to arael's:", ""]
            lines += table(["sketch", *names], _rows(same, _ratio))
        if any(o.times for m in same for o in m.found.values()):
            lines += ["", "Largest residual of the answer, by NumPy, as a length:", ""]
            lines += table(["sketch", *names], _rows(same, lambda o, _: _small(o.residual)))
        if task == "drag":
            lines += ["", "Largest distance of a point from where it was:", ""]
            lines += table(["sketch", *names], _rows(same, lambda o, _: _small(o.moved)))
        if task == "freedom":
            lines += ["", "Degrees of freedom counted:", ""]
            lines += table(["sketch", *names, "are"], _counts(same))
        lines += _said(same)
    return lines + _reasons(measured)


def _rows(
    measured: Sequence[Measured], show: Callable[[Outcome, Measured], str]
) -> list[list[str]]:
    return [[m.case.sketch, *(show(o, m) for o in m.found.values())] for m in measured]


def _counts(measured: Sequence[Measured]) -> list[list[str]]:
    shown = _rows(measured, lambda o, _: "-" if o.freedoms is None else str(o.freedoms))
    return [
        [*row, str(make(m.case.sketch).freedoms)] for row, m in zip(shown, measured, strict=True)
    ]


def _systems(measured: Sequence[Measured]) -> list[str]:
    found = {
        o.version: o.settings
        for m in measured
        for o in m.found.values()
        if o.version and o.settings
    }
    return [f"- {version}: {settings}" for version, settings in found.items()]


def _sizes(measured: Sequence[Measured]) -> list[str]:
    rows = []
    for name in dict.fromkeys(m.case.sketch for m in measured):
        s = make(name)
        counts = (s.equations, s.unknowns, s.freedoms, len(s.lines), len(s.circles), len(s.arcs))
        rows.append([name, *(str(n) for n in counts)])
    heads = ("sketch", "equations", "numbers", "freedoms", "lines", "circles", "arcs")
    return table(heads, rows)


def _said(measured: Sequence[Measured]) -> list[str]:
    """The systems' words, where they are what matters."""
    if measured[0].case.task in ("resolve", "drag"):
        return []
    lines = [
        f"- {m.case.sketch}, {name}: {_line(o.said)}"
        for m in measured
        for name, o in m.found.items()
        if o.times and o.said
    ]
    return ["", "In the systems' words:", "", *lines] if lines else []


def _reasons(measured: Sequence[Measured]) -> list[str]:
    cases: dict[tuple[str, str], list[str]] = {}
    for m in measured:
        for name, o in m.found.items():
            if not o.times:
                cases.setdefault((name, o.reason), []).append(f"{m.case.task} {m.case.sketch}")
    lines = [f"- {name}: {', '.join(which)}: {_line(why)}" for (name, why), which in cases.items()]
    return ["", "### Not measured", "", *lines] if lines else []


def _line(words: str) -> str:
    """Words on one line, not as long as a table of a system might be."""
    flat = " ".join(words.split()).replace("|", "/")
    return flat if len(flat) <= 300 else f"{flat[:300]} ..."


def _time(o: Outcome) -> str:
    if not o.times:
        return "-"
    if len(o.times) == 1:
        return f"{1e3 * o.median:.3g}"
    low, high = 1e3 * min(o.times), 1e3 * max(o.times)
    return f"{1e3 * o.median:.3g} ({low:.3g}-{high:.3g})"


def _ratio(o: Outcome, among: Measured) -> str:
    ours = among.found["arael"].median
    return f"{o.median / ours:.1f}" if ours > 0 and o.times else "-"


def _small(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.1e}"
