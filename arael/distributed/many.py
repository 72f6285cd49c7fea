"""Many problems of one model: futures as they end, retries, what is left to do."""

from __future__ import annotations

import glob
import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from arael.compiler.cache import digest
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.progress import place_for
from arael.distributed.cluster import connect, dashboard, require_dask
from arael.distributed.compiled import Shipped, ship
from arael.distributed.groups import solve_group, solve_in_turn
from arael.distributed.progress import Solved
from arael.distributed.retries import Failed, Going
from arael.distributed.turns import sizes
from arael.distributed.work import Row, Settings, Task, read_row
from arael.model import Model

if TYPE_CHECKING:
    from distributed import Client

ROWS = "rows"
"""Folder of the rows of solved problems within that of the results."""


def map(
    model: type[Model],
    datasets: Iterable[str | os.PathLike[str]],
    client: Client | None = None,
    workers: int | None = None,
    *,
    output: str | os.PathLike[str] | None = None,
    time_limit: float | None = None,
    resume: bool = False,
    group: int = 1,
    progress: bool | None = None,
    **options: Any,
) -> Iterator[Future[Row]]:
    """Solve one problem per data file on the workers of a cluster; yield futures as they end.

    Each data file is read on its worker. A problem that fails, or ends its worker, is tried once
    more after the others, alone on another worker where there is one. Leaving the iteration early
    cancels what has not begun.

    Parameters
    ----------
    model : class that `arael.load` returned
    datasets : paths of data files, or patterns (``logs/*.npz``), as the workers see them
    client : of a running cluster (`arael.distributed.connect`); None: a local one for this call
    workers : processes of the local cluster
    output : folder for a result file per problem, which the workers see under the same path
    time_limit : seconds of one solve; a problem that takes half as long again and a second ends
        with its worker process
    resume : do not solve again what `output` has of the same model, data and options
    group : problems that go to a worker together, as one instance where their model allows
    progress : whether to count the problems that have ended, in the cell of a notebook or on a
        terminal, with the address of Dask's dashboard; None: in notebooks and at an interactive
        prompt
    options : as for ``model.solve``; they must be plain data

    Returns
    -------
    Futures with a `Row` each. A problem that could not be solved has the status ``failed``.

    Raises
    ------
    AraelError
        E0880-E0882 Dask or the cluster, E0884 the model cannot be sent, E0885 no data files,
        E0886 `resume` without `output`.
    """
    require_dask()
    paths = files_of(datasets)
    if resume and output is None:
        raise AraelError(
            Diagnostic(
                "E0886",
                "a run is resumed from its folder of results, and none is given",
                origin="resume",
                help=("add `-o results/`, or `output=` in Python",),
            )
        )
    settings = Settings(options=options, time_limit=time_limit)
    show = place_for(progress)
    return solve_files(model, paths, settings, client, workers, output, resume, group, show)


def solve_files(
    model: type[Model],
    paths: list[Path],
    settings: Settings,
    client: Client | None,
    workers: int | None,
    output: str | os.PathLike[str] | None,
    resume: bool,
    group: int,
    show: Callable[[str], object] | None = None,
) -> Iterator[Future[Row]]:
    """As `map`, for files that were found; `show` takes the text of the progress."""
    with nullcontext(client) if client is not None else connect(workers) as found:
        solved = Solved(len(paths), show, dashboard(found))
        shipped = ship(found, model)
        tasks = tasks_of(paths, shipped, settings, output)
        left = []
        for task in tasks:
            row = read_row(task) if resume else None
            if row is not None:
                solved.add(row)
                yield _ended(row)
            else:
                left.append(task)
        try:
            for future in _run(found, shipped, left, settings, max(1, group)):
                solved.add(future.result())
                yield future
        finally:
            solved.clear()


