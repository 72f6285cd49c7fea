"""Kernels of generated source: found in the cache, or compiled and kept there."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from arael.compiler import progress
from arael.compiler.cache import failures
from arael.compiler.cache import kernels as kept
from arael.compiler.cache.keys import code_digest, kernels_key
from arael.compiler.cache.trust import prepare, unwritable
from arael.compiler.cache.upkeep import trim
from arael.compiler.extension import import_kernels, require_loadable
from arael.compiler.no_compiler import NoCompiler, unloadable
from arael.compiler.time_limit import compile_limit
from arael.diagnostics.records import AraelError

TARGET = "native"


@dataclass(frozen=True)
class Loaded:
    """Kernels in this process.

    Attributes
    ----------
    table : capsule ``arael.kernels``
    folder : of their entry
    compiled : whether they were compiled just now
    seconds : what that took, by stage
    """

    table: Any
    folder: Path
    compiled: bool = False
    seconds: dict[str, float] = field(default_factory=dict)


def find_kernels(code: str) -> Loaded | None:
    """Kernels that were compiled before.

    Parameters
    ----------
    code : digest of their source (`arael.compiler.cache.code_digest`)
    """
    entry = kept.find(kernels_key(code, TARGET))
    if entry is None or entry.module is None:
        return None
    try:
        return Loaded(import_kernels(entry.module), entry.folder)
    except ImportError:  # e.g. a library that it links was removed: compile again
        shutil.rmtree(entry.folder, ignore_errors=True)
        return None


def kernels_of(source: str, name: str, origin: str) -> Loaded:
    """Kernels of generated source, compiled or found in the cache.

    Parameters
    ----------
    source : Cython source, as `arael.compiler.compiler.emit` makes it
    name : of the model, for names of files and reports
    origin : the model's file, for the list of entries

    Raises
    ------
    AraelError
        E0801-E0803, E0807, E0808: there is no working C compiler; E0804-E0806 the cache cannot be
        used.
    """
    code = code_digest(source)
    kernels = find_kernels(code)
    if kernels is not None:
        return kernels
    key = kernels_key(code, TARGET)
    try:
        loaded = _build(key, code, source, name, origin)
    except NoCompiler as error:
        _remember(key, error)
        raise
    failures.forget(key)
    trim()
    return loaded


def _build(key: str, code: str, source: str, name: str, origin: str) -> Loaded:
    # imported here: start-up time
    from arael.compiler import build
    from arael.compiler.estimate import expected_seconds, shown

    seconds: dict[str, float] = {}
    with kept.building(key) as folder:
        kernels = find_kernels(code)  # another process may have compiled them meanwhile
        if kernels is not None:
            return kernels
        about = shown(expected_seconds(source))
        what = f"compiling {name}, about {about}"
        build_module(folder, module_name(name, key), source, seconds, what=what)
        try:
            entry = kept.store(
                key, folder, name, origin, build.compiler_version(), seconds, require_loadable
            )
        except ImportError as error:
            raise unloadable(error, build.find_compiler() or "") from None
    assert entry.module is not None
    return Loaded(import_kernels(entry.module), entry.folder, True, seconds)


def _remember(key: str, error: NoCompiler) -> None:
    """Keep a failure, unless the next compilation may well succeed."""
    # imported here: start-up time
    from arael.compiler import build

    first = error.diagnostics[0]
    passing = error.passing
    failure: failures.Failure | None = failures.Failure(
        first.message, build.compiler_identity(), "changed", time.time()
    )
    if first.code != "E0801":
        if probe() is not None:
            failure = failures.Failure(
                first.message, build.compiler_identity(), "probe", time.time()
            )
        elif passing:
            failure = None
    failures.store(key, "\n".join((str(error), *first.notes)) + "\n", failure)


def standing_failure(code: str) -> str | None:
    """Why kernels need not be compiled now: it has failed, and would fail again. None: try.

    Parameters
    ----------
    code : digest of their source
    """
    key = kernels_key(code, TARGET)
    failure = failures.find(key)
    if failure is None:
        return None
    # imported here: start-up time
    from arael.compiler import build

    if failure.compiler != build.compiler_identity():
        return None
    if failure.retry == "changed":
        return failure.message
    error = probe()
    return None if error is None else error.diagnostics[0].message


def probe(place: Path | None = None) -> AraelError | None:
    """Compile and load the smallest module; return what went wrong, or None.

    Parameters
    ----------
    place : folder to do it in; by default where kernels are compiled
    """
    # imported here: start-up time
    import tempfile

    # imported here: start-up time
    from arael.compiler import build

    try:
        place = place or prepare("arael-kernels")
        with tempfile.TemporaryDirectory(
            prefix="probe-", dir=place, ignore_cleanup_errors=True
        ) as folder:
            return build.probe(Path(folder))
    except AraelError as error:
        return error
    except OSError as error:
        return unwritable(error)


def module_name(name: str, key: str = "") -> str:
    """Name of a generated module: what is plain in a model's name, made unique by a key."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)[:40]
    return "_".join(filter(None, ("kernels", plain, key[:8])))


def build_module(
    folder: Path,
    name: str,
    source: str,
    seconds: dict[str, float],
    target: str = TARGET,
    what: str = "compiling",
) -> None:
    """Write, cythonise and compile kernels into `folder`.

    Raises
    ------
    arael.compiler.no_compiler.NoCompiler
        There is none, or it does not work; the source is kept.
    """
    # imported here: start-up time
    from arael.compiler import build

    pyx = folder / f"{name}.pyx"
    pyx.write_text(source, encoding="utf-8")
    build.require_compiler()
    started = time.perf_counter()
    with progress.watched(what, compile_limit()):
        c_file = build.cython_to_c(pyx)
    seconds["cython"] = time.perf_counter() - started
    started = time.perf_counter()
    try:
        build.compile_c(c_file, target, what, spent=seconds["cython"])
    finally:
        c_file.unlink(missing_ok=True)
    seconds["compile"] = time.perf_counter() - started
