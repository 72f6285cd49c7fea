"""Errors of Python calls: an argument of a type or value that the function does not take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

from arael.diagnostics.records import AraelError, Diagnostic, Span

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

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


def fail(
    code: str, message: str, span: Span | None = None, label: str = "", **more: Any
) -> NoReturn:
    """Raise `AraelError` with one diagnostic; `more` are further fields of it."""
    raise AraelError(Diagnostic(code, message, span, label, **more))


def require(
    ok: object, function: str, name: str, expected: str, found: Any, help: str = ""
) -> None:
    """Raise the error of `wrong_argument` unless `ok`."""
    if not ok:
        raise wrong_argument(function, name, expected, found, help)


def as_list(
    found: Any, of: type | tuple[type, ...], function: str, name: str, expected: str, help: str = ""
) -> list[Any]:
    """Return an iterable of instances of `of` as a list; one instance alone is a list of one.

    Raises
    ------
    AraelError
        E0828, that of `wrong_argument`, for anything else.
    """
    if isinstance(found, of):
        return [found]
    listed = []
    for one in found if isinstance(found, Iterable) else (None,):
        require(isinstance(one, of), function, name, expected, found, help)
        listed.append(one)
    return listed


def as_mapping(
    found: Any,
    keys: type | tuple[type, ...],
    function: str,
    name: str,
    expected: str,
    help: str = "",
) -> Mapping[Any, Any]:
    """Return a mapping whose keys are instances of `keys`; an empty one for None.

    Raises
    ------
    AraelError
        E0828, that of `wrong_argument`, for anything else.
    """
    given = {} if found is None else found
    fits = isinstance(given, Mapping) and all(isinstance(key, keys) for key in given)
    require(fits, function, name, expected, found, help)
    return given


def as_numbers(found: Any, function: str, name: str, help: str = "") -> NDArray[np.float64]:
    """Return numbers, or nested lists or arrays of them, as an array of any shape in f64.

    Raises
    ------
    AraelError
        E0828, that of `wrong_argument`, for anything else. NumPy alone would read texts as numbers
        and None as NaN, and cut complex numbers.
    """
    # imported here: start-up time
    import numpy as np

    try:
        given = np.asarray(found)
        if given.dtype.kind in "biuf" or (
            given.dtype == object and not any(one is None for one in given.flat)
        ):
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        pass
    raise wrong_argument(function, name, "a number or an array of numbers", found, help)


def described(found: Any) -> str:
    """A short text for a value: numbers and short texts as they are, else the name of the type."""
    if found is None or isinstance(found, bool | int | float | complex | str | bytes):
        text = repr(found)
        return text if len(text) <= 40 else f"{type(found).__name__} {text[:36]}..."
    shape = getattr(found, "shape", None)
    where = f" of shape {shape}" if isinstance(shape, tuple) else ""
    return f"{type(found).__name__}{where}"
