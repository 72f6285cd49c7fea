"""Groups of problems that a worker gets at once: as one instance if possible, else in turn."""

from __future__ import annotations

import time
import warnings
from typing import Any

from arael.diagnostics.records import AraelError
from arael.distributed import joined
from arael.distributed.compiled import loaded
from arael.distributed.work import (
    ONE,
    Row,
    Settings,
    Task,
    begin,
    bounded,
    put_sigmas,
    read_problem,
    recorded,
    solve_alone,
    started,
    stored_names,
    write_result,
)
from arael.statuses import CONVERGED


def solve_group(vouched: str, tasks: list[Task], settings: Settings, attempt: int) -> list[Row]:
    """Solve problems on this worker: small ones together if their model allows, else in turn."""
    if len(tasks) < 2:
        return solve_in_turn(vouched, tasks, settings, attempt)
    begin(vouched)
    with ONE:
        return solve_together(vouched, tasks, settings, attempt)


def solve_in_turn(vouched: str, tasks: list[Task], settings: Settings, attempt: int) -> list[Row]:
    """Solve problems on this worker, each by itself."""
    begin(vouched)
    with ONE:
        return [solve_alone(vouched, task, settings, attempt) for task in tasks]


def solve_together(vouched: str, tasks: list[Task], settings: Settings, attempt: int) -> list[Row]:
    """Solve the problems of a group; `Row.together` and `Row.apart` report how."""
    try:
        kind, interpreted = loaded(vouched)
    except AraelError:  # reported as the outcome of each
        return [solve_alone(vouched, task, settings, attempt) for task in tasks]
    layout = kind.layout  # type: ignore[attr-defined]
    why = joined.why_not(layout, settings.options)
    rows: dict[int, Row] = {}
    apart = dict.fromkeys(range(len(tasks)), why)
    if not why:
        read = _read(kind, tasks, settings, attempt, rows)
        for number in rows:
            rows[number].interpreted = interpreted
        numbers = list(read)
        for group in joined.alike(list(read.values())):
            mine = [numbers[k] for k in group]
            if len(mine) == 1:
                apart[mine[0]] = "the data of its root differ from those of the others"
                continue
            try:
                with bounded(_times(settings.hard_limit, len(mine))):
                    _solve([read[k] for k in mine], [rows[k] for k in mine], kind, settings)
            except joined.Apart as refused:
                apart.update(dict.fromkeys(mine, str(refused)))
            except AraelError as error:
                text = f"together they fail: {error.diagnostics[0].message}"
                apart.update(dict.fromkeys(mine, text))
            else:
                for k in mine:
                    del apart[k]
                    with bounded(settings.hard_limit), recorded(rows[k], tasks[k]):
                        write_result(read[k], tasks[k], rows[k])
        for k in rows.keys() - read.keys():  # could not be read
            del apart[k]
    for k, reason in apart.items():
        rows[k] = solve_alone(vouched, tasks[k], settings, attempt)
        rows[k].apart = reason
    return [rows[k] for k in range(len(tasks))]


def _times(limit: float | None, count: int) -> float | None:
    return None if limit is None else limit * count


def _read(
    kind: Any, tasks: list[Task], settings: Settings, attempt: int, rows: dict[int, Row]
) -> dict[int, Any]:
    """Instances by the number of their problem; `rows` gets the rows, of failures too."""
    found = {}
    for number, task in enumerate(tasks):
        row = rows[number] = started(task, attempt)
        row.kernels = kind.compiled.origin
        with bounded(settings.hard_limit), recorded(row, Task(task.name, task.data, task.key)):
            model = read_problem(kind, task, settings, row)
            model._store.check_complete()
            found[number] = model
    return found


def _solve(models: list[Any], rows: list[Row], kind: Any, settings: Settings) -> None:
    """Solve problems as one instance; put what became of each into its instance and row."""
    began = time.perf_counter()
    with warnings.catch_warnings(action="ignore"):
        batch = joined.join(kind, models)
        ended = joined.solve(batch, settings.options, settings.time_limit)
        batch.put_back(models)
        solve = time.perf_counter() - began
        model = batch.model
        values = model.serialize().tolist()
        parameters = batch.by_owner(stored_names(model._problem()), values)
        try:
            covariance = model.covariance()
            sigmas = batch.by_owner(covariance.names, covariance.sigma().tolist())
        except AraelError:  # which of them has none is found alone
            sigmas = []
            for one, row in zip(models, rows, strict=True):
                put_sigmas(one, row)
        rest = time.perf_counter() - began - solve
    for number, (row, end) in enumerate(zip(rows, ended, strict=True)):
        row.status, row.cost, row.iterations = end.status, end.cost, end.iterations
        row.converged = all(status in CONVERGED for status in end.statuses)
        row.parameters = parameters[number]
        if sigmas:
            row.sigmas = sigmas[number]
        row.together = len(rows)
        row.seconds |= {"solve": solve / len(rows), "covariance": rest / len(rows)}
