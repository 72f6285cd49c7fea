"""Priors in JSON files: the key ``$priors`` beside the fields of the root.

Each prior is an object with its name, its parameters (collection, row in the order of the file,
field, first estimate), and the rows of Jacobian and residual.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.json_reader import PRIORS
from arael.residuals.messages import error, label_problem
from arael.runtime.layout import ParamUse
from arael.runtime.store import Store, Table
from arael.windows.marginalisation import Key, add_prior, priors
from arael.windows.prior import Part, Prior

KEY = PRIORS

Read = list[tuple[str, Prior, list[tuple[str, str, int]]]]
"""Name, prior and (table, column, row) of its parameters."""


def dump(store: Store) -> list[dict[str, Any]]:
    """Priors of a model as data for JSON."""
    model = store.model()
    found = []
    for label, code in {} if model is None else priors(model).items():
        prior = code.function
        parameters = []
        for (path, column, handle), part in zip(code.keys, prior.parts, strict=True):
            place = {"row": _position(store.tables[path], handle)} if path else {}
            parameters.append(
                {"collection": path, **place, "parameter": column, "at": part.base.tolist()}
            )
        found.append(
            {
                "name": label,
                "parameters": parameters,
                "jacobian": prior.jacobian.tolist(),
                "residual": prior.residual.tolist(),
                "constant": prior.constant,
            }
        )
    return found


def read(store: Store, given: Any, name: str) -> Read:
    """Check the priors of a file against the rows that were read.

    Raises
    ------
    AraelError
        E0783: they do not have the form that `dump` writes, or do not fit the model.
    """
    try:
        return [_read_one(store, one) for one in given]
    except _Unfit as failure:
        raise error("E0783", f"{failure}", f"{name}: {KEY}", _ADVICE) from None
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as failure:
        what = f"{type(failure).__name__}: {failure}"
        raise error("E0783", f"not a list of priors ({what})", f"{name}: {KEY}", _ADVICE) from None


def restore(store: Store, found: Read) -> None:
    """Replace the priors of the model of a store by those of a file, whose rows are there now."""
    model = store.model()
    if model is None:
        return
    for label in priors(model):
        model.residuals.remove(label)
    for label, prior, places in found:
        keys: list[Key] = []
        for path, column, row in places:
            handle = int(store.tables[path].handles(np.array([row]))[0]) if path else -1
            keys.append((path, column, handle))
        add_prior(model, prior, keys, label)


_ADVICE = "remove the key to read the data without its priors"


class _Unfit(Exception):
    """A prior that does not fit the model."""


def _read_one(store: Store, one: dict[str, Any]) -> tuple[str, Prior, list[tuple[str, str, int]]]:
    if label_problem(one["name"]):
        raise _Unfit(f"{one['name']!r:.60} cannot be a name")
    label, parts, places = one["name"], [], []
    for given in one["parameters"]:
        path, column = given["collection"], given["parameter"]
        use = _use(store, path, column)
        if use is None:
            raise _Unfit(f"`{label}` names `{path}.{column}`, which is no parameter of the model")
        row = 0
        if path:
            order = reading_order(store.tables[path])
            if not 0 <= given["row"] < len(order):
                raise _Unfit(f"`{label}` names row {given['row']} of `{path}`: out of range")
            row = int(order[given["row"]])
        base = _numbers(given["at"], (use.stored,), f"`at` of `{path}.{column}`")
        parts.append(Part(use.kind, base, use.tangent))
        places.append((path, column, row))
    width = sum(part.tangent for part in parts)
    rows = len(one["residual"])
    jacobian = _numbers(one["jacobian"], (rows, width), f"the Jacobian of `{label}`")
    residual = _numbers(one["residual"], (rows,), f"the residual of `{label}`")
    if not rows or not parts:
        raise _Unfit(f"`{label}` has no residuals")
    return label, Prior(parts, jacobian, residual, float(one.get("constant", 0.0))), places


def _numbers(given: Any, shape: tuple[int, ...], what: str) -> NDArray[np.float64]:
    found = np.asarray(given, dtype=np.float64)
    expected = " x ".join(map(str, shape))
    if found.shape != shape or not np.isfinite(found).all():
        raise _Unfit(f"{what} is not an array of {expected} finite numbers")
    return found


def _use(store: Store, path: str, column: str) -> ParamUse | None:
    for entity in store.layout.entities:
        for use in entity.params:
            if entity.table == path and use.column == column and use.tangent:
                return use
    return None


def _position(table: Table, handle: int) -> int:
    """Place of a row in the order of a file."""
    row = int(table.rows_of(np.array([handle]))[0])
    return int(np.flatnonzero(reading_order(table) == row)[0])


def reading_order(table: Table) -> NDArray[np.int64]:
    """Rows of a table in the order of a file: those of a nested collection by owner."""
    if not table.layout.path or not table.layout.parent:
        return np.arange(table.size)
    order, offsets = table.grouped()
    owners = reading_order(table.parent)
    parts = [order[offsets[owner] : offsets[owner + 1]] for owner in owners.tolist()]
    return np.concatenate(parts) if parts else np.zeros(0, np.int64)
