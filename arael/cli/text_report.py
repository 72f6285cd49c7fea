"""The result of a solve as text or Markdown: what the terminal shows, with cost and time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from arael.cli.questions import lines_of
from arael.io.files import write_whole

if TYPE_CHECKING:
    from arael.cli.solution import Solution
    from arael.result import Result


def write_text_report(
    instance: Any,
    result: Result,
    solution: Solution,
    answers: Sequence[Any],
    scale: str,
    title: str,
    path: str,
    markdown: bool,
) -> None:
    """Write result, solution, report, cost by constraint and timings of a solve.

    Raises
    ------
    AraelError
        E0715 if the file cannot be written; an old file is then unchanged.
    """
    sections = _sections(instance, result, solution, answers, scale)
    lines = list(_markdown(title, sections) if markdown else _plain(title, sections))
    text = "\n".join(lines) + "\n"
    write_whole(path, lambda file: file.write(text.encode()))


def _sections(
    instance: Any, result: Result, solution: Solution, answers: Sequence[Any], scale: str
) -> Iterator[tuple[str, list[str]]]:
    """Title and lines of each section that is not empty."""
    yield "Result", str(result).splitlines()
    found = list(solution.lines())
    if found:
        yield "Solution", found
    yield "Report", str(instance.report(scale)).splitlines()
    if answers:
        yield "Questions", list(lines_of(answers))
    yield "Cost by constraint", str(instance.cost_table()).splitlines()
    phases = result.timing
    width = max((len(name) for name in phases), default=0)
    yield "Time", [f"{name:<{width}}  {seconds:.6f} s" for name, seconds in phases.items()]


def _plain(title: str, sections: Iterator[tuple[str, list[str]]]) -> Iterator[str]:
    yield from (title, "=" * len(title))
    for name, lines in sections:
        yield from ("", name, "-" * len(name))
        yield from lines


def _markdown(title: str, sections: Iterator[tuple[str, list[str]]]) -> Iterator[str]:
    yield f"# {title}"
    for name, lines in sections:
        yield from ("", f"## {name}", "", "```text", *lines, "```")