def files_of(datasets: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """Absolute paths of files given by name or pattern, each once.

    Raises
    ------
    AraelError
        E0885 if a pattern matches nothing, or nothing was given.
    """
    found: dict[Path, None] = {}
    for given in datasets:
        name = os.fspath(given)
        names = [name] if os.path.exists(name) or not glob.has_magic(name) else None
        for one in sorted(glob.glob(name, recursive=True)) if names is None else names:
            found[Path(one).absolute()] = None
            names = [one]
        if not names:
            raise _no_files(f"no file matches {name}", name)
    if not found:
        raise _no_files("no data files are given", "data")
    return list(found)


def _no_files(message: str, origin: str) -> AraelError:
    advice = "give files or a quoted pattern: 'logs/*.npz'"
    return AraelError(Diagnostic("E0885", message, origin=origin, help=(advice,)))


def tasks_of(
    paths: list[Path],
    shipped: Shipped,
    settings: Settings,
    output: str | os.PathLike[str] | None,
) -> list[Task]:
    """One task per file, named by its path below the folder that all have in common."""
    common = os.path.commonpath([path.parent for path in paths])
    shared = msgspec.msgpack.encode((shipped.identity, msgspec.to_builtins(settings)))
    folder = None if output is None else Path(output).absolute()
    tasks = []
    taken: set[str] = set()
    for path in paths:
        name = os.path.relpath(path, common).replace(os.sep, "__")
        try:
            state = path.stat()
            stamp = f"{path}:{state.st_size}:{state.st_mtime_ns}"
        except OSError:  # the worker reports what is wrong with it
            stamp = f"{path}:absent"
        key = digest(shared + stamp.encode("utf-8", "surrogateescape"))
        result = row = None
        if folder is not None:
            (folder / ROWS).mkdir(parents=True, exist_ok=True)
            written = name if path.suffix in (".npz", ".json") else f"{name}.npz"
            # `a/b` and `a__b`, or `x.csv` and `x.csv.npz`, would be one file.
            stem, ending = os.path.splitext(written)
            for k in itertools.count(2):
                if written not in taken:
                    break
                written = f"{stem}~{k}{ending}"
            taken.add(written)
            result, row = str(folder / written), str(folder / ROWS / f"{written}.json")
        tasks.append(Task(name, str(path), key, result, row))
    return tasks


def _run(
    client: Client, shipped: Shipped, tasks: list[Task], settings: Settings, group: int
) -> Iterator[Future[Row]]:
    if not tasks:
        return
    # imported here: start-up time
    from distributed import as_completed

    going: dict[Any, Going] = {}
    failed = Failed()
    make: Any = as_completed
    with client.as_current():  # whose event loop it uses
        queue = make()

    def begun(future: Any, some: list[Task], attempt: int, where: str | None = None) -> None:
        going[future.key] = Going(some, attempt, future, where)
        queue.add(future)

    def submit(solve: Any, groups: list[list[Task]]) -> None:
        # In one request: the scheduler then knows that they are many, and queues them. No list of
        # futures is kept: a worker has a result as long as a future of it exists here.
        n = len(groups)
        futures = client.map(solve, [shipped.hash] * n, groups, [settings] * n, [1] * n, pure=False)
        for future, some in zip(futures, groups, strict=True):
            begun(future, some, 1)

    left: list[Task] = []
    known: list[Row] = []
    try:
        if group > 1:
            submit(solve_group, [tasks[k : k + group] for k in range(0, len(tasks), group)])
        else:
            first = _threads(client)
            tasks, left = tasks[:first], tasks[first:]
            submit(solve_in_turn, [[task] for task in tasks])
        for ended, rows, place in _results(client, queue, going, settings):
            if left:
                known += rows
                if not going or any(row.status != "failed" for row in rows):
                    there = iter(left)
                    counts = sizes(len(left), _threads(client), known)
                    submit(solve_in_turn, [list(itertools.islice(there, n)) for n in counts])
                    left = []
            for task, row in zip(ended.tasks, rows, strict=True):
                if row.status == "failed" and ended.attempt == 1:
                    failed.add(task, place or row.worker)
                else:
                    yield _ended(row)
            if failed and not any(one.attempt == 1 for one in going.values()):
                for task, where in failed.placed(client, going.values()):
                    placed = {"workers": [where], "allow_other_workers": True} if where else {}
                    future = client.submit(
                        solve_in_turn, shipped.hash, [task], settings, 2, pure=False, **placed
                    )
                    begun(future, [task], 2, where)
    finally:
        queue.clear()
        cancel: Any = client.cancel
        cancel([one.future for one in going.values()])


def _threads(client: Client) -> int:
    nthreads: Any = client.nthreads
    return max(1, sum(int(count) for count in nthreads().values()))


def _results(
    client: Client, queue: Any, going: dict[Any, Going], settings: Settings
) -> Iterator[tuple[Going, list[Row], str]]:
    """Tasks as they end, with their rows and the place of a worker that ended, "" if none did."""
    for batch in queue.batches():
        found = _gathered(client, [one for one in batch if one.status == "finished"])
        for future in batch:
            ended = going.pop(future.key)
            if future.key in found:
                yield ended, found[future.key], ""
                continue
            why, place = _why_ended(future, settings)
            rows = [
                Row(t.name, t.data, "failed", message=why, attempts=ended.attempt, key=t.key)
                for t in ended.tasks
            ]
            yield ended, rows, place


def _gathered(client: Client, done: list[Any]) -> dict[Any, list[Row]]:
    """Rows of tasks by their keys; those that were lost with their worker since are left out."""
    gather: Any = client.gather
    try:
        # In one request: asked for each, they take most of the client's time.
        return dict(zip((one.key for one in done), gather(done), strict=True))
    except Exception:  # of a task that was repeated, and ended its worker
        found = {}
        for one in done:
            with suppress(Exception):
                found[one.key] = one.result()
        return found


def _why_ended(future: Any, settings: Settings) -> tuple[str, str]:
    """Why a task was lost, and the place of the worker that ended, "" if none did."""
    error = future.exception() if future.status == "error" else None
    if type(error).__name__ != "KilledWorker":
        return f"the task was lost: {error or future.status}", ""
    limit = settings.hard_limit
    hang = "" if limit is None else f", or the problem took longer than {limit:g} s"
    last = getattr(error, "last_worker", None)
    place: str | None = getattr(last, "nanny", None) or getattr(last, "address", None)
    return f"its worker process ended: a crash, lack of memory, a signal{hang}", place or ""


def _ended(row: Row) -> Future[Row]:
    future: Future[Row] = Future()
    future.set_result(row)
    return future
