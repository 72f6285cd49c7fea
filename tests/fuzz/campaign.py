"""Draw inputs from a seed, have worker processes examine them, keep what fails."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import os
import queue
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FAILURES = ROOT / ".fuzz-failures"
"""Failing inputs, each with a ``.txt`` file of seed and complaint; not under version control."""
PATIENCE = 120.0
"""Seconds of wall clock after which a worker is taken to hang."""
PER_PROCESS = 1500
"""Inputs after which a worker is replaced, so that what one leaves behind does not add up."""
MOST = 12
"""Different failures after which a campaign ends."""


@dataclass(frozen=True)
class Input:
    """One input: the name of its file, its content, and what it was made from."""

    name: str
    content: bytes
    origin: str = ""


Draw = Callable[[random.Random], Input]


@dataclass(frozen=True)
class Failure:
    """An input that caused a failure."""

    signature: str
    complaint: str
    path: Path


@dataclass
class Campaign:
    """What a run found.

    Attributes
    ----------
    inputs : number of inputs examined
    outcomes : how often each outcome came
    failures : one for each signature
    """

    seed: int
    inputs: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    failures: dict[str, Failure] = field(default_factory=dict)

    def __str__(self) -> str:
        lines = [f"seed {self.seed}, {self.inputs} inputs: {dict(self.outcomes.most_common(12))}"]
        for one in self.failures.values():
            last = "\n    ".join(one.complaint.strip().splitlines()[-14:])
            lines.append(f"{one.signature}\n    {last}\n    input kept: {one.path}")
        return "\n".join(lines)

    def reached(self, outcome: str) -> int:
        """How many outcomes begin with `outcome`."""
        return sum(count for name, count in self.outcomes.items() if name.startswith(outcome))


class Worker:
    """A process that examines inputs one by one."""

    def __init__(self, module: str, folder: Path) -> None:
        self._stderr = (folder / "stderr.txt").open("w+b")
        environment = {
            **os.environ,
            "ARAEL_CACHE_DIR": str(folder / "cache"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONHASHSEED": "0",
        }
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz.worker", module, str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            cwd=ROOT,
            env=environment,
        )
        self._answers: queue.Queue[bytes] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.inputs = 0
        self.alive = "ready" in self._next()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._answers.put(line)
        self._answers.put(b"")

    def ask(self, case: Input, seed: int) -> dict[str, str]:
        """What became of an input, the end of the process included."""
        assert self.process.stdin is not None
        content = base64.b64encode(case.content).decode()
        message = {"content": content, "name": case.name, "seed": seed}
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(json.dumps(message).encode() + b"\n")
            self.process.stdin.flush()
        self.inputs += 1
        return self._next()

    def _next(self) -> dict[str, str]:
        try:
            line = self._answers.get(timeout=PATIENCE)
        except queue.Empty:
            self.process.send_signal(signal.SIGABRT)  # faulthandler writes where it hangs
            line = b""
            why = f"no answer in {PATIENCE:.0f} s"
        else:
            why = ""
        if line:
            answer: dict[str, str] = json.loads(line)
            return answer
        self.alive = False
        code = self.process.wait(timeout=60)
        if not why:
            name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            why = "over the bound of processor time" if name == "SIGPROF" else f"ended by {name}"
        self._stderr.seek(0)
        told = self._stderr.read().decode(errors="replace")[-4000:]
        place = next((part for part in told.splitlines() if "/arael/" in part), "").strip()
        return {"outcome": "failed", "complaint": f"{told}\n{why}", "signature": f"{why} {place}"}

    def close(self) -> None:
        """End the process."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()
        for stream in (self.process.stdin, self.process.stdout, self._stderr):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()


def run(module: str, draw: Draw, seed: int, seconds: float, folder: Path) -> Campaign:
    """Examine inputs for `seconds`.

    Parameters
    ----------
    module : of this folder; its ``examine(content, name, rng, folder)`` returns an outcome or
        raises. `AraelError` is a refusal; anything else is a failure.
    draw : makes an input from a generator; input `k` of a seed is the same on any machine
    folder : an empty one for files of the workers
    """
    print(f"{module}: seed {seed}, {seconds:.0f} s (repeat with --fuzz-seed {seed})")
    found = Campaign(seed)
    worker: Worker | None = None
    ends: float | None = None
    try:
        while ends is None or time.monotonic() < ends:
            if worker is None or not worker.alive or worker.inputs >= PER_PROCESS:
                if worker is not None:
                    worker.close()
                place = folder / f"worker-{found.inputs}"
                place.mkdir()
                worker = Worker(module, place)
                assert worker.alive, f"the worker does not start: {place}/stderr.txt"
            if ends is None:  # imports do not count
                ends = time.monotonic() + seconds
            number = int.from_bytes(hashlib.sha256(f"{seed}:{found.inputs}".encode()).digest()[:6])
            case = draw(random.Random(number))
            answer = worker.ask(case, number)
            found.inputs += 1
            found.outcomes[answer["outcome"]] += 1
            if "complaint" in answer and answer["signature"] not in found.failures:
                found.failures[answer["signature"]] = _keep(module, found, case, number, answer)
                if len(found.failures) >= MOST:
                    break
    finally:
        if worker is not None:
            worker.close()
    print(found)
    return found


def _keep(
    module: str, found: Campaign, case: Input, number: int, answer: dict[str, str]
) -> Failure:
    FAILURES.mkdir(exist_ok=True)
    base = f"{module}-seed{found.seed}-{found.inputs - 1}"
    path = FAILURES / f"{base}-{case.name}"
    path.write_bytes(case.content)
    (FAILURES / f"{base}.txt").write_text(
        f"seed {found.seed}, input {found.inputs - 1}, number {number}, made from {case.origin}\n"
        f"again: python -m tests.fuzz.again {module} {number} {path.name}\n\n"
        f"{answer['complaint']}\n"
    )
    return Failure(answer["signature"], answer["complaint"], path)
