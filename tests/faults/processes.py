"""Real processes with arael in them, and what has to hold when one is disturbed."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import arael

PACKAGE = Path(arael.__file__).resolve().parents[1]

LINE = """\
struct Point { x: real; y: real }
root Line {
    param a: real = 0
    param b: real = 0
    data: list of Point
    fit data as e { a * e.x + b - e.y }
}
"""
"""A model that compiles in little time."""

DATA = '{"a": 0, "b": 0, "data": [{"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 5}]}\n'
"""Its solution is a = 2, b = 1."""

NET = """\
struct Node {
    param p: vec3
    w: real = 1
    constraint near { w * (p - [1, 2, 3]) }
    constraint curved { sin(p.x) * cos(p.y) }
}
root Net {
    nodes: list of Node
}
"""
"""A model with parameters in rows."""

SLOW = "root Slow {\n    param a: real = 1000\n    constraint flat { [a^8, 1e-8 * a] }\n}\n"
"""A model that takes some 60 steps."""


@dataclass(frozen=True)
class Done:
    """How a process ended; `code` is negative after a signal."""

    code: int
    out: str
    err: str

    @property
    def text(self) -> str:
        """All that was printed."""
        return self.out + self.err

    def require(self, code: int | Iterable[int], *words: str) -> Done:
        """Check the exit code, that no internal failure shows, and that one of `words` is named."""
        codes = {code} if isinstance(code, int) else set(code)
        self.clean()
        assert self.code in codes, f"exit code {self.code}\n{self.text[-3000:]}"
        low = self.text.lower()
        assert not words or any(word.lower() in low for word in words), self.text[-3000:]
        return self

    def clean(self) -> Done:
        """Check that neither a crash nor a traceback nor an internal error happened."""
        for sign in (
            "Traceback (most recent",
            "internal error",
            "fault of arael",
            "Exception ignored",
        ):
            assert sign not in self.text, f"exit code {self.code}\n{self.text[-3000:]}"
        crashes = (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL)
        assert -self.code not in crashes, f"{signal.Signals(-self.code).name}\n{self.text[-3000:]}"
        return self


class Place:
    """A folder with the model `line.arael` and its data, a home and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cache = folder / "cache"
        self.home = folder / "home"
        self.home.mkdir(parents=True)
        (folder / "line.arael").write_text(LINE)
        (folder / "line.json").write_text(DATA)
        (folder / "net.arael").write_text(NET)
        (folder / "net.json").write_text('{"nodes": [{"p": [0, 0, 0]}, {"p": [1, 1, 1]}]}\n')
        (folder / "slow.arael").write_text(SLOW)
        (folder / "slow.json").write_text("{}\n")

    def environment(self, changes: Mapping[str, str | None] | None = None) -> dict[str, str]:
        """Variables of a process; a change to None removes one."""
        found: dict[str, str | None] = {
            **{k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "ARAEL_"))},
            "HOME": str(self.home),
            "ARAEL_CACHE_DIR": str(self.cache),
            "PYTHONPATH": str(PACKAGE),
            "PYTHONFAULTHANDLER": "1",
            **(changes or {}),
        }
        return {k: v for k, v in found.items() if v is not None}

    def start(
        self, command: list[str], env: Mapping[str, str | None] | None = None, **more: Any
    ) -> subprocess.Popen[str]:
        """Start a process here."""
        settings: dict[str, Any] = {
            "cwd": self.folder, "env": self.environment(env), "text": True, "errors": "replace",
            "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
            "start_new_session": True, **more,
        }  # fmt: skip
        return subprocess.Popen(command, **settings)

    def run(
        self,
        command: list[str],
        env: Mapping[str, str | None] | None = None,
        timeout: float = 120,
        **more: Any,
    ) -> Done:
        """Run a process here until it ends."""
        with self.start(command, env, **more) as process:
            try:
                return finished(process, timeout)
            except BaseException:
                with contextlib.suppress(ProcessLookupError):  # also what it started
                    os.killpg(process.pid, signal.SIGKILL)
                raise

    def arael(self, *words: str, **more: Any) -> Done:
        """Run the command."""
        return self.run([sys.executable, "-m", "arael", *words], **more)

    def script(self, text: str, *words: str, **more: Any) -> Done:
        """Run Python source."""
        return self.run([sys.executable, "-c", text, *words], **more)

    def shell(self, text: str, **more: Any) -> Done:
        """Run a line of sh, in which ``$ARAEL`` is the command."""
        env = {**more.pop("env", {}), "ARAEL": f"{sys.executable} -m arael"}
        return self.run(["sh", "-c", text], env=env, **more)

    def leftovers(self, *expected: str) -> list[str]:
        """Files here that were not there at first, without those of the cache and of Python."""
        given = {f"{name}.{end}" for name in ("line", "net", "slow") for end in ("arael", "json")}
        known = given | set(expected)
        return sorted(
            str(path.relative_to(self.folder))
            for path in self.folder.rglob("*")
            if path.is_file()
            and path.relative_to(self.folder).parts[0] not in ("cache", "home", "__pycache__")
            and str(path.relative_to(self.folder)) not in known
        )

    def in_cache(self, pattern: str) -> list[Path]:
        """Files and folders anywhere in the cache, whose layout is its own affair."""
        for _ in range(100):  # folders may vanish while they are listed
            with contextlib.suppress(OSError):
                return sorted(self.cache.rglob(pattern))
        return []

    def half_built(self) -> list[str]:
        """What an unfinished compilation leaves in the cache."""
        return [path.name for kind in ("build-*", "*.tmp", "*.c") for path in self.in_cache(kind)]


def finished(process: subprocess.Popen[str], timeout: float = 120) -> Done:
    """Wait for the end of a process."""
    out, err = process.communicate(timeout=timeout)
    return Done(process.returncode, out or "", err or "")


def wait_for(
    condition: Callable[[], object], process: subprocess.Popen[str], seconds: float = 60
) -> None:
    """Wait until something is the case while `process` runs."""
    ends = time.monotonic() + seconds
    while not condition():
        if process.poll() is not None:
            out, err = process.communicate()
            raise AssertionError(f"ended too early with {process.returncode}: {out}{err}")
        assert time.monotonic() < ends, "waited in vain"
        time.sleep(0.002)


def solved(done: Done) -> bool:
    """Whether a solve of `line.arael` with ``--json`` found the line."""
    import json

    found = json.loads(done.out)
    return (
        found["status"] == "converged" and found["cost"] < 1e-9 if "cost" in found else bool(found)
    )


@contextlib.contextmanager
def full(folder: Path, left: int = 0) -> Any:
    """Fill the disk of a folder, but for `left` bytes."""
    filler = folder / "filler"
    with filler.open("wb", buffering=0) as file:
        with contextlib.suppress(OSError):
            while True:
                file.write(b"\0" * 4096)
        size = file.tell()
        file.truncate(max(0, size - left))
    try:
        yield
    finally:
        filler.unlink()
