"""Programs of other languages in the harness: built once, fed a file of columns.

They print what the runner prints, and write their answer as columns. Builds are kept in the folder
that `ARAEL_BENCH_BUILD` names, else in ``build`` beside this package's folder.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks import exchange, problems
from benchmarks.peers.runner import AbsentError, Request, show

HERE = Path(__file__).parent
BUILD = Path(os.environ.get("ARAEL_BENCH_BUILD", HERE.parent / "build"))


def run(program: Path, asked: Request, version: str, settings: str) -> None:
    """Run a built program on a problem and pass on what it measured."""
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
    plan = said.pop("plan", "")
    said.pop("cost", None)
    settings = f"{settings} {plan}".strip()
    show({"version": version, **said, "settings": settings})


def build(command: Sequence[str], log: Path, **environment: str) -> None:
    """Run a build; what it said goes to `log`."""
    log.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        command, env={**os.environ, **environment}, capture_output=True, text=True, cwd=HERE
    )
    log.write_text(done.stdout + done.stderr, encoding="utf-8")
    if done.returncode:
        last = [line for line in done.stderr.splitlines() if "error" in line.lower()][:1]
        raise AbsentError(f"did not build ({log}): {' '.join(last)}")
