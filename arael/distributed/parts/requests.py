"""What a worker is asked for.

A request refers to what the worker has: the part by its name, states, factors and right-hand sides
by their numbers. If the worker does not have one of these, since it is new or was started again, it
answers that, and gets the request with all that it takes: the recipe of the part, the state, the
damping. So a request may be repeated anywhere, at any time, and gives the same answer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import count
from threading import Lock, RLock
from typing import Any, Literal, NamedTuple
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
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

_SENT = np.zeros(0, dtype=bool)

_KEPT_RUNS = 2
"""Runs of which a worker keeps parts: others were solved before."""


Wanted = Literal["nothing", "right", "whole"]
"""What a sweep returns for the boundary system: its right-hand side, or S too."""

Answer = tuple[str, Any]
"""``("known", value)``; ``("unknown", None)``, send all it takes; ``("raised", exception)``."""


class UnknownError(Exception):
    """A request refers to what this process does not have."""


def answer(function: Callable[..., Any], args: tuple[Any, ...]) -> Answer:
    """Call a function of this module."""
    try:
        return "known", function(*args)
    except UnknownError:
        return "unknown", None
    except Exception as error:  # raised in the calling process
        return "raised", error


class PartName(NamedTuple):
    """The name of a part: of the solve, of the pass, and its number."""

    run: str
    turn: int
    number: int


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

    @property
    def name(self) -> PartName:
        """The name of the part."""
        return PartName(self.run, self.turn, self.share.number)


@dataclass(frozen=True)
class Point:
    """A state of a part: its number in the run, and the stored scalars of the part's rows.

    `active` are the components (components + 1,) that are linearised there; None: all; empty where
    the worker has them. Here and below arrays are None where the worker has them already.
    """

    number: int
    x: Floats | None = None
    active: Bools | None = None

    def named(self) -> Point:
        """The number alone."""
        return Point(self.number, None, None if self.active is None else _SENT)


@dataclass(frozen=True)
class Damped:
    """A factor of a part: its number in the run, the state, and the damped diagonal (interior,).

    `held` are the scalars of the part that stand at a bound, which it leaves out.
    """

    number: int
    at: Point
    diagonal: Floats | None = None
    held: Ints | None = None

    def named(self) -> Damped:
        """The numbers alone."""
        return Damped(self.number, self.at.named())


@dataclass(frozen=True)
class Right:
    """A right-hand side (interior,) and its number; `at`: the negative gradient at that state."""

    number: int
    values: Floats | None = None
    at: Point | None = None

    def named(self) -> Right:
        """The numbers alone."""
        return Right(self.number, None, self.at and self.at.named())


class BoundaryStep(NamedTuple):
    """The boundary's solution; or 1 + its scalar that failed; or the parts that had no answer."""

    x: Floats | None = None
    failed: int = 0
    missing: tuple[int, ...] = ()


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
    swept: Floats = field(default_factory=lambda: np.zeros(0))


_LOCK = Lock()
_PARTS: dict[PartName, Kept] = {}
_HERE: WeakValueDictionary[str, CompiledModel] = WeakValueDictionary()
_NUMBERS = count()
_SYSTEMS: dict[str, tuple[BoundarySystem, int]] = {}
_RUNS: list[str] = []


def name_here(compiled: CompiledModel) -> str:
    """A name by which requests of this process find a model that was not sent."""
    with _LOCK:
        known = next((name for name, one in _HERE.items() if one is compiled), "")
        name = known or f"here-{next(_NUMBERS)}"
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
            for name in [name for name in _PARTS if name.run == old]:
                del _PARTS[name]
            _SYSTEMS.pop(old, None)
        del _RUNS[:-_KEPT_RUNS]


def kept(part: PartName | PartRecipe) -> Kept:
    """The part of a name; of a recipe it is made, if this process does not have it.

    Raises
    ------
    UnknownError
        This process does not have the part, and only its name was given.
    """
    name = part if isinstance(part, PartName) else part.name
    found = _PARTS.get(name)
    if found is not None:
        return found
    if isinstance(part, PartName):
        raise UnknownError
    _begin(name.run)
    found = Kept(made(part))
    with _LOCK:
        found = _PARTS.setdefault(name, found)
        for old in [k for k in _PARTS if k[::2] == name[::2] and k.turn < name.turn]:
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


