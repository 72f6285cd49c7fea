"""Questions to a solution on the command line: sensitivities, uncertain data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import click

from arael.cli.summary import plain
from arael.diagnostics.records import AraelError, Diagnostic

F = TypeVar("F", bound=Callable[..., Any])


def question_options(function: F) -> F:
    """Add ``--sensitivity``, ``--uncertain``, ``--certify`` and ``--escape``."""
    for option in (
        click.option(
            "--escape",
            is_flag=True,
            help="Leave a minimum that is not certified, and solve again.",
        ),
        click.option(
            "--certify", is_flag=True, help="Whether this is the global optimum of a pose graph."
        ),
        click.option(
            "--uncertain",
            multiple=True,
            metavar="PATH=SIGMA",
            help="Standard errors with this error of data, a constant or a fixed parameter too.",
        ),
        click.option(
            "--sensitivity",
            multiple=True,
            metavar="NAME",
            help="What a solved scalar or a formula depends on, and which observations decide it.",
        ),
    ):
        function = option(function)
    return function


@dataclass(frozen=True)
class Questions:
    """What is asked of a solution.

    Attributes
    ----------
    sensitivity : scalars or formulas
    uncertain : standard deviations by path
    certify : whether a certificate of the global optimum is asked for
    """

    sensitivity: tuple[str, ...] = ()
    uncertain: dict[str, float] = field(default_factory=dict)
    certify: bool = False

    @classmethod
    def of(
        cls, sensitivity: Sequence[str], uncertain: Sequence[str], certify: bool = False
    ) -> Questions:
        """Read the options.

        Raises
        ------
        AraelError
            E0852: what is not PATH=SIGMA.
        """
        read = {}
        for text in uncertain:
            path, _, number = text.partition("=")
            try:
                read[path.strip()] = float(number)
            except ValueError:
                read[path.strip()] = math.nan
            if not math.isfinite(read[path.strip()]) or read[path.strip()] < 0:
                raise AraelError(
                    Diagnostic(
                        "E0852",
                        "expected PATH=SIGMA",
                        origin=f"--uncertain {text}",
                        help=("for instance --uncertain board.square=1e-3",),
                    )
                )
        return cls(tuple(sensitivity), read, certify)

    def answers(self, result: Any, scale: str) -> list[Any]:
        """What the result says: objects with text, a sheet, and plain data."""
        found: list[Any] = [result.certificate] if self.certify else []
        for name in self.sensitivity:
            found.append(result.sensitivity(name))
            if len(found[-1].names) == 1:
                found.append(result.influence(name, scale))
        if self.uncertain:
            found.append(result.propagate(self.uncertain))
        return found


def lines_of(answers: Sequence[Any]) -> Iterator[str]:
    """The answers as text."""
    for one in answers:
        yield from getattr(one, "sentence", str(one)).splitlines()


def as_dict(answers: Sequence[Any]) -> dict[str, Any]:
    """The answers as plain data for JSON, by kind."""
    found: dict[str, Any] = {}
    for one in answers:
        found.setdefault(type(one).__name__.lower(), []).append(plain(one.to_dict()))
    return found


def tables_of(answers: Sequence[Any]) -> Iterator[tuple[str, Sequence[str], Sequence[Any]]]:
    """Title, head and rows of each answer."""
    for one in answers:
        sheet = one._sheet()
        yield sheet.title, sheet.head, sheet.rows
