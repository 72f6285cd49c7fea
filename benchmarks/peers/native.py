"""Programs of other languages in the harness: built once, fed a file of columns.

They print what the runner prints, and write their answer as columns. Builds are kept in the folder
that `ARAEL_BENCH_BUILD` names, else in ``build`` beside this package's folder.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import exchange, problems
from benchmarks.peers import endings
from benchmarks.peers.runner import AbsentError, Request, show

HERE = Path(__file__).parent
BUILD = Path(os.environ.get("ARAEL_BENCH_BUILD", HERE.parent / "build"))


def run(program: Path, asked: Request, version: str | None = None) -> None:
    """Run a built program on a problem and pass on what it measured.

    Without a `version` the program knows its own.
    """
    out = Path(asked.out)
    columns = _columns(asked.suite, asked.problem, out.parent)
    answer = out.with_suffix(".columns")
    numbers = (asked.short, asked.long, asked.runs, asked.threads, asked.limit)
    command = [program, asked.suite, columns, *numbers, answer]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr.strip() or f"{program.name}: exit code {done.returncode}")
    said = json.loads(done.stdout.strip().splitlines()[-1])
    np.savez(out, **exchange.read(answer))  # type: ignore[arg-type]
    said["settings"] = said.pop("plan", "")
    said.pop("cost", None)
    show(said if version is None else {**said, "version": version})


def run_to_the_end(program: Path, ways: Mapping[str, str], version: str | None = None) -> None:
    """Solve in each way by a built program (`endings`), a process each, and pass on what came."""
    suite, problem, runs, limit, out = endings.request()
    columns = _columns(suite, problem, Path(out).parent)
    found, setup = [], 0.0
    for number, (name, settings) in enumerate(endings.chosen(ways).items()):
        answer = Path(f"{out}.{number}.columns")
        words = [program, endings.WORD, suite, columns, name, runs, limit, answer]
        one = _way([str(word) for word in words])
        version = version or one.pop("version", None)
        setup = one.pop("setup", setup)
        if one["runs"]:
            np.savez(f"{out}.{number}.npz", **exchange.read(answer))  # type: ignore[arg-type]
        found.append({"name": name, "settings": settings, **one})
    show({"version": version, "setup": setup, "ways": found})


def _way(command: Sequence[str]) -> dict[str, Any]:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=endings.PATIENCE)
    except subprocess.TimeoutExpired:
        return endings.failed(f"not done in {endings.PATIENCE:.0f} s")
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        return endings.failed(said[-1])
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def _columns(suite: str, problem: str, folder: Path) -> Path:
    """The problem as columns: one file for all programs and numbers of threads."""
    folder = Path(os.environ.get("ARAEL_BENCH_COLUMNS", folder))
    columns = folder / f"{suite}-{Path(problem).stem}.columns"
    if not columns.exists():
        exchange.write_model(columns, problems.KINDS[suite].load(problem))
    return columns


def compiled(
    name: str, flags: Sequence[str], links: Sequence[str], needs: Mapping[str, str]
) -> Path:
    """Compile ``NAME/peer.cc`` where that is not yet done.

    Parameters
    ----------
    flags, links : what stands before and behind the sources
    needs : what to install, by the headers that are not found without it
    """
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        raise AbsentError("no C++ compiler (Debian: g++)")
    built = BUILD / name
    sources = [*(HERE / name).iterdir(), *(HERE / "cpp").iterdir()]
    newest = max(source.stat().st_mtime for source in sources)
    if not built.exists() or built.stat().st_mtime < newest:
        # The libraries were built without AVX: their alignment of Eigen's types holds for all.
        options = "-O3 -march=native -DEIGEN_MAX_ALIGN_BYTES=16 -std=c++17 -I/usr/include/eigen3"
        command = [compiler, *options.split(), *flags, str(HERE / name / "peer.cc")]
        build([*command, "-o", str(built), *links], BUILD / f"{name}.log", needs=needs)
    return built


def build(
    command: Sequence[str],
    log: Path,
    needs: Mapping[str, str] | None = None,
    **environment: str,
) -> None:
    """Run a build; what it said goes to `log`."""
    log.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        command, env={**os.environ, **environment}, capture_output=True, text=True, cwd=HERE
    )
    log.write_text(done.stdout + done.stderr, encoding="utf-8")
    if done.returncode:
        raise AbsentError(f"did not build: {_why(done.stderr, needs or {})} ({log})")


def _why(said: str, needs: Mapping[str, str]) -> str:
    """What is missing, in words, or the first error of a build."""
    for header, what in needs.items():
        if f"fatal error: {header}" in said:
            return f"{what} are missing"
    return next((line.strip() for line in said.splitlines() if "error" in line.lower()), "")
