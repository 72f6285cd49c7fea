"""Marginalisation: rows leave a model, and a prior on their neighbours stays."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael import solving
from arael.diagnostics.records import AraelError
from arael.face.parameter import Parameter
from arael.residuals.code import LARGEST, CodeResidual
from arael.residuals.messages import error, label_problem
from arael.runtime.failures import refuse_required
from arael.runtime.problem import Problem
from arael.windows.elimination import eliminate
from arael.windows.leaving import Masks, leaving_rows, remove
from arael.windows.linearisation import (
    Floats,
    Place,
    columns_of,
    linearise,
    use_of,
    value_at,
)
from arael.windows.prior import Part, Prior

Key = tuple[str, str, int]
"""Table, column and handle of a parameter; handle -1 for one of the root."""


def marginalise(
    model: Any, rows: Any, first_estimates: bool = True, name: str = "prior"
) -> CodeResidual | None:
    """Carry out `Model.marginalise`."""
    if label_problem(name):
        raise error("E0780", f"{name!r:.60} cannot be a name: {label_problem(name)}", "marginalise")
    store = model._store
    store.check_complete()
    with store.use.lock, store.use.changing("marginalise rows of the model"):
        gone = leaving_rows(store, rows)
        problem = solving.problem_of(model)
        refuse_required(problem.layout, "a window", "write it as a constraint with a small sigma")
        _refuse_others(model, problem, gone)
        window = _Window(model, problem, gone, first_estimates)
        window.absorb()
        prior, keys = window.eliminated()
        for label in window.absorbed:
            model.residuals.remove(label)
        remove(store, gone)
        if prior is None:
            return None
        return add_prior(model, prior, keys, name)


def priors(model: Any) -> dict[str, CodeResidual]:
    """Residuals of a model that `marginalise` added, by name."""
    found = {} if model._residuals is None else model._residuals.code
    return {label: code for label, code in found.items() if isinstance(code.function, Prior)}


def add_prior(model: Any, prior: Prior, keys: list[Key], name: str) -> CodeResidual:
    """Add a prior on the parameters `keys` as residuals of the model."""
    residuals = model.residuals
    label = _free(residuals, name)
    parameters = [_parameter(model, key) for key in keys]
    data = {"row": np.arange(len(prior.residual))}
    code = CodeResidual(model, prior, parameters, 1, data, None, "tangent", None, label)
    found: CodeResidual = residuals.add_code(code)
    return found


def _parameter(model: Any, key: Key) -> Parameter:
    table = model._store.tables[key[0]]
    row = 0 if key[2] < 0 else int(table.rows_of(np.array([key[2]]))[0])
    return Parameter(table, key[1], partial(_same, row))


def _free(residuals: Any, name: str) -> str:
    """`name`, or with a number if it is taken."""
    number, label = 1, name
    while True:
        try:
            residuals._check_free(label, "label")
        except AraelError:
            number += 1
            label = f"{name}_{number}"
        else:
            return label


def _epsilon(precision: str) -> float:
    """Relative rounding error of a model."""
    return float(np.finfo(np.float32 if precision == "f32" else np.float64).eps)


def _same(row: int) -> int:
    return row


def keys_of(code: CodeResidual) -> list[Key]:
    """The parameters of a prior."""
    return [
        (a.table, a.column, -1 if a.refs is None else int(a.refs._handles[0]))
        for a in code.arguments
    ]


class _Window:
    """One marginalisation.

    Attributes
    ----------
    absorbed : names of earlier priors that become part of the new one
    """

    def __init__(self, model: Any, problem: Problem, gone: Masks, first_estimates: bool) -> None:
        self.problem, self.gone = problem, gone
        self.layout = problem.layout
        self.store = model._store
        self.known = priors(model)
        self.absorbed: list[str] = []
        numbers = {group.label: k for k, group in enumerate(self.layout.groups)}
        self.number = {label: numbers[label] for label in self.known}
        self.places = {
            (entity.table, use.column): (number, k)
            for number, entity in enumerate(self.layout.entities)
            for k, use in enumerate(entity.params)
        }
        self.instances = [
            _touching(problem, number, gone) for number in range(len(self.layout.groups))
        ]
        self.bases = self._first_estimates() if first_estimates else {}

    def _first_estimates(self) -> dict[Place, Floats]:
        found: dict[Place, Floats] = {}
        for code in self.known.values():
            for key, part in zip(keys_of(code), code.function.parts, strict=True):
                found.setdefault(self._place(key), part.base)
        return found

    def _place(self, key: Key) -> Place:
        number, use = self.places[key[0], key[1]]
        row = 0
        if key[2] >= 0:
            row = int(self.store.tables[key[0]].rows_of(np.array([key[2]]))[0])
        return number, row, use

    def absorb(self) -> None:
        """Choose earlier priors: those of rows that leave, and those that cause no fill."""
        waiting = {}
        for label, code in self.known.items():
            if self.instances[self.number[label]].any():
                self._take(label)
            else:
                waiting[label] = {self._place(key) for key in keys_of(code)}
        neighbours = self._neighbours()
        merged = bool(neighbours)
        while merged:
            merged = False
            for label, own in list(waiting.items()):
                if own <= neighbours or neighbours <= own:
                    self._take(label)
                    del waiting[label]
                    neighbours |= own
                    merged = True

    def _take(self, label: str) -> None:
        self.absorbed.append(label)
        self.instances[self.number[label]][:] = True

    def _neighbours(self) -> set[Place]:
        """Free parameters of rows that stay, which leaving instances read."""
        found = set()
        for number, mask in enumerate(self.instances):
            if not mask.any():
                continue
            group = self.layout.groups[number]
            placement = self.problem.structure.placements[number]
            tangents: dict[int, set[int]] = {}
            for _, use, tangent in group.jacobian:
                tangents.setdefault(use, set()).add(tangent)
            for use, read in tangents.items():
                entity = group.uses[use].entity
                params = self.layout.entities[entity].params
                chosen = [
                    k
                    for k, p in enumerate(params)
                    if any(p.tangent_start <= t < p.tangent_start + p.tangent for t in read)
                ]
                rows = np.unique(placement.rows[mask, use])
                leaves = self.gone.get(self.layout.entities[entity].table)
                free = self.problem.structure.system.blocks[entity].free
                for row in rows.tolist():
                    if leaves is not None and leaves[row]:
                        continue
                    for k in chosen:
                        at = params[k].tangent_start
                        if free[row, at : at + params[k].tangent].any():
                            found.add((entity, row, k))
        return found

    def eliminated(self) -> tuple[Prior | None, list[Key]]:
        """The prior on the neighbours, and their keys."""
        problem = self.problem
        places = sorted(self._neighbours())
        self._refuse(places)
        bases = {place: base for place, base in self.bases.items() if self._moves(place)}
        values = {place: value_at(problem, place) for place in places}
        linear = linearise(problem, self.instances, bases)
        at = [columns_of(problem, place) for place in places]
        staying = np.concatenate(at or [np.zeros(0, np.int64)])
        leaving = np.setdiff1d(linear.columns, staying)
        order = np.concatenate([leaving, staying])
        # A neighbour that is held in part has columns of zeros.
        jacobian = np.zeros((len(linear.residual), len(order)))
        index = np.searchsorted(linear.columns, order)
        index[index == len(linear.columns)] = 0
        if len(linear.columns):
            there = linear.columns[index] == order
            jacobian[:, there] = linear.jacobian[:, index[there]]
        tolerance = _epsilon(self.layout.precision) ** 0.75
        found = eliminate(jacobian, linear.residual, len(leaving), tolerance)
        if not len(found.residual):
            return None, []
        parts = []
        for place in places:
            use = use_of(problem, place)
            parts.append(Part(use.kind, bases.get(place, values[place]), use.tangent))
        constant = found.constant + sum(
            self.known[label].function.constant for label in self.absorbed
        )
        prior = Prior(parts, found.jacobian, found.residual, constant, found.undetermined)
        return prior, [self._key(place) for place in places]

    def _moves(self, place: Place) -> bool:
        use = use_of(self.problem, place)
        free = self.problem.structure.system.blocks[place[0]].free[place[1]]
        return bool(free[use.tangent_start : use.tangent_start + use.tangent].any())

    def _key(self, place: Place) -> Key:
        path = self.layout.entities[place[0]].table
        handle = int(self.store.tables[path].handles(np.array([place[1]]))[0]) if path else -1
        return path, use_of(self.problem, place).column, handle

    def _refuse(self, places: list[Place]) -> None:
        """Refuse neighbours that no prior can be on."""
        width = 0
        for place in places:
            entity, use = self.layout.entities[place[0]], use_of(self.problem, place)
            width += use.tangent
            if entity.updated:
                name = self.store.tables[entity.table].name_of(place[1], use.column)
                raise error(
                    "E0782",
                    f"a prior on `{name}` is not possible: a component updates its own parameters",
                    "marginalise",
                    "marginalise this row too, or write the prior as a constraint",
                )
        if width > LARGEST:
            raise error(
                "E0782",
                f"the prior would be a dense matrix over {width} scalars of {len(places)} "
                "parameters",
                "marginalise",
                f"at most {LARGEST} are possible: marginalise rows with fewer neighbours first, or "
                "landmarks together with the poses that see them",
            )


def _touching(problem: Problem, number: int, gone: Mapping[str, NDArray[np.bool_]]) -> Any:
    """(n,) active instances of a group that read a row that leaves."""
    group, structure = problem.layout.groups[number], problem.structure
    rows = structure.active[number]
    found = np.zeros(len(rows), dtype=bool)
    if group.table in gone:
        found |= gone[group.table][rows]
    for slot, rows in zip(group.slots, structure.slot_rows[number], strict=True):
        if slot.steps and slot.table in gone and gone[slot.table].any():
            found |= (rows >= 0) & gone[slot.table][rows]
    return found


def _refuse_others(model: Any, problem: Problem, gone: Masks) -> None:
    """Refuse residuals added at run time that read a row that leaves, except priors."""
    known = priors(model)
    for number in range(len(model._compiled.layout.groups), len(problem.layout.groups)):
        label = problem.layout.groups[number].label
        if problem.layout.groups[number].case_of >= 0:
            _refuse_part(problem, number, gone)
            continue
        if label not in known and _touching(problem, number, gone).any():
            raise _reads(label)
    for update in () if model._residuals is None else model._residuals.updates.values():
        for argument in update.arguments:
            refs = argument.refs
            if refs is not None and gone[argument.table][refs.rows].any():
                raise _reads(update.label)


def _refuse_part(problem: Problem, number: int, gone: Masks) -> None:
    """Refuse that rows leave a list which a residual of a row that stays sums over."""
    group = problem.layout.groups[number]
    stay = ~gone[group.table][problem.structure.active[number]]
    stay &= _touching(problem, number, gone)
    if not stay.any():
        return
    place = problem.instance_place(number, int(np.argmax(stay)))
    raise error(
        "E0781",
        f"`{group.label}` of `{place}`, which stays, sums over a row that leaves",
        "marginalise",
        f"marginalise `{place}` too, or keep all rows of its list",
    )


def _reads(label: str) -> Exception:
    return error(
        "E0781",
        f"`{label}`, added at run time, reads a row that leaves",
        "marginalise",
        f'remove it first, `model.residuals.remove("{label}")`, and add it again for the rows that '
        "stay, or write it as a constraint of the model",
    )
