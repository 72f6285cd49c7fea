"""Diagnostics about data, with the same wording for all sources."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Column


class Name:
    """A place in the data, formatted only if a message needs it."""

    __slots__ = ("_make",)

    def __init__(self, make: Callable[[], str]) -> None:
        self._make = make

    def __str__(self) -> str:
        return self._make()


Origin = str | Name


def below(origin: Origin, path: str) -> Name:
    """Return the place of a field at `origin`."""
    return Name(lambda: f"{origin}.{path}")


def declared(column: Column) -> str:
    """Note with the declaration in the model."""
    around, _, name = column.path.rpartition(".")
    if name.isdecimal():  # an element of a list of refs
        name = f"{around.rpartition('.')[2]}[{name}]"
    param = "param " if column.role == "param" else ""
    text = column.type.removeprefix("param ")
    return f"declared as `{param}{name}: {text}` at {column.where}"


def problem(
    code: str, message: str, origin: Origin, column: Column | None = None, help: str = ""
) -> Diagnostic:
    """A diagnostic about the data at `origin` (``scene.json: poses[3].pos``)."""
    notes = (declared(column),) if column is not None else ()
    return Diagnostic(code, message, origin=str(origin), notes=notes, help=(help,) if help else ())


def error(
    code: str, message: str, origin: Origin, column: Column | None = None, help: str = ""
) -> AraelError:
    """Return the same as an exception."""
    return AraelError(problem(code, message, origin, column, help))


class UnknownFieldError(AraelError, AttributeError):
    """A field that the model does not declare; also an AttributeError, as Python expects one."""


def unknown_field(
    name: str, known: Iterable[str], struct: str, where: str, origin: Origin
) -> Diagnostic:
    """Return a key or field that the model does not declare."""
    known = list(known)
    return Diagnostic(
        "E0701",
        f"`{struct}` has no field `{shorten(name)}`",
        origin=str(origin),
        notes=(f"this `{struct}` is declared at {where}",) if where else (),
        help=(suggestion(name, known),) if known else (),
    )


def suggestion(name: str, known: list[str]) -> str:
    """Help for a misspelt name."""
    # Imported here for start-up time: only messages need it.
    from arael.diagnostics.suggest import closest

    near = closest(name, known)
    if near:
        return f"did you mean `{near[0]}`?"
    shown = ", ".join(f"`{k}`" for k in known[:12])
    return f"known names are {shown}" + (", ..." if len(known) > 12 else "")


def shorten(value: Any, limit: int = 40) -> str:
    """Text of a value from the data for a message: one line, printable, shortened."""
    text = value if isinstance(value, str) else repr(value)
    text = (
        text[: limit + 1].encode("unicode_escape").decode("ascii")
        if not text.isprintable()
        else text
    )
    return text if len(text) <= limit else text[: limit - 3] + "..."


def describe(value: Any) -> str:
    """Describe a value in the terms of a data file."""
    match value:
        case None:
            return "null"
        case bool() | np.bool_():
            return "true" if value else "false"
        case int() | float() | np.integer() | np.floating():
            return f"the number {shorten(str(value))}"
        case str():
            return f'the string "{shorten(value)}"'
        case dict():
            return "an object"
        case list() | tuple():
            return f"an array of {len(value)}"
        case np.ndarray():
            return f"an array of shape {value.shape} and type {value.dtype}"
    return f"a {type(value).__name__}"


SCALAR_WORDS = {
    "real": "a number",
    "int": "an integer",
    "bool": "true or false",
    "string": "a string",
}


def expected(column: Column) -> str:
    """Describe the expected value of a column: ``vec3 (3 numbers)``."""
    if column.role == "ref":
        return f"a `{column.type}`"
    if not column.shape:
        return SCALAR_WORDS[column.kind]
    count = " x ".join(str(n) for n in column.shape)
    return f"{column.type.removeprefix('param ')} ({count} numbers)"
