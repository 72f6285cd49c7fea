"""Access of the commands to a model instance."""

from __future__ import annotations

from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.layout import Column, Layout, Table


def row_counts(instance: Any, layout: Layout) -> dict[str, int]:
    """Rows of every collection of a model instance, by path."""
    found: dict[str, Any] = {"": instance}
    counts: dict[str, int] = {}
    for table in layout.tables:
        if table.path:
            found[table.path] = found[table.parent][table.field]
            counts[table.path] = len(found[table.path])
    return counts


def apply_settings(instance: Any, layout: Layout, settings: tuple[str, ...]) -> None:
    """Set root data from ``--set name=value``.

    Raises
    ------
    AraelError
        E0852 if an assignment is malformed, names no field of the root, or does not fit its type.
    """
    root = layout.table("")
    wrong: list[Diagnostic] = []
    for setting in settings:
        name, sign, text = setting.partition("=")
        try:
            if not sign:
                raise _bad(setting, "expected NAME=VALUE", "for instance --set gamma=3.18")
            column = _column(root, name.strip(), setting)
            instance[column.path] = _value(column, text.strip(), setting)
        except AraelError as error:
            wrong.extend(error.diagnostics)
    if wrong:
        raise AraelError(wrong)


def _column(root: Table, name: str, setting: str) -> Column:
    settable = {c.path: c for c in root.columns if c.role in ("data", "param", "skip")}
    if name in settable:
        return settable[name]

    near = closest(name, settable)
    if near:
        advice = f"did you mean `{near[0]}`?"
    else:
        advice = f"it has {', '.join(settable)}" if settable else "it has none"
    raise _bad(setting, f"`{root.struct}` has no field `{name}` to set", advice)


def _value(column: Column, text: str, setting: str) -> Any:
    """Read `text` as the type of `column`; a vector is given as numbers separated by commas."""
    if column.kind == "string":
        return text
    if column.kind == "bool":
        if text in ("true", "false"):
            return text == "true"
        raise _bad(setting, f"expected true or false for `{column.path}`, found `{text}`")
    # imported here: start-up time
    from arael.io.plain_numbers import real, whole

    number = whole if column.kind == "int" else real
    try:
        values = [number(part.strip()) for part in text.strip("[]").split(",")]
    except ValueError:
        noun = "whole numbers" if number is whole else "numbers"
        raise _bad(setting, f"expected {noun} for `{column.path}`, found `{text}`") from None
    count = 1
    for extent in column.shape:
        count *= extent
    if len(values) != count:
        raise _bad(
            setting,
            f"`{column.path}` is {column.type}: expected {count} numbers, found {len(values)}",
            f"declared at {column.where}",
        )
    if not column.shape:
        return values[0]

    return np.array(values).reshape(column.shape)


def _bad(setting: str, message: str, *help_: str) -> AraelError:
    return AraelError(Diagnostic("E0852", message, origin=f"--set {setting}", help=help_))
