"""Renaming inside of expressions; everything else stays as it is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast

from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Dimension, Parameter
from arael.sketch.expressions.dependencies import amounts_of, paths_of, texts_of
from arael.sketch.expressions.reading import read


def renamed(text: str, names: Mapping[str, str]) -> str:
    """An expression with other names.

    Parameters
    ----------
    names : old -> new; ``L0`` stands for all its parts, unless ``L0.p1`` or ``L0.length`` is
        named too: the longest wins. What replaces a whole name may be an expression in brackets.
    """
    if not any(_replacement(path, names) for path in paths_of(text)):
        return text
    pieces: list[str] = []
    at = 0
    for path, start, end in read(text).references:
        new = _replacement(path, names)
        if new:
            pieces += [text[at:start], new]
            at = end
    return "".join([*pieces, text[at:]])


def _replacement(path: str, names: Mapping[str, str]) -> str:
    parts = path.split(".")
    for count in range(len(parts), 0, -1):
        new = names.get(".".join(parts[:count]))
        if new is not None:
            return ".".join([new, *parts[count:]])
    return ""


def rename_everywhere(document: Document, names: Mapping[str, str]) -> list[str]:
    """Rename in the expressions of dimensions, parameters and groups; names of what changed."""
    changed = []
    for group in list(document.groups.values()):
        texts = {
            key: renamed(text, names)
            for key, text in texts_of(group).items()
            if renamed(text, names) != text
        }
        if texts:
            changed.append(group.name)
            document.put("groups", replace(group, options={**group.options, **texts}))
    records: list[Parameter | Dimension] = [*document.parameters.values()]
    records += document.dimensions.values()
    for record in records:
        fields = {
            field: Amount(renamed(amount.text, names), amount.number)
            for field, amount in amounts_of(record)
            if renamed(amount.text, names) != amount.text
        }
        if not fields:
            continue
        changed.append(record.name)
        if isinstance(record, Parameter):
            document.put("parameters", replace(record, amount=fields["amount"]))
        else:
            document.put("dimensions", replace(record, **cast("dict[str, Any]", fields)))
    return changed