def describe(part: PartName | PartRecipe) -> tuple[int, bool, int]:
    """Instances that act at the start, whether guards read parameters, residuals."""
    own = kept(part).part
    counts = [len(rows) for rows in own.structure.active]
    residuals = sum(
        n * group.residuals for n, group in zip(counts, own.problem.layout.groups, strict=True)
    )
    return sum(counts), bool(own.problem.evaluation.guarded), residuals


def cost(part: PartName | PartRecipe, point: Point) -> float:
    """Sum of squared residuals of a part."""
    one = kept(part)
    with one.lock:
        _move(one, point)
        return one.part.cost()


def components(part: PartName | PartRecipe) -> tuple[NDArray[np.int32], Bools]:
    """Connected components of what a part evaluates.

    Returns
    -------
    labels : (local blocks,) component of each block that is of the interior or the boundary
    guarded : (components,) whether a guard of an instance of each reads parameters
    """
    found = kept(part).part.partition
    return found.of_block, found.guarded


def costs(part: PartName | PartRecipe, point: Point, active: Bools) -> Floats:
    """(components + 1,) sums of squared residuals of a part, as `Part.costs`."""
    one = kept(part)
    with one.lock:
        _move(one, point)
        return one.part.costs(active)


def linearise(part: PartName | PartRecipe, point: Point) -> tuple[float, Floats, Floats]:
    """Cost, J'r and diagonal of J'J of a part, (local scalars,) each."""
    one = kept(part)
    with one.lock:
        return _linearise(one, point)


def explain(part: PartName | PartRecipe, point: Point, derivatives: bool) -> Diagnostic | None:
    """The first residual (or derivative) of a part that is not finite at a state."""
    one = kept(part)
    with one.lock:
        _move(one, point)
        problem = one.part.problem
        if find_non_finite(problem, derivatives) is None:
            return None
        return non_finite(problem, derivatives)


def curvature(
    part: PartName | PartRecipe, point: Point, step: Floats, apart: bool = False
) -> Floats:
    """``step' H step`` of a part at a state, (1,) or `apart` (components,)."""
    one = kept(part)
    with one.lock:
        if one.linearised != point.number:
            _linearise(one, point)
        return one.part.curvature(step, apart)


def sweep(
    part: PartName | PartRecipe, damped: Damped, right: Right, wanted: Wanted = "nothing"
) -> tuple[int, Reduced | None]:
    """Factorise and sweep forward, as far as it is not done.

    Returns
    -------
    failed : 0 or 1 + the scalar that failed
    reduced : what the part has for the boundary system, as far as it is wanted; else None
    """
    one = kept(part)
    with one.lock:
        failed = _sweep(one, damped, right)
        if failed or wanted == "nothing":
            return failed, None
        return 0, _reduced(one, wanted)


def contribution(part: PartName, damped: Damped, right: Right, wanted: Wanted) -> Reduced:
    """What a part has for the boundary system, after its sweep."""
    one = kept(part)
    with one.lock:
        if _sweep(one, damped, right):
            raise UnknownError
        return _reduced(one, wanted)


def _reduced(one: Kept, wanted: Wanted) -> Reduced:
    matrix = one.part.complement() if wanted == "whole" else np.zeros((0, 0))
    return Reduced(matrix, one.swept)


def substitute(
    part: PartName | PartRecipe,
    damped: Damped,
    right: Right,
    boundary: Floats,
    point: Point | None,
    apart: bool = False,
) -> tuple[Floats, Floats]:
    """The interior's solution, from that of the part's boundary (b,).

    Returns
    -------
    solution : (interior,)
    curvature : ``x' H x`` of both at the state `point`, (1,) or `apart` (components,); (0,) without
        a state
    """
    one = kept(part)
    with one.lock:
        _sweep(one, damped, right)
        found = one.part.substituted(boundary)
        if point is None:
            return found, np.zeros(0)
        if one.linearised != point.number:
            _linearise(one, point)
        step = np.zeros(one.part.structure.system.size)
        step[one.part.interior], step[one.part.boundary] = found, boundary
        return found, one.part.curvature(step, apart)


