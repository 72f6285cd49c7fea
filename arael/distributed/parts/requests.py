"""What a worker is asked for.

Every request has all that it takes to be answered by a worker that has never heard of the part: the
recipe of the part, the state, the damping. What a worker keeps between requests only saves time. So
a request may be repeated anywhere, at any time, and gives the same answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from threading import Lock, RLock
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from arael.compiled_model import CompiledModel
from arael.diagnostics.records import Diagnostic
from arael.distributed.compiled import load
from arael.distributed.parts.boundary import Boundary, BoundarySystem
from arael.distributed.parts.data import columns_of, rows_of_share
from arael.distributed.parts.part import Part, Reduced, number_as_whole
from arael.distributed.parts.shares import Share, lenient
from arael.io import npz
from arael.runtime.layout import PassSetting
from arael.runtime.levenberg.diagnosis import find_non_finite, non_finite
from arael.runtime.store import Store

Floats = NDArray[np.float64]

_KEPT_RUNS = 2
"""Runs of which a worker keeps parts: others were solved before."""


@dataclass(frozen=True)
class PartRecipe:
    """All that a part is made of.

    Attributes
    ----------
    run : name of the solve
    turn : number of the pass
    model : SHA-256 of the compiled model, which the client vouches for; or a name by `name_here`
    share : rows of the part
    path : of the data set; None: `arrays` are the rows of the part
    frozen : paths of parameters that do not move in this pass
    settings : root data of this pass and of those before
    base : stored scalars at the beginning of the pass, where they are not those of the data
    """

    run: str
    turn: int
    model: str
    share: Share
    path: str | None
    arrays: dict[str, NDArray[Any]] | None
    frozen: frozenset[str] = frozenset()
    settings: tuple[PassSetting, ...] = ()
    base: Floats | None = None


@dataclass(frozen=True)
class Point:
    """A state of a part: its number in the run, and the stored scalars of the part's rows."""

    number: int
    x: Floats


@dataclass(frozen=True)
class Damped:
    """A factor of a part: its number in the run, the state, and the damped diagonal (interior,)."""

    number: int
    at: Point
    diagonal: Floats


@dataclass(frozen=True)
class Right:
    """A right-hand side (interior,) and its number; None: the negative gradient of the factor."""

    number: int
    values: Floats | None = None


@dataclass
class Kept:
    """A part with what the last requests made of it."""

    part: Part
    lock: Any = field(default_factory=RLock)
    at: int = -1  # numbers of states, factors and right-hand sides
    linearised: int = -1
    factor: int = -1
    failed: int = 0
    right: tuple[int, int] = (-1, -1)
    values: Floats = field(default_factory=lambda: np.zeros(0))
    swept: Floats = field(default_factory=lambda: np.zeros(0))
    gradient: Floats = field(default_factory=lambda: np.zeros(0))


_LOCK = Lock()
_PARTS: dict[tuple[str, int, int], Kept] = {}
_HERE: WeakValueDictionary[str, CompiledModel] = WeakValueDictionary()
_SYSTEMS: dict[str, tuple[BoundarySystem, int]] = {}
_RUNS: list[str] = []


def name_here(compiled: CompiledModel) -> str:
    """A name by which requests of this process find a model that was not sent."""
    name = f"here-{id(compiled)}"
    _HERE[name] = compiled
    return name


def model_of(name: str) -> CompiledModel:
    """The model of a name by `name_here`, or what has arrived with that hash.

    Raises
    ------
    AraelError
        E0883 no content of that hash has arrived, or it was changed since.
    """
    found = _HERE.get(name)
    if found is not None:
        return found
    loaded: Any = load(name)
    sent: CompiledModel = loaded.compiled
    return sent


def _begin(run: str) -> None:
    """Free what was kept of runs before the last ones."""
    with _LOCK:
        if run in _RUNS:
            return
        _RUNS.append(run)
        for old in _RUNS[:-_KEPT_RUNS]:
            for key in [key for key in _PARTS if key[0] == old]:
                del _PARTS[key]
            _SYSTEMS.pop(old, None)
        del _RUNS[:-_KEPT_RUNS]


def kept(recipe: PartRecipe) -> Kept:
    """The part of a recipe, made if this process does not have it."""
    _begin(recipe.run)
    key = (recipe.run, recipe.turn, recipe.share.number)
    found = _PARTS.get(key)
    if found is None:
        found = Kept(made(recipe))
        with _LOCK:
            found = _PARTS.setdefault(key, found)
            for old in [k for k in _PARTS if k[::2] == key[::2] and k[1] < recipe.turn]:
                del _PARTS[old]
    return found


def made(recipe: PartRecipe) -> Part:
    """Read the rows of a part, and prepare its problem."""
    model = model_of(recipe.model)
    layout = lenient(model.layout)
    store = Store(layout)
    store.kernels, store.bindings = model.kernels, model.bindings
    if recipe.path is not None:
        columns = columns_of(recipe.path, model.layout)
        npz.adopt(store, rows_of_share(layout, columns, recipe.share), columns.label)
    else:
        assert recipe.arrays is not None
        npz.adopt(store, dict(recipe.arrays), "part of the data")
    number_as_whole(store, recipe.share)
    root = store.tables[""]
    for one in recipe.settings:
        column = root.column(one.column)
        column[0] = np.reshape(np.asarray(one.value), column.shape[1:])
    part = Part(layout, store, model.kernels, recipe.share, recipe.frozen)
    if recipe.base is not None:
        part.move_to(recipe.base)
        part.problem.write_back()
        part = Part(layout, store, model.kernels, recipe.share, recipe.frozen)
    return part


