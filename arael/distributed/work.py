"""What a worker does: read one data file, solve, write the result and its row of the table."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from arael.compiler.cache import digest
from arael.diagnostics.records import AraelError
from arael.distributed.compiled import load, loaded
from arael.io.files import write_whole
from arael.runtime.system import row_name

if TYPE_CHECKING:
    from arael.runtime.problem import Problem

TABLE_LIMIT = 1000
"""Most scalars of a problem whose parameters and sigmas are part of its row."""

ONE = threading.Lock()
"""One problem at a time in a worker process: its end on a hang must not take another with it."""


class Task(msgspec.Struct, frozen=True):
    """One problem.

    Attributes
    ----------
    data : absolute path of its file, as the worker sees it
    result, row : files to write, or None
    key : SHA-256 of the model, the settings and the file's size and time
    """

    name: str
    data: str
    key: str
    result: str | None = None
    row: str | None = None


class Settings(msgspec.Struct, frozen=True):
    """How each problem is read and solved; `options` are those of ``model.solve``."""

    format: str | None = None
    collection: str | None = None
    fields: dict[str, str] | None = None
    information: tuple[float, float] | None = None
    options: dict[str, Any] = {}
    time_limit: float | None = None

    @property
    def hard_limit(self) -> float | None:
        """Seconds after which the worker process is ended: the solve does not heed its limit."""
        return None if self.time_limit is None else 1.5 * self.time_limit + 1.0


class Row(msgspec.Struct):
    """Outcome of one problem, a row of the table.

    Attributes
    ----------
    status : as `arael.Result.status`; ``failed``: it was not solved, see `message`
    parameters : stored numbers by name, see `stored_names`. Empty beyond `TABLE_LIMIT`
    sigmas : standard errors of tangent scalars by name. Empty beyond `TABLE_LIMIT`
    seconds : of reading, the solve, the covariance and writing
    kernels : ``shipped``; ``interpreted``: on the expression machine
    interpreted : why it was, ""
    together : problems of the instance that it was solved in; times are then shares of theirs
    apart : why a problem of a group was solved by itself, ""
    key : as that of the task
    result, content : the file of the result, and its SHA-256
    """

    name: str
    data: str
    status: str
    converged: bool = False
    cost: float | None = None
    iterations: int = 0
    parameters: dict[str, float | None] = {}
    sigmas: dict[str, float | None] = {}
    seconds: dict[str, float] = {}
    message: str = ""
    worker: str = ""
    kernels: str = ""
    interpreted: str = ""
    together: int = 1
    apart: str = ""
    attempts: int = 1
    key: str = ""
    result: str = ""
    content: str = ""


def begin(vouched: str) -> None:
    """Import what a solve needs and load the model: no part of a problem's time."""
    # imported here: start-up time
    import arael.analysis.covariance
    import arael.io.json_reader
    import arael.io.npz
    import arael.solving  # noqa: F401

    # Why a model cannot be loaded is reported as the outcome of each problem.
    with contextlib.suppress(AraelError), warnings.catch_warnings(action="ignore"):
        load(vouched)


