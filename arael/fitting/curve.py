"""The model of a fit: parameters, shared or per group, and one residual per point.

It is an ordinary model whose root and groups have the parameters, with the formula as a residual
added at run time, so that everything a model offers works on a fit.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.compiled_model import CompiledModel
from arael.compiler.compilation import compile_text
from arael.diagnostics.records import Source
from arael.fitting.formula import Formula
from arael.model import Model
from arael.runtime.problem import Problem

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LABEL = "formula"


@dataclass(frozen=True)
class Parameter:
    """One parameter of the formula.

    Attributes
    ----------
    own : whether each group has its own
    start : given start, None: it is searched
    """

    name: str
    low: float = -np.inf
    high: float = np.inf
    start: float | None = None
    fixed: bool = False
    own: bool = False


@dataclass(frozen=True)
class Points:
    """The points of a fit, without rows that lack a value.

    Attributes
    ----------
    columns : columns that the formula reads, by name, each (n,)
    sigma : (n,) standard deviations, ones if they are not known
    group : (n,) number of the group of each point
    groups : names of the groups; empty without groups
    """

    columns: Mapping[str, Array]
    sigma: Array
    group: Ints
    groups: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.sigma)

    def part(self, rows: Ints) -> Points:
        """Some of the points."""
        columns = {name: column[rows] for name, column in self.columns.items()}
        return Points(columns, self.sigma[rows], self.group[rows], self.groups)


@dataclass
class Curve:
    """Residuals and their derivatives by the parameters, over a model.

    Vectors of parameters are ``x`` (p,): the shared ones, then those of each group in turn.

    Attributes
    ----------
    model : the model
    names : (p,) ``a``, or ``a[left]`` of the group `left`
    parameters : (p,) parameter of each
    free : (p,) whether it is solved for
    """

    formula: str
    own: tuple[Parameter, ...]
    shared: tuple[Parameter, ...]
    points: Points
    loss: str | None = None
    model: Any = field(init=False)
    names: tuple[str, ...] = field(init=False)
    parameters: tuple[Parameter, ...] = field(init=False)

    def __post_init__(self) -> None:
        taken = {p.name for p in (*self.own, *self.shared)} | set(self.points.columns)
        self._group, self._sigma, self._rows = (
            _free_name(name, taken) for name in ("group", "sigma", "groups")
        )
        groups = self.points.groups if self.own else ()
        self.parameters = (*self.shared, *(p for _ in groups for p in self.own))
        self.names = (
            *(p.name for p in self.shared),
            *(f"{p.name}[{group}]" for group in groups for p in self.own),
        )
        self.free = np.array([not p.fixed for p in self.parameters])
        self.low = np.array([p.low for p in self.parameters])
        self.high = np.array([p.high for p in self.parameters])
        text = "struct Group {\n" + "".join(map(_declaration, self.own))
        text += "}\nroot Fit {\n" + "".join(map(_declaration, self.shared))
        text += f"    {self._rows}: list of Group\n}}\n" if self.own else "}\n"
        if not self.own:
            text = text[text.index("root") :]
        layout = compile_text(Source("fit", text)).layout
        self.model = Model(CompiledModel(layout, None, None, "runtime", {}))
        if self.own:
            rows = len(groups)
            start = {p.name: [_inside(p, p.start)] * rows for p in self.own}
            self.model[self._rows].extend(**start)
        for name in {p.name for p in (*self.own, *self.shared)}:
            for part in self._parts(name):
                part.fixed = bool(next(p for p in self.parameters if p.name == name).fixed)
        self.model.residuals.add(
            self._written(self.formula),
            label=LABEL,
            data={**self.points.columns, self._sigma: self.points.sigma},
            entities=self._refs(self.points.group),
            loss=self.loss,
        )
        self._load()

    def _parts(self, name: str) -> list[Any]:
        """The parameter in the model, once or once per group."""
        if any(p.name == name for p in self.own):
            return [row[name] for row in self.model[self._rows]]
        return [self.model[name]]

    def _refs(self, group: Ints) -> dict[str, Any] | None:
        return {self._group: self.model[self._rows].refs[group]} if self.own else None

    def _written(self, text: str, whitened: bool = True) -> str:
        """A formula for the model: parameters of groups through the point's group."""
        for p in self.own:
            text = re.sub(rf"(?<![\w.]){p.name}(?!\w|\s*\()", f"{self._group}.{p.name}", text)
        return f"({text}) / {self._sigma}" if whitened else text

    # --- evaluation ------------------------------------------------------------------------------

    def _load(self) -> None:
        self._problem: Problem = self.model._problem()
        self._places = _places(self._problem)

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """Residuals (n,), after whitening and loss, and their derivatives (n, p)."""
        return self._places.evaluate(self._problem, x)

    def cost(self, x: Array) -> float:
        """Sum of squared residuals; infinite where one is not finite."""
        r, _ = self(x)
        found = float(r @ r)
        return found if np.isfinite(found) else np.inf

    def predict(
        self, text: str, x: Array, columns: Mapping[str, Array], group: Ints
    ) -> tuple[Array, Array]:
        """Values (m,) of a formula of the same parameters at other points, and derivatives (m, p).

        Parameters
        ----------
        text : the formula
        columns : what it reads, each (m,)
        group : (m,) number of the group of each point
        """
        other = Curve.__new__(Curve)
        other.__dict__.update(self.__dict__)
        other.model = Model(self.model._compiled)
        if self.own:
            rows = len(self.points.groups)
            other.model[self._rows].extend(**{p.name: [1.0] * rows for p in self.own})
        other.model.residuals.add(
            other._written(text, whitened=False),
            label=LABEL,
            data={name: np.asarray(c, dtype=np.float64) for name, c in columns.items()},
            entities=other._refs(group),
        )
        other._load()
        return other(x)

    # --- the model -------------------------------------------------------------------------------

    def put(self, x: Array) -> None:
        """Store the values of the parameters in the model."""
        for k, p in enumerate(self.shared):
            self.model[p.name] = float(x[k])
        rest = x[len(self.shared) :].reshape(-1, max(len(self.own), 1))
        for k, p in enumerate(self.own):
            setattr(self.model[self._rows], p.name, rest[:, k])

    def get(self) -> Array:
        """Values of the parameters in the model."""
        shared = [float(self.model[p.name].value) for p in self.shared]
        if not self.own:
            return np.array(shared)
        rows = self.model[self._rows]
        own = np.column_stack([getattr(rows, p.name).value for p in self.own])
        return np.concatenate([np.array(shared), own.ravel()])

    def scalar(self, name: str) -> str:
        """Name in the model of a parameter of the fit."""
        if not self.own or self.names.index(name) < len(self.shared):
            return name
        row, k = divmod(self.names.index(name) - len(self.shared), len(self.own))
        return f"{self._rows}[{row}].{self.own[k].name}"