# --- requests ----------------------------------------------------------------------------------


def describe(recipe: PartRecipe) -> tuple[int, bool, int]:
    """Instances that act at the start, whether guards read parameters, residuals."""
    part = kept(recipe).part
    counts = [len(rows) for rows in part.structure.active]
    residuals = sum(
        n * group.residuals for n, group in zip(counts, part.problem.layout.groups, strict=True)
    )
    return sum(counts), bool(part.problem.evaluation.guarded), residuals


def cost(recipe: PartRecipe, point: Point) -> float:
    """Sum of squared residuals of a part."""
    one = kept(recipe)
    with one.lock:
        _move(one, point)
        return one.part.cost()


def linearise(recipe: PartRecipe, point: Point) -> tuple[float, Floats, Floats]:
    """Cost, J'r and diagonal of J'J of a part, (local scalars,) each."""
    one = kept(recipe)
    with one.lock:
        return _linearise(one, point)


def explain(recipe: PartRecipe, point: Point, derivatives: bool) -> Diagnostic | None:
    """The first residual (or derivative) of a part that is not finite at a state."""
    one = kept(recipe)
    with one.lock:
        _move(one, point)
        problem = one.part.problem
        if find_non_finite(problem, derivatives) is None:
            return None
        return non_finite(problem, derivatives)


def curvature(recipe: PartRecipe, point: Point, step: Floats) -> float:
    """``step' H step`` of a part at a state."""
    one = kept(recipe)
    with one.lock:
        if one.linearised != point.number:
            _linearise(one, point)
        return one.part.curvature(step)


def eliminate(recipe: PartRecipe, damped: Damped, right: Right) -> Reduced:
    """Factorise a part and reduce it to its boundary."""
    one = kept(recipe)
    with one.lock:
        if _factorise(one, damped):
            return Reduced(one.failed, np.zeros((0, 0)), np.zeros(0))
        found = one.part.reduced(_values(one, right))
        one.right, one.swept = (damped.number, right.number), found.right
        return found


def sweep(recipe: PartRecipe, damped: Damped, right: Right) -> Floats:
    """What a right-hand side of the interior adds to that of the boundary."""
    one = kept(recipe)
    with one.lock:
        return _swept(one, damped, right)


def substitute(
    recipe: PartRecipe, damped: Damped, right: Right, found: tuple[int, Floats | None], at: Any
) -> Floats | None:
    """The interior's solution, from that of the whole boundary; None if there is none."""
    if found[1] is None:
        return None
    one = kept(recipe)
    with one.lock:
        swept = _swept(one, damped, right)
        return one.part.substituted(one.values, swept, found[1][at])


def _move(one: Kept, point: Point) -> None:
    if one.at != point.number:
        one.part.move_to(point.x)
        one.at = point.number


def _linearise(one: Kept, point: Point) -> tuple[float, Floats, Floats]:
    _move(one, point)
    found = one.part.linearise()
    one.linearised = point.number
    return found


def _factorise(one: Kept, damped: Damped) -> int:
    if one.factor != damped.number:
        if one.linearised != damped.at.number:
            _linearise(one, damped.at)
        one.failed = one.part.eliminate(damped.diagonal)
        one.factor, one.right = damped.number, (-1, -1)
        one.gradient = one.part.gradient[one.part.interior].copy()
    return one.failed


def _values(one: Kept, right: Right) -> Floats:
    one.values = -one.gradient if right.values is None else right.values
    return one.values


def _swept(one: Kept, damped: Damped, right: Right) -> Floats:
    number = (damped.number, right.number)
    if one.factor != damped.number or one.right != number:
        _factorise(one, damped)
        one.swept = one.part.sweep(_values(one, right))
        one.right = number
    return one.swept


def solve_boundary(
    run: str,
    boundary: Boundary,
    number: int,
    parts: Sequence[Reduced],
    swept: Sequence[Floats] | None,
    added: Floats,
    right: Floats,
) -> tuple[int, Floats | None]:
    """Solve the boundary system, with the factor of that number if this process has it.

    Parameters
    ----------
    number : of the factor
    parts : what the parts contribute
    swept : their contributions to the right-hand side; None: those in `parts`
    added : (n,) damping of the diagonal
    right : (n,)

    Returns
    -------
    0 and the solution; else None and 1 + the scalar of the boundary that failed, or
    -(1 + p) if part p failed
    """
    for k, one in enumerate(parts):
        if one.failed:
            return -(1 + k), None
    _begin(run)
    with _LOCK:
        known = _SYSTEMS.pop(run, None)
    system, factor = known or (BoundarySystem(boundary), -1)
    if factor != number:
        failed = system.factorise(list(parts), added)
        if failed:
            return failed, None
    found = system.solve([one.right for one in parts] if swept is None else list(swept), right)
    with _LOCK:
        _SYSTEMS[run] = (system, number)
    return 0, found
