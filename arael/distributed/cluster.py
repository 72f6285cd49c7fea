"""Connection to a Dask cluster: a local one of worker processes, or a running scheduler."""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import multiprocessing
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic

if TYPE_CHECKING:
    from distributed import Client


def require_dask() -> None:
    """Raise AraelError (E0880) if Dask is not installed."""
    if importlib.util.find_spec("distributed") is None:
        raise AraelError(
            Diagnostic(
                "E0880",
                "solving on several processes needs Dask, which is not installed",
                origin="arael.distributed",
                help=("pip install 'arael[distributed]'",),
            )
        )


@contextlib.contextmanager
def connect(
    workers: int | None = None,
    scheduler: str | None = None,
    *,
    tls_ca: str | None = None,
    tls_cert: str | None = None,
    tls_key: str | None = None,
    timeout: float = 10.0,
) -> Iterator[Client]:
    """Yield a client of a running scheduler, or of a local cluster that ends with the block.

    Parameters
    ----------
    workers : processes of a local cluster, one thread each; None: one per core
    scheduler : address of a running scheduler (``tcp://host:8786``, ``tls://...``) instead
    tls_ca, tls_cert, tls_key : files of certificates and the key, for encrypted connections only;
        without them, the settings of Dask's own configuration apply
    timeout : seconds to wait for the scheduler

    Raises
    ------
    AraelError
        E0880 Dask is not installed; E0881 the scheduler cannot be reached, or both were given;
        E0887 processes of the local cluster did not start.
    """
    require_dask()
    if scheduler is not None and workers is not None:
        raise _unreachable(
            "`workers` is the size of a local cluster, and `scheduler` is another cluster",
            scheduler,
            "give one of them",
        )
    if workers is not None and workers < 1:
        raise _unreachable(
            f"a cluster has at least one worker, found {workers}", "workers", "workers=1"
        )
    # imported here: start-up time
    import distributed

    start: Any = distributed.Client
    security = _security(tls_ca, tls_cert, tls_key)
    if scheduler is None:
        with _local(workers, security) as cluster, start(cluster, set_as_default=False) as client:
            yield client
        return
    try:
        found = start(scheduler, timeout=timeout, security=security, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as error:
        why = str(error).partition("\n")[0] or type(error).__name__
        raise _unreachable(
            f"the scheduler cannot be reached: {why}",
            scheduler,
            "start one: dask scheduler; or use this machine: --workers 4",
        ) from None
    with found as client:
        yield client


@contextlib.contextmanager
def _local(workers: int | None, security: Any) -> Iterator[Any]:
    # imported here: start-up time
    import dask
    import distributed

    start: Any = distributed.LocalCluster
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        # A worker process that imports a script without a guard: its parent reports that.
        raise SystemExit(1)
    settings = {
        # A problem that ends its worker is retried by `arael.distributed.many`, alone.
        "distributed.scheduler.allowed-failures": 0,
        # No task waits at a worker: one that dies takes only the task that it runs.
        "distributed.scheduler.worker-saturation": 1.0,
        # Samples of what a worker does, taken in another thread of it.
        "distributed.worker.profile.enabled": False,
        # With Dask's settings the memory of a solve goes back to the system after it, and the next
        # one, of the same size, faults it in again: of large arrays, which have pages of their own
        # once any threshold is set, and of what another thread than the first one asks for.
        "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 256 * 1024**2,
        "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 32 * 1024**2,
        "distributed.nanny.pre-spawn-environ.MALLOC_ARENA_MAX": 1,
        # Ten times a second by default, in each worker and for each in this process.
        "distributed.worker.memory.monitor-interval": "500ms",
        "distributed.admin.system-monitor.interval": "10s",
        "distributed.admin.tick.interval": "500ms",
        # Workers are lost as expected; the outcome of their problems is reported.
        "distributed.worker.daemon": True,
    }
    with dask.config.set(settings), quiet():
        try:
            cluster = start(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                security=security,
                dashboard_address="127.0.0.1:0",
                preload=["arael.distributed.interrupts"],
                silence_logs=logging.CRITICAL,
            )
        except RuntimeError as error:
            raise _not_started(error) from None
        with cluster:
            yield cluster


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Silence Dask's log in this process: losses of workers are reported as outcomes."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(before)


def dashboard(client: Client) -> str | None:
    """Address of Dask's dashboard; None where bokeh, which it needs, is absent here."""
    if importlib.util.find_spec("bokeh") is None:
        return None
    return str(client.dashboard_link) or None


def _security(ca: str | None, cert: str | None, key: str | None) -> Any:
    if ca is None and cert is None and key is None:
        return None
    # imported here: start-up time
    from distributed import security

    for name, path in (("--tls-ca", ca), ("--tls-cert", cert), ("--tls-key", key)):
        if path is not None:
            try:
                with open(path, "rb"):
                    pass
            except OSError as error:
                raise _unreachable(
                    f"the file of {name} cannot be read: {error.strerror}", path, "check its path"
                ) from None
    make: Any = security.Security
    return make(
        tls_ca_file=ca,
        tls_client_cert=cert,
        tls_client_key=key,
        tls_scheduler_cert=cert,
        tls_scheduler_key=key,
        tls_worker_cert=cert,
        tls_worker_key=key,
        require_encryption=True,
    )


def _not_started(error: RuntimeError) -> AraelError:
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    return AraelError(
        Diagnostic(
            "E0887",
            f"worker processes of this machine did not start: {str(error).rstrip('.')}",
            origin=str(main or "workers"),
            notes=("each worker process imports the script that was started",),
            help=(
                'call it below `if __name__ == "__main__":` in a script',
                "or use the workers of a running scheduler: dask scheduler; dask worker ADDRESS",
            ),
        )
    )


def _unreachable(message: str, origin: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E0881", message, origin=origin, help=(advice,)))
