"""Reuse of structure, buffers and linear solver between solves of a model instance."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from threading import Lock
from time import perf_counter
from typing import Any

from arael.runtime.linear.again import Choice
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.linear.small import SMALL
from arael.runtime.problem import Problem


@dataclass
class Counts:
    """Counts of the work done for a model instance; a warm solve increments `solves` only.

    Attributes
    ----------
    solves : passes that were run
    problems : computations of the structure: active instances, block pattern, scatter offsets
    analyses : orderings and symbolic factorisations of the linear solver
    gathered : constraints whose data was copied into lane order for the kernels
    """

    solves: int = 0
    problems: int = 0
    analyses: int = 0
    gathered: int = 0


@dataclass
class Session:
    """Structure, data in lane order, buffers and linear solver of the last solve of a model.

    The next solve reuses the parts that are still valid. Values, data and flags are compared each
    time, so no notification is needed. Added or removed rows and changed refs invalidate the
    structure; a new structure needs a new symbolic analysis only if the block pattern differs.
    """

    counts: Counts = field(default_factory=Counts)
    structural: tuple[Any, Any, Any] | None = None  # the structure checked, notes on it, its extent
    determined: bool = False  # whether symmetries of the cost were looked for and not found
    stamp: int = 0  # counts what used the memory of the linear solver
    swept: tuple[Any, Any] | None = None  # a solver, and where its forward sweep leaves its result
    online: Any = None  # the tracker of `Model.update`, which has a factor of its own
    _problem: Problem | None = None
    _linear: LinearSolver | None = None
    _asked: tuple[str, dict[str, Any]] | None = None
    _choice: Choice | None = None
    _starts: tuple[int, ...] = ()
    _lock: Any = field(default_factory=Lock, repr=False)

    @property
    def solver(self) -> LinearSolver | None:
        """The linear solver of the last solve."""
        return self._linear

    @property
    def earlier(self) -> Problem | None:
        """The problem of the last solve."""
        return self._problem

    def held(self) -> AbstractContextManager[Session]:
        """Yield the session, or a temporary one if a solve in it called this solve (an observer).

        Other threads do not reach this point: `Use.solving` raises for them.
        """
        return _Held(self)

    def release(self) -> None:
        """Free all memory; the next solve starts from the model's data alone."""
        self._problem = self._linear = self._asked = self._choice = None
        self.structural = self.swept = self.online = None
        self.determined = False
        self.stamp += 1

    def refreshed(self, store: Any, frozen: frozenset[str]) -> Problem | None:
        """The cached problem with current values and data; None if the structure changed."""
        found = self._problem
        if found is None:
            return None
        if store.layout.summed:
            # imported here: start-up time
            from arael.runtime.unrolled import unrolled

            store = unrolled(store.layout, store, getattr(store, "programs", None))[1]
        before = found.structure.plan
        if found.store is not store or not found.refresh(frozen):
            return None
        self.counts.problems += found.structure.plan is not before
        self.counts.gathered += found.gathered
        return found

    def keep(self, problem: Problem) -> Problem:
        """Replace the cached problem."""
        self._problem = problem
        self.counts.problems += 1
        self.counts.gathered += problem.gathered
        return problem

    def linear(
        self, problem: Problem, name: str, options: Mapping[str, Any]
    ) -> tuple[LinearSolver, float]:
        """A linear solver for the problem, the cached one if it fits, and the seconds spent."""
        self.stamp += 1
        starts = problem.structure.system.starts
        known = self._linear
        if (
            known is not None
            and self._asked is not None
            and self._asked[0] == name
            and same(self._asked[1], options)
            and self._starts == starts
            and known.pattern.same_as(problem.structure.pattern)
        ):
            known.restart()
            return known, 0.0
        self._linear = None  # free the old factor before allocating a new one
        began = perf_counter()
        found = None
        pattern = problem.structure.pattern
        plain = name == "auto" and not options and not problem.layout.marginalize
        if plain and self._choice is not None and pattern.size > SMALL:
            single = problem.layout.precision == "f32"
            found = self._choice.made_again(pattern, single)
        if found is None:
            found = problem.make_solver(name, **options)
            self._choice = Choice.of(found) if plain else None
        self._linear = found
        self._asked, self._starts = (name, dict(options)), starts
        self.counts.analyses += 1
        return found, perf_counter() - began


class _Held(AbstractContextManager[Session]):
    """What `Session.held` returns; a generator would take a microsecond more of each solve."""

    __slots__ = ("_owned", "_session")

    def __init__(self, session: Session) -> None:
        self._session, self._owned = session, False

    def __enter__(self) -> Session:
        self._owned = self._session._lock.acquire(blocking=False)
        return self._session if self._owned else Session()

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        if not self._owned:
            return
        if kind is not None:
            self._session.release()
        self._session._lock.release()


def same(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether two sets of options are known to be equal; arrays among them are not."""
    try:
        return bool(dict(a) == dict(b))
    except ValueError:
        return False


def session_of(model: Any) -> Session:
    """The session of a model instance; created on first use."""
    found = getattr(model, "_session", None)
    if not isinstance(found, Session):
        found = Session()
        object.__setattr__(model, "_session", found)
    return found
