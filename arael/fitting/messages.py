"""Errors of `arael.fit`."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest


def mistake(code: str, message: str, origin: str, help: str = "") -> AraelError:
    """An error with its place and, if known, the remedy."""
    return AraelError(Diagnostic(code, message, origin=origin, help=(help,) if help else ()))


def check_parameter(name: str, parameters: tuple[str, ...], where: str) -> None:
    """Raise E0872 for a name that is not a parameter of the formula."""
    if not isinstance(name, str) or name not in parameters:
        near = closest(str(name), parameters)
        raise mistake(
            "E0872",
            f"'{name}' is not a parameter of the formula; it has {', '.join(parameters)}",
            where,
            f"did you mean '{near[0]}'?" if near else "",
        )
