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
from arael.geometry.differences import difference
from arael.residuals.code import LARGEST, CodeResidual
from arael.residuals.messages import error, label_problem
from arael.runtime.failures import refuse_required
from arael.runtime.problem import Problem
from arael.windows.elimination import eliminate
from arael.windows.leaving import Masks, leaving_rows, remove
from arael.windows.linearisation import WholeSystem
from arael.windows.prior import Part, Prior
from arael.windows.system import Floats, Place, System, touching, use_of
from arael.windows.tracked import tracked_system

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
        window = _Window(model, _system(model, gone), gone, first_estimates)
        window.absorb()
        prior, keys = window.eliminated()
        for label in window.absorbed:
            model.residuals.remove(label)
        remove(store, gone)
        if prior is None:
            return None
        return add_prior(model, prior, keys, name)


def _system(model: Any, gone: Masks) -> System:
    """What leaves, from the factor of the last `Model.update` if there is one."""
    found = tracked_system(model, gone)
    if found is not None:
        return found
    problem = solving.problem_of(model)
    refuse_required(problem.layout, "a window", "write it as a constraint with a small sigma")
    _refuse_others(model, problem, gone)
    known = priors(model)
    numbers = [k for k, group in enumerate(problem.layout.groups) if group.label in known]
    return WholeSystem(problem, gone, numbers)


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
    found: CodeResidual = residuals.add_code(code, checked=True)
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


class _Window:
    """One marginalisation.

    Attributes
    ----------
    absorbed : names of earlier priors that become part of the new one
    """

    def __init__(self, model: Any, system: System, gone: Masks, first_estimates: bool) -> None:
        self.system, self.gone = system, gone
        self.layout = system.layout
        self.store = model._store
        self.known = priors(model)
        self.absorbed: list[str] = []
        numbers = {
            (entity.table, use.column): (number, k)
            for number, entity in enumerate(self.layout.entities)
            for k, use in enumerate(entity.params)
        }
        self.places: dict[str, list[Place]] = {}
        for label, code in self.known.items():
            self.places[label] = [
                (number, 0 if handle < 0 else int(self.store.tables[path].row_of(handle)), k)
                for path, column, handle in code.keys
                for number, k in [numbers[path, column]]
            ]
        self.bases: dict[Place, Floats] = {}
        for label, code in self.known.items() if first_estimates else ():
            for place, part in zip(self.places[label], code.function.parts, strict=True):
                self.bases.setdefault(place, part.base)

    def absorb(self) -> None:
        """Choose earlier priors: those of rows that leave, and those that cause no fill."""
        self.neighbours = self.system.neighbours()
        waiting = {}
        for label, places in self.places.items():
            if any(self._leaves(place) for place in places):
                self._take(label)
            else:
                waiting[label] = set(places)
        merged = bool(self.neighbours)
        while merged:
            merged = False
            for label, own in list(waiting.items()):
                if own <= self.neighbours or self.neighbours <= own:
                    self._take(label)
                    del waiting[label]
                    merged = True

    def _leaves(self, place: Place) -> bool:
        mask = self.gone.get(self.layout.entities[place[0]].table)
        return mask is not None and bool(mask[place[1]])

    def _take(self, label: str) -> None:
        self.absorbed.append(label)
        for place in self.places[label]:
            if not self._leaves(place) and self.system.free_of(place).any():
                self.neighbours.add(place)

    def eliminated(self) -> tuple[Prior | None, list[Key]]:
        """The prior on the neighbours, and their keys."""
        places = sorted(self.neighbours)
        self._refuse(places)
        bases = {
            place: base for place, base in self.bases.items() if self.system.free_of(place).any()
        }
        parts = [self.system.linearise(bases)]
        parts += [self._linear_prior(label, bases) for label in self.absorbed]
        at = [self.system.columns_of(place) for place in places]
        staying = np.concatenate(at or [np.zeros(0, np.int64)])
        used = np.concatenate([columns for _, _, columns in parts])
        leaving = np.array(sorted({*used.tolist()} - {*staying.tolist()}), dtype=np.int64)
        order = np.concatenate([leaving, staying])
        by_column = np.argsort(order)
        jacobian = np.zeros((sum(len(r) for _, r, _ in parts), len(order)))
        first = 0
        for rows, _, columns in parts:
            where = by_column[np.searchsorted(order, columns, sorter=by_column)]
            jacobian[first : first + len(rows), where] = rows
            first += len(rows)
        residual = np.concatenate([r for _, r, _ in parts])
        tolerance = _epsilon(self.layout.precision) ** 0.75
        found = eliminate(jacobian, residual, len(leaving), tolerance)
        if not len(found.residual):
            return None, []
        kept = []
        for place in places:
            use = use_of(self.layout, place)
            base = bases.get(place)
            kept.append(
                Part(use.kind, self.system.value_at(place) if base is None else base, use.tangent)
            )
        constant = found.constant + sum(
            self.known[label].function.constant for label in self.absorbed
        )
        prior = Prior(kept, found.jacobian, found.residual, constant, found.undetermined)
        return prior, [self._key(place) for place in places]

    def _linear_prior(
        self, label: str, bases: Mapping[Place, Floats]
    ) -> tuple[Floats, Floats, NDArray[np.int64]]:
        """Jacobian, residuals and columns of an earlier prior, as `System.linearise`."""
        prior, places = self.known[label].function, self.places[label]
        columns = [self.system.columns_of(place) for place in places]
        if all(
            bases.get(place) is part.base and self.system.free_of(place).all()
            for place, part in zip(places, prior.parts, strict=True)
        ):
            return prior.jacobian, prior.residual, np.concatenate(columns)
        values = [self.system.value_at(place) for place in places]
        at = [bases.get(place, value) for place, value in zip(places, values, strict=True)]
        residual, _ = prior(*(value[None] for value in values), row=None)
        _, blocks = prior(*(value[None] for value in at), row=None)
        jacobian, used = [], []
        for k, place in enumerate(places):
            free = self.system.free_of(place)
            if not free.any():
                continue
            jacobian.append(np.where(free, blocks[k][:, 0], 0.0))
            used.append(columns[k])
            if place in bases:
                moved = difference(prior.parts[k].kind, at[k][None], values[k][None])[0]
                residual -= jacobian[-1] @ moved
        if not used:
            return np.zeros((len(residual), 0)), residual, np.zeros(0, dtype=np.int64)
        return np.hstack(jacobian), residual, np.concatenate(used)

    def _key(self, place: Place) -> Key:
        path = self.layout.entities[place[0]].table
        handle = int(self.store.tables[path].handles(np.array([place[1]]))[0]) if path else -1
        return path, use_of(self.layout, place).column, handle

    def _refuse(self, places: list[Place]) -> None:
        """Refuse neighbours that no prior can be on."""
        width = 0
        for place in places:
            entity, use = self.layout.entities[place[0]], use_of(self.layout, place)
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


def _touching(problem: Problem, number: int, gone: Masks) -> NDArray[np.bool_]:
    """Active instances of a group that read a row that leaves."""
    structure = problem.structure
    return touching(
        problem.layout.groups[number], structure.active[number], structure.slot_rows[number], gone
    )


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
