"""`Model.update`: an estimate after every change, from a factor that is kept."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from arael import solving
from arael.diagnostics.arguments import wrong_argument
from arael.online.priors import only_priors
from arael.online.result import UpdateResult
from arael.online.tracker import Tracker
from arael.runtime.evaluation.unbound import require_bound
from arael.runtime.incremental.compiled import Linearisations
from arael.runtime.layout import Layout
from arael.runtime.machine.compiled import NativeTable
from arael.session import Session, session_of

# Residuals that are off by more than this part of their root mean square from what the
# linearisation predicts have their parameters linearised anew. Steps are as exact, by the standard
# deviations of each scalar given all others. On public pose graphs costs stay within 4e-6 of the
# optimum, most steps within 1e-6; 1e-3 left them 5e-6 above it in the same time, as what is
# neglected adds up.
TOLERANCE = 1e-5

# Residuals are seldom as large as their standard deviations say. Tolerances are by their root mean
# square, so that they bound the cost relative to itself; it counts as at least this part.
LEAST = 0.01

# Another step is taken where it may gain more than this part of the cost; a smaller gain is left to
# the next update, which linearises the same parameters anew.
GAIN = 2e-7

# Steps that one update takes at most; most take one.
MAX_STEPS = 10

# Scalars of a row, each of which has place for the widest of the model.
WIDEST = 64

# Parts by which the cost may rise, as the estimates are exact to tolerances, and to rounding.
RISE = 1e-3
EXACT_RISE = 1e-9

# A cost that has grown by this factor means that the steps diverge.
DIVERGED = 1e3


def update(
    model: Any,
    *,
    tolerance: float = TOLERANCE,
    max_seconds: float | None = None,
    freeze: str | Iterable[str] = (),
) -> UpdateResult:
    """Take in what has changed since the last update, and write the new estimates into the model.

    See `Model.update`.
    """
    began = time.perf_counter()
    _check(tolerance, max_seconds)
    store = model._store
    store.check_complete()
    frozen = solving.frozen_by(_posed(model)[0], (), freeze)
    session = session_of(model)
    with store.use.solving():
        reason, priors = unsupported(model), only_priors(model) or {}
        if reason:
            session.online = None
        else:
            _check_rows(model, priors)
            with session.held() as held:
                found = _online(model, held, tolerance, max_seconds, frozen, priors, began)
            if found is not None:
                return found
            reason = "a step raised the cost"
        settings: dict[str, Any] = {} if max_seconds is None else {"time_limit": max_seconds}
        solved = solving.solve(model, passes=[], freeze=freeze, **settings)
        if session.online is not None:
            with session.held() as held:
                _factor_at_values(held, frozen, priors)
    return UpdateResult(
        cost=solved.end_cost,
        steps=solved.iterations,
        full=True,
        reason=reason,
        seconds=time.perf_counter() - began,
        solved=solved,
    )


def _posed(model: Any) -> tuple[Layout, Any, Any]:
    """Layout, data and programs of a model, without its priors if these are all that was added."""
    if only_priors(model) is None:
        return solving.posed(model)
    return model._compiled.layout, model._store, None


def _check_rows(model: Any, priors: Mapping[str, Any]) -> None:
    """Raise what a solve raises if a prior reads a row that was removed."""
    tables = model._store.tables
    handles: dict[str, set[int]] = {}
    for code in priors.values():
        for path, _, handle in code.keys:
            handles.setdefault(path, set()).add(handle)
    for path, some in handles.items():
        if path and (tables[path].rows_of(np.array([*some])) < 0).any():
            solving.posed(model)


def unsupported(model: Any) -> str:
    """Why a model is solved in full by every update; "" if it is not."""
    layout, store, _ = _posed(model)
    if layout.precision != "f64":
        return "the model is in f32"
    if getattr(store, "hooks", None) or getattr(store, "updates", None):
        if only_priors(model) is None and len(model.residuals.priors) == len(model.residuals.code):
            return "there are priors beside other residuals that were added at run time"
        return "functions of the caller evaluate residuals"
    if any(entity.tangent > WIDEST for entity in layout.entities):
        return f"a row has more than {WIDEST} scalars"
    if layout.summed:
        return "constraints with sums over rows are evaluated term by term"
    if any(layout.bounded) or any(store.tables[e.table].bounds_version for e in layout.entities):
        return "parameters have bounds"
    if any(group.require for group in layout.groups):
        return "rows of it must hold exactly"
    if any(group.look_ups for group in layout.groups):
        return "constraints look up between rows"
    if any(group.index_column for group in layout.groups):
        return "constraints are numbered"
    return ""


def _check(tolerance: float, max_seconds: float | None) -> None:
    if not isinstance(tolerance, int | float) or not tolerance >= 0:
        raise wrong_argument("update", "tolerance", "a number that is not negative", tolerance)
    if max_seconds is not None and not (isinstance(max_seconds, int | float) and max_seconds > 0):
        raise wrong_argument("update", "max_seconds", "a positive number of seconds", max_seconds)


def _tracker(model: Any, session: Session) -> Tracker:
    """The tracker of the session, a new one if the model's residuals or kernels are others."""
    layout, store, programs = _posed(model)
    kernels = model._compiled.kernels
    found = session.online
    if (
        isinstance(found, Tracker)
        and found.layout is layout
        and found.store is store
        and found.kernels is kernels
    ):
        return found
    bindings = {**(model._compiled.bindings or {}), **getattr(store, "bindings", {})}
    natives = NativeTable([f for f in layout.functions if f.native], bindings)
    require_bound(layout, natives)
    session.online = made = Tracker(layout, store, kernels, programs, natives)
    return made