def _move(one: Kept, point: Point) -> None:
    if one.at != point.number:
        if point.x is None:
            raise UnknownError
        one.part.move_to(point.x)
        one.at = point.number


def _linearise(one: Kept, point: Point) -> tuple[float, Floats, Floats]:
    _move(one, point)
    if point.active is not None and not len(point.active):
        raise UnknownError
    found = one.part.linearise(point.active)
    one.linearised = point.number
    return found


def _sweep(one: Kept, damped: Damped, right: Right) -> int:
    factored = one.factor == damped.number
    if factored and (one.failed or one.right == (damped.number, right.number)):
        return one.failed
    one.right = (-1, -1)
    if not factored:
        if damped.diagonal is None:
            raise UnknownError
        if one.linearised != damped.at.number:
            _linearise(one, damped.at)
        one.factor = -1
        # That of the gradient is swept with the factorisation.
        together = right.at is not None and right.at.number == damped.at.number
        values = _values(one, right) if together else np.zeros(len(one.part.interior))
        one.failed = one.part.eliminate(damped.diagonal, values, damped.held)
        one.factor = damped.number
        if one.failed:
            return one.failed
        factored = not together
    if factored:
        one.part.sweep(_values(one, right))
    one.swept = one.part.swept()
    one.right = (damped.number, right.number)
    return 0


def _values(one: Kept, right: Right) -> Floats:
    if right.values is not None:
        return right.values
    if right.at is None:
        raise UnknownError
    if one.linearised != right.at.number:
        _linearise(one, right.at)
    return np.asarray(-one.part.gradient[one.part.interior])


def solve_boundary(
    run: str,
    boundary: Boundary | None,
    number: int,
    sources: Sequence[tuple[Any, tuple[Any, ...]] | None],
    added: Floats,
    right: Floats,
    idle: Sequence[int] = (),
) -> BoundaryStep:
    """Solve the boundary system, with the factor of that number if this process has it.

    Parameters
    ----------
    boundary : of the run; None: this process has it
    number : of the factor
    sources : per part where it is (see `stations.Remote`) and the arguments of `contribution`; None
        where it adds nothing to the right-hand side of a factor that this process has
    added : (n,) damping of the diagonal
    right : (n,)
    idle : parts that add nothing to the system either: all their components have ended
    """
    _begin(run)
    with _LOCK:
        known = _SYSTEMS.pop(run, None)
    if known is None and boundary is None:
        raise UnknownError
    system, factor = known or (BoundarySystem(_given(boundary)), -1)
    whole = factor != number
    wanted = "whole" if whole else "right"
    pending = [one and one[0].start(contribution, *one[1], wanted) for one in sources]
    answers: list[Answer] = [
        ("known", None) if one is None else one[0].wait(waiting)
        for one, waiting in zip(sources, pending, strict=True)
    ]
    # Without the factor that it was to have, it needs what every part has for the matrix.
    missing = tuple(
        k
        for k, ((kind, _), one) in enumerate(zip(answers, sources, strict=True))
        if kind in ("unknown", "lost") or (whole and one is None and k not in idle)
    )
    for kind, value in answers:
        if kind == "raised":
            raise value
    failed, x = 0, None
    if not missing:
        if whole:
            failed = system.factorise([value and value.matrix for _, value in answers], added)
            factor = -1 if failed else number
        if not failed:
            x = system.solve([value and value.right for _, value in answers], right)
    with _LOCK:
        _SYSTEMS[run] = (system, factor)
    return BoundaryStep(x, failed, missing)


def _given(boundary: Boundary | None) -> Boundary:
    assert boundary is not None
    return boundary