@dataclass(frozen=True)
class _Places:
    """Where the entries of a problem's only group belong in vectors and matrices over `x`.

    Attributes
    ----------
    shapes : (rows, scalars) of each entity
    flat : place of each kept entry in the matrix (n, p), flattened
    kept : entries of free parameters
    """

    shapes: tuple[tuple[int, int], ...]
    flat: Ints
    kept: NDArray[np.bool_]
    size: int

    def evaluate(self, problem: Problem, x: Array) -> tuple[Array, Array]:
        first = 0
        for entity, shape in enumerate(self.shapes):
            count = shape[0] * shape[1]
            problem.evaluation.start_at(entity, x[first : first + count].reshape(shape))
            first += count
        residuals, entries = problem.evaluation.group_rows(0)
        matrix = np.zeros(residuals.size * self.size)
        np.add.at(matrix, self.flat, entries[self.kept])
        return residuals.ravel().copy(), matrix.reshape(residuals.size, self.size)


def _places(problem: Problem) -> _Places:
    group, placement = problem.layout.groups[0], problem.structure.placements[0]
    shapes, column_of = [], np.full(problem.size + problem.structure.trash, -1, dtype=np.int64)
    size = 0
    for entity, blocks in zip(
        problem.layout.entities, problem.structure.system.blocks, strict=True
    ):
        rows = problem.store.tables[entity.table].size
        for start in np.asarray(blocks.first)[:rows].tolist():
            if start >= 0:
                column_of[start : start + entity.tangent] = size + np.arange(entity.tangent)
            size += entity.tangent
        shapes.append((rows, entity.tangent))
    points = len(placement.gradient_at)
    at = np.column_stack(
        [column_of[placement.gradient_at[:, use] + tangent] for _, use, tangent in group.jacobian]
    )
    kept = at >= 0
    flat = np.arange(points)[:, None] * size + at
    return _Places(tuple(shapes), flat[kept], kept, size)


def curve_of(
    formula: Formula, parameters: Sequence[Parameter], points: Points, loss: str | None
) -> Curve:
    """The model of a fit."""
    own = tuple(p for p in parameters if p.own)
    shared = tuple(p for p in parameters if not p.own)
    return Curve(formula.residual, own, shared, points, loss)


def _declaration(p: Parameter) -> str:
    low = repr(p.low) if np.isfinite(p.low) else ""
    high = repr(p.high) if np.isfinite(p.high) else ""
    bounds = f" in {low} .. {high}" if low or high else ""
    return f"    param {p.name}: real{bounds} = {_inside(p, p.start)!r}\n"


def _inside(p: Parameter, start: float | None) -> float:
    return float(np.clip(1.0 if start is None else start, p.low, p.high))


def _free_name(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    taken.add(name)
    return name
