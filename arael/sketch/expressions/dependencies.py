"""What expressions read: order of evaluation, cycles, which of them follow geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Dimension, Group, Parameter
from arael.sketch.expressions.functions import CONSTANTS
from arael.sketch.expressions.reading import literal, read


def amounts_of(record: Dimension | Parameter) -> Iterator[tuple[str, Amount]]:
    """Fields of a record that hold a value, with it."""
    if isinstance(record, Parameter):
        yield "amount", record.amount
        return
    for field in ("value", "low", "high"):
        amount = getattr(record, field)
        if amount is not None:
            yield field, amount


@lru_cache(maxsize=8192)
def paths_of(text: str) -> tuple[str, ...]:
    """Names that an expression reads, constants left out; empty for a text that cannot be read."""
    if literal(text) is not None:
        return ()
    try:
        return tuple(path for path in read(text).names if path not in CONSTANTS)
    except AraelError:
        return ()


def is_live(record: Dimension | Parameter) -> bool:
    """Whether a value of a record is more than a literal."""
    if isinstance(record, Parameter):
        return literal(record.amount.text) is None
    for amount in (record.value, record.low, record.high):
        if amount is not None and literal(amount.text) is None:
            return True
    return False


def reads(document: Document, record: Dimension | Parameter) -> list[str]:
    """Names of parameters and dimensions that a record reads, without those of geometry."""
    known: tuple[Mapping[str, object], ...] = (document.parameters, document.dimensions)
    return [
        path
        for _, amount in amounts_of(record)
        for path in paths_of(amount.text)
        if any(path in table for table in known)
    ]


def reads_geometry(document: Document, record: Dimension | Parameter) -> bool:
    """Whether a record reads a property of an entity or a measured dimension by itself."""
    for _, amount in amounts_of(record):
        for path in paths_of(amount.text):
            dimension = document.dimensions.get(path)
            if dimension is not None and (dimension.derived or dimension.is_range):
                return True
            if path not in document.parameters and path not in document.dimensions:
                return True
    return False


def ordered(document: Document, names: Mapping[str, object]) -> tuple[list[str], list[list[str]]]:
    """Names so that each comes after those it reads; and the cycles, which are left out.

    Parameters
    ----------
    names : of parameters and dimensions
    """
    done: dict[str, None] = {}
    cycles: list[list[str]] = []
    state: dict[str, int] = {}
    for root in names:
        if root in state:
            continue
        path: list[str] = []
        stack: list[tuple[str, Iterator[str]]] = [(root, iter(_next(document, names, root)))]
        state[root] = 1
        path.append(root)
        while stack:
            name, rest = stack[-1]
            for other in rest:
                if state.get(other) == 1:
                    cycles.append([*path[path.index(other) :], other])
                elif other not in state:
                    state[other] = 1
                    path.append(other)
                    stack.append((other, iter(_next(document, names, other))))
                    break
            else:
                stack.pop()
                path.pop()
                state[name] = 2
                done[name] = None
    bad = {name for cycle in cycles for name in cycle}
    return [name for name in done if name not in bad], cycles


def _next(document: Document, names: Mapping[str, object], name: str) -> list[str]:
    record = document.parameters.get(name) or document.dimensions.get(name)
    return [] if record is None else [one for one in reads(document, record) if one in names]


def cycle_through(document: Document, name: str, texts: Mapping[str, str] | list[str]) -> list[str]:
    """The way back to `name` if it had expressions `texts`; empty if there is none."""
    waiting: list[tuple[str, tuple[str, ...]]] = [
        (path, (name,)) for text in texts for path in paths_of(text)
    ]
    seen: set[str] = set()
    while waiting:
        here, way = waiting.pop()
        if here == name:
            return [*way, here]
        record = document.parameters.get(here) or document.dimensions.get(here)
        if record is None or here in seen:
            continue
        seen.add(here)
        waiting += [(other, (*way, here)) for other in reads(document, record)]
    return []


def readers(document: Document, name: str) -> list[str]:
    """Parameters, dimensions and groups whose expressions read a name, or a part of an entity."""

    def reads_it(text: str) -> bool:
        return any(p == name or p.startswith(f"{name}.") for p in paths_of(text))

    found: list[str] = []
    for table in (document.parameters, document.dimensions):
        for record in table.values():
            if any(reads_it(amount.text) for _, amount in amounts_of(record)):
                found.append(record.name)
    found += [g.name for g in document.groups.values() if any(map(reads_it, texts_of(g).values()))]
    return found


#: Options of groups that are expressions where they are texts.
_EXPRESSIONS = ("distance", "distance2", "distance_text", "distance2_text", "angle_text")


def texts_of(group: Group) -> dict[str, str]:
    """Options of a group that are expressions."""
    found = {key: group.options.get(key) for key in _EXPRESSIONS}
    return {key: text for key, text in found.items() if isinstance(text, str) and text}
