"""Expressions from text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arael.diagnostics.records import Source
from arael.sym.reading import Reader
from arael.sym.shapes import as_value
from arael.sym.user_functions import FunctionBag
from arael.syntax.parser import parse_expression


def parse(
    text: str | Source,
    functions: FunctionBag | None = None,
    names: Mapping[str, Any] | None = None,
) -> Any:
    """Read a formula in the notation of models.

    Parameters
    ----------
    text : such as ``"a * exp(-b * x) + c"``
    functions : functions of the user, which shadow built-in ones of the same name
    names : values of names: numbers, expressions, vectors, matrices, quaternions. What is not
        among them is a constant (``pi``, ``e``, ``epsilon``) or else becomes a variable.

    Returns
    -------
    An expression (`Expr`), `Vector`, `Matrix` or `Quaternion`.

    Raises
    ------
    AraelError
        With the place in the text for what is wrong in it. Nothing of the text is ever run.
    """
    source = text if isinstance(text, Source) else Source("formula", text)
    values = {name: as_value(value) for name, value in (names or {}).items()}
    bag = functions if functions is not None else FunctionBag()
    return Reader(bag, values).value(parse_expression(source))
