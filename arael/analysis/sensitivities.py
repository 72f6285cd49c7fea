"""Derivatives of a solved quantity by data, fixed parameters, bounds and constants."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.adjoint import (
    Derivatives,
    Place,
    Varied,
    by_tangent,
    code_products,
    constant_products,
    gradient_products,
)
from arael.analysis.implicit import ImplicitSystem
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.problem import Problem
from arael.runtime.system import row_name

Floats = NDArray[np.float64]

_SHOWN = 20
"""Most columns listed as text."""


@dataclass(frozen=True)
class Quantity:
    """One or more scalars of a solution, with their derivatives at constant data or parameters.

    Attributes
    ----------
    text : as it was asked for
    names : (k,) of the scalars
    by_parameters : (k, size) over the scalars of the system
    direct : per scalar, derivatives by data and states that its formula reads; None: of a name
    by_constant : the same by a constant, (k, scalars)
    """

    text: str
    names: tuple[str, ...]
    by_parameters: Floats
    direct: tuple[Derivatives, ...] | None = None
    by_constant: Callable[[str], Floats] | None = None

    @property
    def single(self) -> bool:
        """Whether it is one scalar, and not a vector of one."""
        return self.names == (self.text,)


def named_quantity(system: ImplicitSystem, text: str) -> Quantity | None:
    """The scalar, or the scalars of the row or parameter, of that name; None if none is free."""
    names, free = system.names, system.free
    at = system.numbers.get(text)
    within = [] if at is None else [at]
    within = within or [k for k in free if names[k].startswith((f"{text}.", f"{text}["))]
    if not within:
        return None
    unit = np.zeros((len(within), len(names)))
    unit[np.arange(len(within)), within] = 1
    return Quantity(text, tuple(names[k] for k in within), unit)


def joined(quantities: Sequence[Quantity]) -> Quantity:
    """Several quantities as one."""
    if len(quantities) == 1:
        return quantities[0]
    direct: list[Derivatives] = []
    for one in quantities:
        direct += one.direct or [Derivatives() for _ in one.names]
    return Quantity(
        ", ".join(one.text for one in quantities),
        tuple(name for one in quantities for name in one.names),
        np.concatenate([one.by_parameters for one in quantities]),
        tuple(direct) if any(one.direct for one in quantities) else None,
        partial(_joined_by_constant, quantities),
    )


def _joined_by_constant(quantities: Sequence[Quantity], name: str) -> Floats:
    """(k, scalars) direct derivatives of several quantities by a constant; or (k, 1) zeros."""
    parts = [
        np.zeros((len(one.names), 1)) if one.by_constant is None else one.by_constant(name)
        for one in quantities
    ]
    scalars = max(part.shape[1] for part in parts)
    return np.concatenate([np.broadcast_to(part, (len(part), scalars)) for part in parts])


class Sensitivity(Displayed, Mapping[str, Floats]):
    """Derivatives of a solved quantity, by the path of what it is differentiated by.

    ``found["views.uv"]`` has the shape of the column, (rows, ...); of the root's data and of a
    constant that of one value. A quantity of several scalars has an axis of them in front. Data
    that no residual reads has zeros. ``found["cam.f"]`` of a parameter is the derivative by what is
    fixed or frozen of it, (rows, tangent), with zeros for what is solved for;
    ``found["cam.f.low"]`` that by an active bound.

    Attributes
    ----------
    of : what is differentiated
    names : (k,) its scalars
    hessian : ``"Gauss-Newton"`` or ``"exact"``: which Hessian of the cost was used. With the first,
        derivatives lack the terms in which residuals multiply second derivatives by parameters
    """

    def __init__(
        self, of: str, names: tuple[str, ...], hessian: str, by: Mapping[str, _Column]
    ) -> None:
        self.of, self.names, self.hessian = of, names, hessian
        self._by = dict(by)

    def __getitem__(self, path: str) -> Floats:
        return self._by[path].values

    def __iter__(self) -> Iterator[str]:
        return iter(self._by)

    def __len__(self) -> int:
        return len(self._by)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Floats:
        if len(self._by) != 1:
            raise ValueError(f"derivatives by {len(self._by)} columns: choose one by its path")
        (only,) = self._by.values()
        return np.array(only.values, dtype=dtype)

    @property
    def rows(self) -> list[tuple[str, float, str]]:
        """Path, root of the sum of squares, and place of the largest entry, of each column."""
        found = [
            (path, float(np.linalg.norm(one.values)), one.largest) for path, one in self._by.items()
        ]
        return sorted(found, key=lambda row: -row[1])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "of": self.of,
            "names": list(self.names),
            "hessian": self.hessian,
            "by": {path: one.values.tolist() for path, one in self._by.items()},
        }

    def _title(self) -> str:
        return f"sensitivity of {self.of} ({self.hessian} Hessian)"

    def _sheet(self) -> Sheet:
        rows = [(path, f"{size:.4g}", largest) for path, size, largest in self.rows[:_SHOWN]]
        return Sheet(self._title(), ("by", "norm", "largest"), rows)

    def __repr__(self) -> str:
        return f"<{self._title()} by {len(self._by)} columns>"

    def __str__(self) -> str:
        rows = self.rows[:_SHOWN]
        width = max((len(path) for path, _, _ in rows), default=0)
        lines = [
            f"  {path:<{width}}  norm {size:.4g}, largest {largest}" for path, size, largest in rows
        ]
        left = len(self._by) - len(rows)
        more = [f"  and {left} more"] if left else []
        return "\n".join([self._title(), *lines, *more])


@dataclass(frozen=True)
class _Column:
    """Derivatives by one column.

    Attributes
    ----------
    values : (scalars of the quantity, rows, *tail), without the first axis of a single scalar and
        without that of rows of the root
    tail : shape of one value of the column
    """

    values: Floats
    problem: Problem = field(repr=False)
    table: str
    label: str
    tail: tuple[int, ...]

    @property
    def largest(self) -> str:
        """Value and name of the largest entry."""
        if not self.values.any():
            return "0"
        at = np.unravel_index(int(np.abs(self.values).argmax()), self.values.shape)
        first = len(at) - len(self.tail)
        place = self.label
        if self.table:
            row = row_name(self.problem.store, self.table, int(at[first - 1]))
            place = f"{row}.{self.label}"
        inner = "".join(f"[{k}]" for k in at[first:])
        return f"{self.values[at]:.4g} at {place}{inner}"


class Sensitivities:
    """Derivatives of quantities of one solution; the factor serves all of them.

    Parameters
    ----------
    system : of the solution
    constants : names of the constants of the model
    varied : the groups that read one of these; None if none does
    """

    def __init__(
        self,
        system: ImplicitSystem,
        constants: Sequence[str] = (),
        varied: Callable[[str], Varied | None] = lambda name: None,
    ) -> None:
        self.system, self.problem = system, system.problem
        self._constants, self._varied = constants, varied

    def of(self, quantity: Quantity, to: Sequence[str] | None, exact: bool) -> Sensitivity:
        """Derivatives of a quantity.

        Parameters
        ----------
        to : paths of columns, or of what contains them; None: all

        Raises
        ------
        AraelError
            E1060: no such path, or the exact Hessian is not positive definite.
        """
        chosen = self._chosen(to)
        found = [
            self._by_everything(quantity, k, chosen, exact) for k in range(len(quantity.names))
        ]
        columns = {
            path: self._column(target, [one[path] for one in found], quantity.single)
            for path, target in chosen.items()
        }
        hessian = "exact" if exact else "Gauss-Newton"
        return Sensitivity(quantity.text, quantity.names, hessian, columns)

    def _by_everything(
        self, quantity: Quantity, k: int, chosen: Mapping[str, _Target], exact: bool
    ) -> dict[str, Floats]:
        problem = self.problem
        right = quantity.by_parameters[k]
        v = self.system.adjoint(right, exact)
        places = [one.place for one in chosen.values() if one.place is not None]
        held = any(one.place is None and one.varied is None for one in chosen.values())
        implicit = gradient_products(problem, v, columns=places, states=False)
        direct = quantity.direct[k] if quantity.direct is not None else Derivatives()
        steps: list[Floats] = []
        if held:
            # Few rows are held: only the instances that use one are differentiated by states.
            by_held = gradient_products(problem, v, columns=(), touching=self._held_rows)
            steps = [-one for one in by_tangent(problem, by_held.states)]
            self._add_code(steps, v)
            if direct.states:
                own = by_tangent(problem, direct.states)
                steps = [a + b for a, b in zip(steps, own, strict=True)]
        found = {}
        for path, target in chosen.items():
            if target.varied is not None:
                value = -constant_products(problem, target.varied, v).reshape(target.shape)
                if quantity.by_constant is not None:
                    own = quantity.by_constant(path)[k]
                    value += np.broadcast_to(own, value.size).reshape(target.shape)
            elif target.place is not None:
                value = np.zeros(target.shape)
                for sign, part in ((-1.0, implicit.data), (1.0, direct.data)):
                    if target.place in part:
                        value += sign * part[target.place].reshape(target.shape)
            else:
                value = np.where(target.mask, steps[target.entity][:, target.tangents], 0.0)
                if quantity.direct is None:
                    value += self._of_system(target, right)
            found[path] = value
        return found

    def _of_system(self, target: _Target, right: Floats) -> Floats:
        """Derivatives of a named quantity by scalars on a bound, which may be the quantity."""
        first = self.problem.structure.system.blocks[target.entity].first
        at = first[:, None] + np.arange(target.tangents.start, target.tangents.stop)
        there = target.mask & (first >= 0)[:, None]
        return np.where(there, right[np.where(there, at, 0)], 0.0)

    def _add_code(self, steps: list[Floats], v: Floats) -> None:
        """Add what residuals by own code have to derivatives by held scalars of the system."""
        own = code_products(self.problem, v)
        if not own.any():
            return
        for blocks, one in zip(self.problem.structure.system.blocks, steps, strict=True):
            rows = np.flatnonzero(blocks.first >= 0)
            one[rows] -= own[blocks.first[rows, None] + np.arange(one.shape[1])]

    def _column(self, target: _Target, parts: list[Floats], single: bool) -> _Column:
        values = parts[0] if single else np.stack(parts)
        tail = target.shape[1:]
        if not target.table:  # the one row of the root
            values = values[0] if single else values[:, 0]
        return _Column(values, self.problem, target.table, target.label, tail)

    # --- what there is ------------------------------------------------------------------------

    @cached_property
    def _targets(self) -> dict[str, _Target]:
        """All that can be differentiated by, by path."""
        return {**self._data(), **self._held(), **self._bounds()}

    def _data(self) -> dict[str, _Target]:
        problem = self.problem
        read: dict[Place, None] = {}
        for group in problem.layout.groups:
            for raw in group.raw:
                read[group.slots[raw.slot].table, raw.column] = None
            for total in group.totals:
                for raw in total.raw:
                    read[total.slots[raw.slot].table, raw.column] = None
        found = {}
        for table, column in read:
            if column.endswith("?") or "#" in column:
                continue
            known = problem.layout.table(table).column(column)
            if known.role != "data" or known.kind != "real":
                continue
            values = problem.store.tables[table].column(column)
            name = table.removesuffix("/rows")
            path = f"{name}.{column}" if table else column
            found[path] = _Target(table, column, (len(values), *known.shape), (table, column))
        return found

    def _held(self) -> dict[str, _Target]:
        found = {}
        for number, path, use, mask in self._parameters():
            first = use.tangent_start
            at = slice(first, first + use.tangent)
            held = mask[:, at]
            if held.any():
                entity = self.problem.layout.entities[number]
                found[path] = _Target(
                    entity.table, use.column, held.shape, None, number, first, held
                )
        return found

    @cached_property
    def _held_rows(self) -> list[NDArray[np.bool_]]:
        """Per entity, (rows,) whether a scalar is held that can be differentiated by."""
        found = [np.zeros(len(one.free), dtype=bool) for one in self._blocks]
        for target in self._targets.values():
            if target.place is None:
                found[target.entity] |= target.mask.any(axis=1)
        return found

    @property
    def _blocks(self) -> Any:
        return self.problem.structure.system.blocks

    def _bounds(self) -> dict[str, _Target]:
        if not self.system.on_bound:
            return {}
        found: dict[str, _Target] = {}
        system = self.problem.structure.system
        names = self.system.names
        for name, text in self.system.on_bound.items():
            number, row, tangent = system.owner(names.index(name))
            entity = self.problem.layout.entities[number]
            use = next(
                u for u in entity.params if u.tangent_start <= tangent < u.tangent_start + u.tangent
            )
            end = "low" if "lower" in text else "high"
            column = f"{use.column}.{end}"
            path = f"{entity.table}.{column}" if entity.table else column
            if path not in found:
                size = self.problem.store.tables[entity.table].size
                mask = np.zeros((size, use.tangent), dtype=bool)
                found[path] = _Target(
                    entity.table, column, mask.shape, None, number, use.tangent_start, mask
                )
            found[path].mask[row, tangent - use.tangent_start] = True
        return found

    def _parameters(self) -> Iterator[tuple[int, str, Any, NDArray[np.bool_]]]:
        """Entity, path, use, and (rows, tangent) what of its rows is there and does not move."""
        problem = self.problem
        for number, (entity, blocks) in enumerate(
            zip(problem.layout.entities, problem.structure.system.blocks, strict=True)
        ):
            table = problem.store.tables[entity.table]
            for use in entity.params:
                if not use.tangent:
                    continue
                present = np.asarray(table.present(use.column), dtype=bool)
                mask = ~np.asarray(blocks.free, dtype=bool) & present[:, None]
                path = f"{entity.table}.{use.column}" if entity.table else use.column
                yield number, path, use, mask

    def _chosen(self, to: Sequence[str] | None) -> dict[str, _Target]:
        if to is None:
            return self._targets
        found: dict[str, _Target] = {}
        for path in to:
            within = {
                known: target
                for known, target in self._targets.items()
                if known == path or known.startswith(f"{path}.")
            }
            if path in within:
                within = {path: within[path]}
            if not within and path in self._constants:
                within = {path: self._constant(path)}
            if not within:
                raise self._unknown(path)
            found |= within
        return found

    def _constant(self, name: str) -> _Target:
        """The target of a constant that a residual of the problem reads."""
        varied = self._varied(name)
        if varied is None:
            raise self._unknown(name)
        return _Target("", name, (1, *varied.shape), None, varied=varied)

    def _unknown(self, path: str) -> AraelError:
        near = closest(path, [*self._targets, *self._constants])
        solved = any(path == known for _, known, _, _ in self._parameters())
        tables = {
            f"{one.collection}.{column}"
            for group in self.problem.layout.groups
            for one in group.look_ups
            for column in (one.key, one.column)
        }
        advice = (
            "it is read by a look-up, by whose rows no derivative is taken"
            if path in tables
            else "it is solved for; fix or freeze it, or take the derivative by data or a bound"
            if solved
            else f"did you mean `{near[0]}`?"
            if near
            else f"there are {', '.join(list(self._targets)[:10]) or 'none'}"
        )
        return AraelError(
            Diagnostic(
                "E1060",
                f"no residual reads data, a constant or a fixed parameter `{path:.60}`",
                origin="sensitivity",
                help=(advice,),
            )
        )


@dataclass(frozen=True)
class _Target:
    """What to differentiate by: data at a place, held scalars of a parameter, or a constant."""

    table: str
    label: str
    shape: tuple[int, ...]
    place: Place | None
    entity: int = -1
    first: int = 0
    mask: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    varied: Varied | None = None

    @property
    def tangents(self) -> slice:
        """The tangent scalars of the parameter within those of its entity."""
        return slice(self.first, self.first + self.shape[1])


def paths_of(to: str | Iterable[str] | None) -> list[str] | None:
    """The paths asked for, as a list."""
    if to is None or isinstance(to, str):
        return None if to is None else [to]
    paths = [*to] if isinstance(to, Iterable) else [to]
    if not all(isinstance(path, str) for path in paths):
        raise wrong_argument("sensitivity", "to", "paths of columns", to)
    return paths
