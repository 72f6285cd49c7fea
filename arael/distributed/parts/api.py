"""Solve one problem in parts: the Python face."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np

import arael
from arael.compiled_model import CompiledModel
from arael.config import LmConfig
from arael.diagnostics.arguments import wrong_argument
from arael.distributed.cluster import connect, require_dask
from arael.distributed.parts.data import is_columnar
from arael.distributed.parts.executors import Executor, InProcess, OnDask
from arael.distributed.parts.solve import Solved, prepare, refusal, run
from arael.distributed.parts.stations import ask_directly
from arael.io import npz_writer
from arael.model import Model
from arael.runtime.store import Store

PATIENCE = 10.0
"""Seconds that a scheduler may take to answer."""


def solve(
    model: Model | type[Model] | str | os.PathLike[str],
    data: str | os.PathLike[str] | None = None,
    *,
    partition: int | None = None,
    partition_by: str | None = None,
    client: Any = None,
    scheduler: str | None = None,
    workers: int | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    resume: bool = False,
    config: LmConfig | None = None,
    passes: Any = None,
    freeze: Any = (),
    **settings: Any,
) -> Solved:
    """Solve one problem in parts, on the workers of a Dask cluster.

    Entities are split so that no constraint reads the interiors of two parts. A worker holds the
    rows of its parts, evaluates their constraints, and eliminates their interiors; what is between
    the parts is solved as one sparse system. Steps are accepted and the solve ends as on one
    machine: the attempts are the same, and costs agree to rounding. Connected components are solved
    separately, each with its own end (`Result.components`).

    Parameters
    ----------
    model : an instance, whose parameters are solved in place; or a loaded model, or what
        `arael.load` takes, with `data`
    data : an NPZ file, or a folder of NPZ or Parquet files with some of the rows each, of which
        every worker reads what it needs; or a file of another format, which is read here
    partition : number of parts; by default as many as there are workers
    partition_by : column of integers or strings in collections with parameters, by which entities
        are split; others follow their neighbours
    client : a `distributed.Client`; made with ``direct_to_workers=True``, vectors do not pass
        through the scheduler; or
    scheduler : address of a scheduler (``tcp://...``); or
    workers : processes to start on this machine, by default one per core; 0: all in this process
    checkpoint : file that is written after each accepted attempt
    resume : go on from that file
    config, passes, freeze, **settings : as for `arael.solving.solve`

    Returns
    -------
    Solved

    Raises
    ------
    AraelError
        E0895 a model or data that cannot be split, E0896 no such column, E0897 a checkpoint that
        does not fit, E0898 the cluster is lost; of `arael.distributed.connect` E0880 Dask is not
        installed, E0881 no scheduler answers; and what reading and solving raise.
    """
    if partition is not None and (isinstance(partition, bool) or partition < 1):
        raise wrong_argument("solve", "partition", "a number of parts from 1 up", partition)
    instance: Model | None = None
    if isinstance(model, Model):
        instance = model
    else:
        loaded: Any = model if isinstance(model, type) else arael.load(model)
        if data is None:
            raise wrong_argument(
                "solve", "data", "a file or folder, since the model has no data", data
            )
        if not is_columnar(data):
            instance = loaded()
            assert isinstance(instance, Model)
            instance.read(data)
    if instance is not None:
        compiled = instance._compiled
        _check_instance(instance)
        source: Any = dict(npz_writer.arrays_of(instance._store))
    else:
        compiled, source = loaded()._compiled, data
    if compiled.recipe is None:
        raise refusal(compiled.layout, "it was not loaded from a text", "load it with `arael.load`")
    with executor_for(client, scheduler, workers) as (executor, count):
        wanted = partition if partition is not None or partition_by is not None else count
        prepared = prepare(_ready(compiled), source, wanted, partition_by)
        found = run(
            prepared,
            executor,
            config,
            passes,
            freeze,
            checkpoint=checkpoint,
            resume=resume,
            **settings,
        )
    if instance is not None:
        put_back(found.store, instance._store)
    return found


def _ready(compiled: CompiledModel) -> CompiledModel:
    """The model with the kernels that were compiled meanwhile, if there are some."""
    return compiled.current(level=5)


def _check_instance(instance: Model) -> None:
    """Refuse residuals that are in no model text."""
    layout = instance._compiled.layout
    residuals = getattr(instance, "_residuals", None)
    if residuals is not None and (len(residuals) or residuals.code or residuals.updates):
        raise refusal(
            layout,
            "residuals were added at run time, which workers do not have",
            "write them as constraints of the model",
        )


def put_back(solved: Store, store: Store) -> None:
    """Write solved parameters, whose rows are in the order of files, into a model."""
    orders: dict[str, Any] = {}
    for path, table in store.tables.items():
        order, offsets = table.grouped()
        if table.layout.parent:
            parents = orders[table.layout.parent]
            order = np.concatenate(
                [order[offsets[p] : offsets[p + 1]] for p in parents.tolist()] or [order]
            )
        orders[path] = order
        for column in table.data.values():
            if column.role == "param":
                table.column(column.path)[order] = solved.tables[path].column(column.path)
        table.written()


@contextmanager
def executor_for(
    client: Any, scheduler: str | None, workers: int | None
) -> Iterator[tuple[Executor, int]]:
    """Where requests are answered, and the number of workers there."""
    if client is None and scheduler is None and workers == 0:
        yield InProcess(), 1
        return
    if client is not None:
        yield OnDask(client), max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
        return
    require_dask()
    if scheduler is not None:
        with connect(workers, scheduler, timeout=PATIENCE) as own:
            ask_directly(own)
            yield OnDask(own), max(1, len(own.scheduler_info(n_workers=-1)["workers"]))
        return
    # Not `connect`: there a task whose worker dies is not run again.
    distributed: Any = import_module("distributed")
    count = workers or os.cpu_count() or 1
    with (
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster, set_as_default=False, direct_to_workers=True) as own,
    ):
        yield OnDask(own), count
