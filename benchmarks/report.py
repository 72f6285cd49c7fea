"""The words and tables of the suites in which arael stands beside its peers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from benchmarks.measure import table
from benchmarks.systems import Measured, Outcome

OTHER = "~"
"""Mark of a ratio to a system that minimises something else than the model."""
CLOSE = 1e-3
"""Answers whose cost is more than this above the best, relatively, are marked."""


def suite_report(suite: str, measured: Sequence[Measured], picture: str | None) -> list[str]:
    """Lines of a suite's chapter; `picture` is the file's name beside the report."""
    if not measured:
        return [f"## {suite}", "", "No problem of this suite was found (set `ARAEL_DATA`)."]
    names = list(measured[0].found)
    heads = [suite, *names]
    lines = [
        f"## {suite}",
        "",
        *_systems(measured),
        "",
        "Milliseconds per iteration, median (min-max) of the slopes:",
        "",
        *table(heads, _rows(measured, lambda o, _: _time(o))),
        "",
        "Time per iteration relative to arael's:",
        "",
        *table(heads, _rows(measured, _ratio)),
        *_others(o for m in measured for o in m.found.values()),
        "",
        "Cost of the answer by the reference, and iterations to it; `!` more than 0.1 % above the "
        "best:",
        "",
        *table(heads, _rows(measured, _cost)),
        "",
        "Peak resident memory of the process, MB:",
        "",
        *table(heads, _rows(measured, lambda o, _: _number(o.memory, 0))),
    ]
    reasons = _reasons(measured)
    if reasons:
        lines += ["", "Not measured:", "", *reasons]
    if picture:
        lines += ["", f"![{suite}]({picture})"]
    return lines


def summary(measured: dict[str, list[Measured]]) -> list[str]:
    """Lines of the table of all ratios, at one thread."""
    all_cases = [m for found in measured.values() for m in found if m.threads == 1]
    if not all_cases:
        return []
    names = [name for name in all_cases[0].found if name != "arael"]
    rows = []
    for m in all_cases:
        ours = m.found["arael"]
        rows.append(
            [f"{m.case.suite}: {m.case.name}", _number(1e3 * ours.median, 2)]
            + [_ratio(m.found[name], m) for name in names]
        )
    return [
        "## Summary",
        "",
        "Time per iteration at one thread, f64: arael in ms, and how many times that a peer takes.",
        "",
        *table(["problem", "arael [ms]", *names], rows),
        *_others(o for m in all_cases for o in m.found.values()),
    ]


def _rows(
    measured: Sequence[Measured], show: Callable[[Outcome, Measured], str]
) -> list[list[str]]:
    rows = []
    for m in measured:
        rows.append([_label(m), *(show(o, m) for o in m.found.values())])
    return rows


def _systems(measured: Sequence[Measured]) -> list[str]:
    found: dict[str, list[str]] = {}
    for m in measured:
        for outcome in m.found.values():
            if outcome.version:
                known = found.setdefault(outcome.version, [])
                for words in (outcome.settings, outcome.residuals):
                    if words not in known:
                        known.append(words)
    return [f"- {version}: {'; '.join(s for s in said if s)}" for version, said in found.items()]


def _others(outcomes: Iterable[Outcome]) -> list[str]:
    """What the mark at a ratio means, where there is one."""
    if not any(outcome.slopes and outcome.residuals for outcome in outcomes):
        return []
    return [
        "",
        f"`{OTHER}`: with residuals of its own, near the model's (see the list of systems)",
    ]


def _reasons(measured: Sequence[Measured]) -> list[str]:
    """Who did not solve what, and why; systems and problems with the same reasons together."""
    cases: dict[tuple[str, str], list[str]] = {}
    for m in measured:
        for name, outcome in m.found.items():
            if not outcome.slopes:
                cases.setdefault((name, outcome.reason), []).append(_label(m))
    names: dict[tuple[str, str], list[str]] = {}
    for (name, why), shown in cases.items():
        names.setdefault((", ".join(shown), why), []).append(name)
    return [f"- {', '.join(n)}: {shown}: {why}" for (shown, why), n in names.items()]


def _label(m: Measured) -> str:
    return m.case.name if m.threads == 1 else f"{m.case.name}, {m.threads} threads"


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def _time(outcome: Outcome) -> str:
    if not outcome.slopes:
        return "-"
    low, high = 1e3 * min(outcome.slopes), 1e3 * max(outcome.slopes)
    return f"{1e3 * outcome.median:.2f} ({low:.2f}-{high:.2f})"


def _ratio(outcome: Outcome, among: Measured) -> str:
    ours = among.found["arael"].median
    if not (ours > 0 and outcome.slopes):
        return "-"
    mark = f" {OTHER}" if outcome.residuals else ""
    return _number(outcome.median / ours, 1) + mark


def _cost(outcome: Outcome, among: Measured) -> str:
    if not math.isfinite(outcome.cost):
        return "-"
    mark = " !" if outcome.cost > among.best * (1 + CLOSE) else ""
    return f"{outcome.cost:.6g}{mark} ({outcome.iterations})"
