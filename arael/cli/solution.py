"""Solution of a solve: parameters of the root with standard deviations, rows of collections."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arael.analysis.scalars import tangent_units
from arael.cli.summary import plain
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.display.measured import measured
from arael.io.columns import scalar_names
from arael.runtime.layout import Column, Entity, Layout
from arael.runtime.system import free_scalars

_SHOWN = re.compile(r"\s*([\w.]+?)\s*(?:\[\s*(-?\d*)\s*(:?)\s*(-?\d*)\s*\])?\s*", re.ASCII)
_FEW = 5
"""Rows shown of a collection without a range."""


@dataclass(frozen=True)
class Scalar:
    """One scalar of a parameter of the root.

    Attributes
    ----------
    value : None for a tangent scalar, which has a standard deviation only
    sigma : None if it is not available
    note : the reason: ``fixed``, ``on its upper bound 1``, ``not determined``
    """

    name: str
    value: float | None
    sigma: float | None
    unit: str
    note: str

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        value, sigma = measured(self.value, self.sigma)
        spread = f"+- {sigma}" if sigma else ""
        note = f"  ({self.note})" if self.note else ""
        return f"{' '.join(t for t in (value, spread) if t)}{unit}{note}"


@dataclass(frozen=True)
class Rows:
    """Rows of a collection: names of its columns, and of each row its name and values."""

    asked: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Any, ...]], ...]
    total: int


@dataclass(frozen=True)
class Solution:
    """The part of a solution to show, as text, JSON and HTML.

    Attributes
    ----------
    scalars : of the root's parameters
    notes : why standard deviations are missing
    shown : the requested rows
    """

    scalars: tuple[Scalar, ...] = ()
    notes: tuple[str, ...] = ()
    shown: tuple[Rows, ...] = field(default=())

    def lines(self) -> Iterator[str]:
        """Text for a terminal."""
        width = max((len(scalar.name) for scalar in self.scalars), default=0)
        for scalar in self.scalars:
            sign = "=" if scalar.value is not None else " "
            yield f"{scalar.name:<{width}} {sign} {scalar}"
        yield from (f"note: {note}" for note in self.notes)
        for rows in self.shown:
            yield from _aligned([("", *rows.head), *((n, *map(_text, v)) for n, v in rows.rows)])
            if len(rows.rows) < rows.total:
                yield f"({len(rows.rows)} of {rows.total} rows)"

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        found: dict[str, Any] = {
            "parameters": {
                one.name: {
                    "value": one.value,
                    "sigma": one.sigma,
                    "unit": one.unit,
                    **({"note": one.note} if one.note else {}),
                }
                for one in self.scalars
            },
            "notes": list(self.notes),
        }
        if self.shown:
            found["rows"] = {
                rows.asked: [
                    {"row": name, **dict(zip(rows.head, values, strict=True))}
                    for name, values in rows.rows
                ]
                for rows in self.shown
            }
        return dict(plain(found))


def check_shown(asked: Sequence[str], layout: Layout) -> None:
    """Reject an unknown collection before the solve.

    Raises
    ------
    AraelError
        E0857
    """
    for one in asked:
        _range(one, layout)


def solution_of(instance: Any, layout: Layout, asked: Sequence[str] = ()) -> Solution:
    """Read the solution out of a solved model.

    Parameters
    ----------
    asked : collections to show, ``poses``, ``poses[3]``, ``poses[:10]``
    """
    entities = [e for e in layout.entities if not e.table and e.params]
    shown = tuple(_rows(instance._store, layout, one) for one in asked)
    if not any(use.tangent for entity in entities for use in entity.params):
        return Solution(shown=shown)

    # imported here: start-up time
    from arael.analysis.sigmas import sigmas

    table = instance._store.tables[""]
    free = any(table.free(u.column)[0] for e in entities for u in e.params if u.tangent)
    known = sigmas(instance._problem()) if free else None
    scalars: list[Scalar] = []
    for entity in entities:
        scalars += _scalars(instance._store, layout, entity, known)
    notes = known.notes if known is not None and any(s.sigma is None for s in scalars) else ()
    return Solution(tuple(scalars), notes, shown)


def _scalars(store: Any, layout: Layout, entity: Entity, known: Any) -> Iterator[Scalar]:

    table, units = store.tables[""], tangent_units(layout, entity)
    moves = free_scalars(store, entity, frozenset())[0]
    for use in entity.params:
        column = layout.table("").column(use.column)
        if not use.tangent or not table.present(use.column)[0]:
            continue
        free = bool(table.free(use.column)[0])
        values = np.ravel(table.column(use.column)[0]).tolist()
        names = [name for name, _ in scalar_names(column)]
        tangent = range(use.tangent_start, use.tangent_start + use.tangent)
        steps = [(entity.prefix + entity.tangent_names[k], units[k]) for k in tangent]
        if len(steps) == len(names):
            # The tangent is the stored value: plain numbers and Euler angles.
            for name, value, (step, unit), k in zip(names, values, steps, tangent, strict=True):
                yield Scalar(name, value, *_spread(step, unit, bool(moves[k]), known))
            continue
        note = "" if free else "fixed"
        for name, value in zip(names, values, strict=True):
            yield Scalar(name, value, None, "", note)
        if free:
            for (step, unit), k in zip(steps, tangent, strict=True):
                yield Scalar(f"step of {step}", None, *_spread(step, unit, bool(moves[k]), known))


def _spread(name: str, unit: str, free: bool, known: Any) -> tuple[float | None, str, str]:
    """Standard deviation, unit and note of a scalar."""
    if not free or known is None:
        return None, unit, "fixed"
    if name in known.on_bound:
        return None, unit, f"on {known.on_bound[name]}"
    sigma = known.values.get(name)
    return sigma, unit, "" if sigma is not None or not known.values else "not determined"


# --- rows of collections ---------------------------------------------------------------------


def _range(asked: str, layout: Layout) -> tuple[str, slice]:
    """Path of a collection and the requested rows."""
    match = _SHOWN.fullmatch(asked)
    paths = [table.path for table in layout.tables if table.path]
    if match is None or match[1] not in paths:
        name = match[1] if match else asked
        near = closest(name, paths)
        what = f"there is no collection `{name}`" if match else "expected NAME or NAME[FROM:TO]"
        known = f"there are {', '.join(paths)}" if paths else "the model has no collections"
        raise AraelError(
            Diagnostic(
                "E0857",
                what,
                origin=f"--show {asked}",
                help=(f"did you mean `{near[0]}`?" if near else known,),
            )
        )
    path, first, colon, last = match.groups()
    if colon:
        return path, slice(int(first) if first else None, int(last) if last else None)
    if first:
        return path, slice(int(first), int(first) + 1 or None)
    return path, slice(None, _FEW)


def _rows(store: Any, layout: Layout, asked: str) -> Rows:
    path, chosen = _range(asked, layout)
    table = store.tables[path]
    columns = [c for c in layout.table(path).columns if c.role == "param" and c.param is not None]
    if not columns:  # no free parameters there: show its data
        columns = [c for c in layout.table(path).columns if c.role == "data"]
    numbers = range(table.size)[chosen]
    head = tuple(name for column in columns for name, _ in scalar_names(column))
    rows = tuple(
        (str(table.row_name(row)), tuple(v for c in columns for v in _cells(table, c, row)))
        for row in numbers
    )
    return Rows(asked, head, rows, table.size)


def _cells(table: Any, column: Column, row: int) -> list[Any]:
    if not table.present(column.path)[row]:
        return [None for _ in scalar_names(column)]
    found: list[Any] = np.ravel(np.asarray(table.column(column.path))[row]).tolist()
    return found


def _text(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for name, *cells in rows:
        texts = (f"{cell:>{width}}" for cell, width in zip(cells, widths[1:], strict=True))
        yield f"{name:<{widths[0]}}  {'  '.join(texts)}".rstrip()