def _online(
    model: Any,
    session: Session,
    tolerance: float,
    max_seconds: float | None,
    frozen: frozenset[str],
    priors: Mapping[str, Any],
    began: float,
) -> UpdateResult | None:
    """An update by Gauss-Newton steps; None, with nothing written, if these raise the cost."""
    if session is session_of(model):
        solving.change_over(model, session)
    try:
        with model._store.use.lock:
            tracker = _tracker(model, session)
            tracker.take(frozen, priors)
        engine = tracker.engine
        if tolerance == 0:
            engine.relinearise_all()
        relinearised = refactored = steps = left = 0
        start = math.nan
        while True:
            engine.prepare()
            relinearised += engine.relinearised
            if steps == 0:
                start = engine.cost
            precise = tolerance * _root_mean_square(engine)
            left = engine.step(precise or math.inf, precise)
            refactored += engine.tree.refactored
            steps += 1
            if left == 0 or steps >= MAX_STEPS or not engine.cost <= DIVERGED * start:
                break
            if engine.error <= GAIN * engine.cost and engine.cost <= start * (1 + RISE):
                break
            if max_seconds is not None and time.perf_counter() - began > max_seconds:
                break
        limit = start * (1 + (RISE if tolerance else EXACT_RISE)) + 1e-12
        if not (math.isfinite(engine.cost) and engine.cost <= limit):
            engine.take_moved()
            return None
        moved = tracker.put_back()
    except BaseException:
        session.online = None  # the next update starts from the data
        raise
    return UpdateResult(
        cost=engine.cost,
        steps=steps,
        moved=sum(map(len, moved.values())),
        moved_rows=moved,
        relinearised=relinearised,
        refactored=refactored,
        deferred=left,
        undetermined=engine.tree.undetermined,
        seconds=time.perf_counter() - began,
    )


def _root_mean_square(engine: Linearisations) -> float:
    """Of the residuals at the estimates: in [LEAST, 1]."""
    square = engine.cost / max(engine.tree.live_rows, 1)
    return math.sqrt(min(max(LEAST * LEAST, square), 1.0))


def _factor_at_values(session: Session, frozen: frozenset[str], priors: Mapping[str, Any]) -> None:
    """Linearise and factor at the values of the store, after a solve."""
    tracker: Tracker = session.online
    try:
        tracker.forget()
        tracker.take(frozen, priors)
        tracker.engine.prepare()
        tracker.engine.factorise()
    except BaseException:
        session.online = None
        raise
