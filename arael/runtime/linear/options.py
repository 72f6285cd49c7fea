"""Names of the linear solvers and their options, and their validation."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest

_BANDS = ("half_bandwidth", "block_half_bandwidth")

#: Solvers by name, with their options.
SOLVERS: dict[str, tuple[str, ...]] = {
    "auto": ("ordering", "eliminate"),
    "dense": (),
    "band": _BANDS,
    "sparse": ("ordering",),
    "schur": ("eliminate", "reduced", "ordering"),
    "schur_pcg": (
        "eliminate",
        "formed",
        "preconditioner",
        "tolerance",
        "floor",
        "iterations",
    ),
    "cholmod": (),
    "lapack_band": _BANDS,
}

_NAMES = ("ordering", "reduced", "preconditioner")


def typed_options(name: Any, options: Any) -> dict[str, Any]:
    """Convert the caller's options to a dict of values of the right types.

    Raises
    ------
    AraelError
        E0840 if `name` is not a string, E0842 if `options` is not a mapping by name or a value has
        the wrong type.
    """
    if not isinstance(name, str):
        raise _unknown(name)
    if options is None:
        return {}
    if not isinstance(options, Mapping) or not all(isinstance(key, str) for key in options):
        raise _impossible("solver_options", 'a dict by name, as {"ordering": "natural"}', options)
    found = dict(options)
    for option, value in options.items():
        if option in ("tolerance", "floor") and not _is(value, numbers.Real):
            raise _impossible(option, "a number between 0 and 1", value)
        if option == "iterations" and not _is(value, numbers.Integral):
            raise _impossible(option, "a whole number from 1", value)
        if option in _BANDS and value is not None and not _is(value, numbers.Integral):
            raise _impossible(option, "a whole number from 0, or None", value)
        if option in _NAMES and not isinstance(value, str):
            raise _impossible(option, "the name of one", value)
        if option == "formed" and not isinstance(value, str | bool):
            raise _impossible(option, "'auto', True or False", value)
        if option == "eliminate" and not isinstance(value, str):
            found[option] = _rows(value)
    return found


def _rows(value: Any) -> list[Any]:
    """Names of collections or numbers of block rows, as a list."""
    rows = list(value) if isinstance(value, Iterable) else [value]
    named = all(isinstance(row, str) for row in rows)
    if not isinstance(value, Iterable) or not (
        named or all(_is(row, numbers.Integral) for row in rows)
    ):
        raise _impossible("eliminate", "'auto', names of collections, or block rows", value)
    return rows if named else [int(row) for row in rows]


def _is(value: Any, kind: type) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def check_options(name: str, options: dict[str, Any]) -> None:
    """Raise E0840 for an unknown solver, E0842 for an unknown option or an invalid value."""
    if name not in SOLVERS:
        raise _unknown(name)
    if not options:
        return
    # Imported here for start-up time: a solve of a small problem does not load the analysis.
    from arael.runtime.linear.analysis import ORDERINGS
    from arael.runtime.linear.iterative import PRECONDITIONERS
    from arael.runtime.linear.reduced import INNER

    for option in options:
        if option not in SOLVERS[name]:
            near = closest(option, SOLVERS[name])
            takes = ", ".join(SOLVERS[name]) or "no options"
            raise AraelError(
                Diagnostic(
                    "E0842",
                    f"the solver {name!r} has no option {option!r}",
                    origin="solver options",
                    notes=(f"{name!r} takes {takes}",),
                    help=(f"did you mean {near[0]!r}?",) if near else (),
                )
            )
    _one_of("ordering", options.get("ordering", "auto"), ("auto", *ORDERINGS))
    _one_of("reduced", options.get("reduced", "auto"), ("auto", *INNER))
    _one_of("preconditioner", options.get("preconditioner", "cluster"), PRECONDITIONERS)
    if isinstance(options.get("eliminate"), str):
        _one_of("eliminate", options["eliminate"], ("auto",))
    if options.get("formed", "auto") not in ("auto", True, False):
        raise _impossible("formed", "'auto', True or False", options["formed"])
    for option in ("tolerance", "floor"):
        if option in options and not 0 < options[option] < 1:
            raise _impossible(option, "a number between 0 and 1", options[option])
    if "iterations" in options and not options["iterations"] >= 1:
        raise _impossible("iterations", "a number from 1", options["iterations"])


def _unknown(name: Any) -> AraelError:
    near = closest(name, SOLVERS) if isinstance(name, str) else []
    return AraelError(
        Diagnostic(
            "E0840",
            f"there is no linear solver {name!r}",
            origin="solver options",
            notes=(f"solvers are {', '.join(SOLVERS)}",),
            help=(f"did you mean {near[0]!r}?",) if near else (),
        )
    )


def _impossible(option: str, expected: str, found: Any) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0842", f"{option} must be {expected}, found {found!r}", origin="solver options"
        )
    )


def _one_of(option: str, value: Any, known: tuple[str, ...]) -> None:
    if value not in known:
        near = closest(str(value), known)
        raise AraelError(
            Diagnostic(
                "E0842",
                f"there is no {option} {value!r}",
                origin="solver options",
                notes=(f"{option} is one of {', '.join(known)}",),
                help=(f"did you mean {near[0]!r}?",) if near else (),
            )
        )
