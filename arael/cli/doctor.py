"""`arael doctor`: the state of the installation, with advice."""

from __future__ import annotations

import json
import os
import platform
import sys
import tempfile
from dataclasses import asdict, dataclass
from importlib import import_module, metadata
from pathlib import Path

import click
from threadpoolctl import threadpool_info  # type: ignore[import-untyped, unused-ignore]

import arael
from arael.cli.exits import Exit
from arael.compiler import build, cache, processor
from arael.compiler.cache.trust import is_own, open_advice, prepare
from arael.compiler.kernels import probe
from arael.diagnostics.records import AraelError
from arael.runtime.parallel import compiled as pool


@dataclass(frozen=True)
class Finding:
    """Result of one check: ``ok``, ``missing`` (optional part) or ``broken``."""

    name: str
    state: str
    found: str
    advice: str = ""


@click.command("doctor", short_help="Report on the installation, with advice.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(as_json: bool) -> int:
    """Report on Python, libraries, C compiler, processor, cache and optional parts."""
    findings = examine()
    if as_json:
        click.echo(json.dumps({"findings": [asdict(f) for f in findings]}))
    else:
        for finding in findings:
            click.echo(f"{_MARK[finding.state]} {finding.name:<14} {finding.found}")
            if finding.advice:
                click.echo(f"  {'':<14} {finding.advice}")
    return Exit.BAD_INPUT if any(f.state == "broken" for f in findings) else Exit.OK


_MARK = {"ok": "+", "missing": "-", "broken": "!"}


def examine() -> list[Finding]:
    """Check all dependencies of arael."""
    return [
        Finding("python", "ok", f"{platform.python_version()} at {sys.executable}"),
        *(_package(name) for name in ("arael", "numpy", "scipy", "cython", "setuptools")),
        _compiler(),
        _processor(),
        _threads(),
        _blas(),
        _cache(),
        _extra("scikit-sparse", "cholmod", "the solver `cholmod`"),
        _extra("matplotlib", "plot", "figures (`--plot`)"),
        _extra("rerun-sdk", "rerun", "maps in the viewer Rerun (`arael.plot.rerun`)"),
        _extra("pygls", "lsp", "the language server (`arael lsp`)"),
        _extra("pyarrow", "arrow", "Parquet and Arrow files"),
        _extra("h5py", "hdf5", "HDF5 files"),
    ]


def _package(name: str) -> Finding:
    try:
        return Finding(name, "ok", metadata.version(name))
    except metadata.PackageNotFoundError:
        if name == "arael":
            return Finding(name, "ok", f"{arael.__version__} (not installed, run from its source)")
        return Finding(name, "broken", "not installed", f"pip install {name}")


def _extra(package: str, extra: str, purpose: str) -> Finding:
    try:
        return Finding(package, "ok", metadata.version(package))
    except metadata.PackageNotFoundError:
        advice = f"optional, for {purpose}: pip install 'arael[{extra}]'"
        return Finding(package, "missing", "not installed", advice)


def _compiler() -> Finding:
    path = build.find_compiler()
    if path is None:
        wanted = os.environ.get("CC", "").strip()
        found = f"CC={wanted} not found" if wanted else "none found"
        advice = (
            "models run on the slower expression machine; install one: apt install gcc, "
            "xcode-select --install, or Visual Studio Build Tools"
        )
        return Finding("C compiler", "missing", found, advice)
    chosen = " (chosen by CC)" if os.environ.get("CC", "").strip() else ""
    trouble = _trouble_of_compiling()
    if trouble:
        return Finding("C compiler", "broken", f"{path}{chosen}", trouble)
    return Finding("C compiler", "ok", f"{build.compiler_version() or path} at {path}{chosen}")


def _trouble_of_compiling() -> str:
    """Compile and load the smallest extension module; return what went wrong, or ""."""
    try:
        place = prepare("arael-kernels")  # where models are compiled
    except AraelError:  # reported separately
        try:
            place = Path(tempfile.gettempdir())
        except OSError as unusable:
            return str(unusable)
    error = probe(place)
    if error is None:
        return ""
    first = error.diagnostics[0]
    return "; ".join([first.message, *first.notes[:1], *first.help])


def _processor() -> Finding:
    flags = processor.flags()
    widest = next(
        (
            name
            for name, flag in (("AVX-512", "avx512f"), ("AVX2", "avx2"), ("NEON", "asimd"))
            if flag in flags
        ),
        "",
    )
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    noun = "core" if cores == 1 else "cores"
    return Finding("processor", "ok", f"{platform.machine()} {widest}, {cores} {noun}")


def _threads() -> Finding:
    if not pool.supported():
        return Finding(
            "threads",
            "missing",
            "this platform has no POSIX threads",
            "every solve runs on one thread, for any `--threads`",
        )
    return Finding("threads", "ok", f"own pool, {pool.threads_for(0)} for `--threads 0`")


def _blas() -> Finding:
    import_module("scipy.linalg.cython_blas")  # loads the BLAS of the solvers
    pools = [p for p in threadpool_info() if p.get("user_api") == "blas"]
    if not pools:
        return Finding("BLAS", "ok", "none that reports its threads")
    names = {f"{p['internal_api']} {p.get('version') or ''}".strip() for p in pools}
    threads = max(p["num_threads"] for p in pools)
    return Finding("BLAS", "ok", f"{', '.join(sorted(names))}, {threads} threads")


def _cache() -> Finding:
    path = cache.directory()
    if not path.exists():
        parent = next(p for p in path.parents if p.exists())
        if os.access(parent, os.W_OK):
            return Finding("cache", "ok", f"{path} (not made yet)")
        return Finding("cache", "broken", f"{path} cannot be made", _CACHE_ADVICE)
    if not path.is_dir() or not os.access(path, os.W_OK):
        return Finding("cache", "broken", f"{path} cannot be written", _CACHE_ADVICE)
    entries = cache.entries()
    size = sum(bytes_ for _, _, bytes_ in entries) / 1e6
    if not is_own(path.resolve()):
        advice = "other users can write there, it is not used: " + "; or ".join(open_advice(path))
        return Finding("cache", "broken", str(path), advice)
    return Finding("cache", "ok", f"{path}: {len(entries)} compiled models, {size:.1f} MB")


_CACHE_ADVICE = "choose another directory with the environment variable ARAEL_CACHE_DIR"
