"""Preparation of a solve ahead of it: the problem is built, and its linear system analysed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from arael import solving
from arael.runtime.assembly.components import partition_of
from arael.runtime.layout import LayoutPass
from arael.runtime.linear.options import typed_options
from arael.schedule import Pass, chosen_passes, frozen_after
from arael.session import session_of


def prepare(
    model: solving.Solvable,
    solver: str = "auto",
    passes: str | Pass | LayoutPass | Iterable[str | Pass | LayoutPass] | None = None,
    *,
    freeze: str | Iterable[str] = (),
    solver_options: Mapping[str, Any] | None = None,
    analyse: bool = True,
) -> None:
    """Build the problem, so that the next solve begins with its first linearisation.

    No value of the model changes. Nothing needs to be prepared again after an edit: a solve detects
    what has changed since, in values, data, flags and rows, and computes that anew.

    Parameters
    ----------
    solver, passes, freeze, solver_options : as the next `arael.solving.solve` has them; the problem
        of the first of the passes is prepared
    analyse : whether to choose the linear solver too, with its ordering, symbolic factorisation and
        memory; False leaves that to the solve

    Raises
    ------
    SolveError
        E1005, E1016, E1017: the data does not fit its constraints.
    AraelError
        As `solve`: E0702, E0820, E0840-E0842, E1011, E1012, E1040.
    """
    options = typed_options(solver, solver_options)
    store = model._store
    store.check_complete()
    layout = solving.layout_of(model)
    schedule = chosen_passes(layout, passes)
    first = schedule[0]
    frozen = frozen_after(layout, solving.frozen_by(layout, schedule, freeze), first)
    with store.use.solving(), session_of(model).held() as session, _root_of(model, first):
        if session is session_of(model):  # not within a solve
            solving.change_over(model, session)
        problem = solving.current_problem(model, session, frozen)
        if analyse:
            session.linear(problem, solver, options)
            partition_of(problem.structure, layout.groups)


@contextmanager
def _root_of(model: solving.Solvable, one: LayoutPass) -> Iterator[None]:
    """Data of the root as a pass sets it, meanwhile: guards and residuals may read it."""
    root = model._store.tables[""]
    before = {s.column: root.column(s.column).copy() for s in one.settings}
    solving.set_root(model, one)
    try:
        yield
    finally:
        for path, values in before.items():
            root.column(path)[...] = values
