"""Errors of Python calls: an argument of a type or value that the function does not take."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic

CODE = "E0828"


def wrong_argument(
    function: str, name: str, expected: str, found: Any, help: str = ""
) -> AraelError:
    """Error for the argument `name` of `function`.

    Parameters
    ----------
    function : name of the called function, the place of the message
    expected : what the argument must be, such as ``"a list of variables"``
    found : the argument as it was given
    help : a correct call
    """
    return AraelError(
        Diagnostic(
            CODE,
            f"`{name}` must be {expected}, found {described(found)}",
            origin=function,
            help=(help,) if help else (),
        )
    )


def described(found: Any) -> str:
    """A short text for a value: numbers and short texts as they are, else the name of the type."""
    if found is None or isinstance(found, bool | int | float | complex | str | bytes):
        text = repr(found)
        return text if len(text) <= 40 else f"{type(found).__name__} {text[:36]}..."
    shape = getattr(found, "shape", None)
    where = f" of shape {shape}" if isinstance(shape, tuple) else ""
    return f"{type(found).__name__}{where}"
