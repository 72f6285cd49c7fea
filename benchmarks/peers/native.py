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

import numpy as np

from benchmarks import exchange, problems
from benchmarks.peers.runner import AbsentError, Request, show

HERE = Path(__file__).parent
BUILD = Path(os.environ.get("ARAEL_BENCH_BUILD", HERE.parent / "build"))


def run(program: Path, asked: Request, version: str | None = None) -> None:
    """Run a built program on a problem and pass on what it measured.

    Without a `version` the program knows its own.
    """
    out = Path(asked.out)
    # One file for all programs and numbers of threads.
    folder = Path(os.environ.get("ARAEL_BENCH_COLUMNS", out.parent))
    columns = folder / f"{asked.suite}-{Path(asked.problem).stem}.columns"
    if not columns.exists():
        exchange.write_model(columns, problems.KINDS[asked.suite].load(asked.problem))
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