@contextlib.contextmanager
def bounded(limit: float | None) -> Iterator[None]:
    """End this process if the block takes longer than some seconds."""
    if limit is None:
        yield
        return
    with open(os.devnull, "w") as nowhere:
        # A thread of C ends the process: also if the hang holds the interpreter's lock.
        faulthandler.dump_traceback_later(limit, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()


def solve_alone(vouched: str, task: Task, settings: Settings, attempt: int) -> Row:
    """Solve one problem."""
    row = started(task, attempt)
    with bounded(settings.hard_limit), recorded(row, task):
        kind, row.interpreted = loaded(vouched)
        row.kernels = kind.compiled.origin  # type: ignore[attr-defined]
        model = read_problem(kind, task, settings, row)
        _solve(model, task, settings, row)
    return row


def started(task: Task, attempt: int) -> Row:
    """The row of a problem of which nothing is known yet."""
    return Row(task.name, task.data, "failed", attempts=attempt, key=task.key, worker=_worker())


@contextlib.contextmanager
def recorded(row: Row, task: Task) -> Iterator[None]:
    """Put what fails in the block into the row, and write the row if nothing did."""
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    except AraelError as error:
        row.status, row.converged = "failed", False
        row.message = str(error).strip()
    except Exception as error:
        row.status, row.converged = "failed", False
        row.message = f"{type(error).__name__}: {error}"
    if task.row is not None and row.status != "failed":
        _put(task.row, msgspec.json.encode(row))


def read_problem(kind: Any, task: Task, settings: Settings, row: Row) -> Any:
    """An instance with the data of a problem."""
    # imported here: start-up time
    import arael

    model = kind()
    began = time.perf_counter()
    arael.read(
        model,
        task.data,
        settings.format,
        collection=settings.collection,
        fields=settings.fields,
        information=settings.information,
    )
    row.seconds["read"] = time.perf_counter() - began
    return model


def _solve(model: Any, task: Task, settings: Settings, row: Row) -> None:
    began = time.perf_counter()
    result = model.solve(time_limit=settings.time_limit, **settings.options)
    row.seconds["solve"] = -began + (began := time.perf_counter())
    names = model.parameter_names()
    if len(names) <= TABLE_LIMIT:
        values = (float(value) for value in model.serialize())
        row.parameters = dict(zip(stored_names(model._problem()), values, strict=True))
        put_sigmas(model, row)
    row.seconds["covariance"] = time.perf_counter() - began
    write_result(model, task, row)
    row.cost, row.iterations = float(result.cost), result.iterations
    row.status = result.status
    row.converged = all(one.converged for one in result.passes or (result,))


def put_sigmas(model: Any, row: Row) -> None:
    """Put the standard errors of a problem, or why there are none, into its row."""
    try:
        covariance = model.covariance()
        sigmas = (float(value) for value in covariance.sigma())
        row.sigmas = dict(zip(covariance.names, sigmas, strict=True))
    except AraelError as error:
        row.message = error.diagnostics[0].message


def write_result(model: Any, task: Task, row: Row) -> None:
    """Write the result file of a problem, if one is asked for."""
    # imported here: start-up time
    from arael.io.formats import dump, format_of

    began = time.perf_counter()
    if task.result is not None:
        path = task.result
        content = dump(model._store, format_of(path, b""), path, None, None)
        _put(path, content)
        row.result, row.content = path, digest(content)
    row.seconds["write"] = time.perf_counter() - began


def _put(path: str, content: bytes) -> None:
    """Write a file whole, without waiting for the disk: when a run is resumed, hashes are checked.

    A problem is solved by one process at a time, so that the name beside it is free.
    """
    folder, name = os.path.split(path)
    temporary = os.path.join(folder, f".{name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        write_whole(path, lambda file: file.write(content))  # or its message


def stored_names(problem: Problem) -> list[str]:
    """Name of every number of ``model.serialize()``.

    Numbers that are no tangent scalars, as the four of a quaternion, are numbered: ``pose.q[0]``.
    """
    found = []
    system = problem.structure.system
    for entity, blocks in zip(system.layout.entities, system.blocks, strict=True):
        own = [""] * entity.stored
        for use in entity.params:
            for k in range(use.stored):
                same = use.stored == use.tangent
                tangent = entity.tangent_names[use.tangent_start + k] if same else ""
                own[use.stored_start + k] = tangent or f"{use.column}[{k}]"
        for row in np.flatnonzero(blocks.first >= 0).tolist():
            place = row_name(system.store, entity.table, row)
            found += [f"{place}.{name}" if place else name for name in own]
    return found


def _worker() -> str:
    # imported here: start-up time
    from distributed import get_worker

    try:
        worker: Any = get_worker()
    except ValueError:  # called outside a cluster
        return ""
    return str(worker.address)


def read_row(task: Task) -> Row | None:
    """Row of a problem that was solved before; None if it has to be solved again.

    That is so without a row, if it is of another model, data or settings, and if the file of the
    result is not the one that was written.
    """
    if task.row is None:
        return None
    try:
        row = msgspec.json.decode(Path(task.row).read_bytes(), type=Row)
        if row.key == task.key and digest(Path(row.result).read_bytes()) == row.content:
            return row
    except (OSError, msgspec.MsgspecError):
        pass
    return None
