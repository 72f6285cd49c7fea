"""C compilers that are absent, fail, hang, or write something else than a module."""
# ruff: noqa: E501 - scripts

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow
SOLVE = ("solve", "line.arael", "line.json")


def compiler(place: Place, text: str) -> str:
    """A compiler that is a script of sh; its path."""
    path = place.folder / "home" / "cc"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


ABSENT = {
    "no such command": {"CC": "no-such-compiler"},
    "an empty path": {"CC": None, "PATH": "/nonexistent"},
    "blanks": {"CC": "   "},
    "a folder": {"CC": "/"},
    "an unclosed quote": {"CC": "'gcc"},
}


@pytest.mark.parametrize("kind", ABSENT)
def test_absent(place: Place, kind: str) -> None:
    """The expression machine stands in and this is said; with `--compiled` it is an error."""
    env = ABSENT[kind]
    done = place.arael(*SOLVE, env=env).require(0, "converged")
    if kind != "blanks":  # which may be taken for no choice at all
        assert "expression machine" in done.text
        assert "compiler" in done.text
        place.arael(*SOLVE, "--compiled", env=env).require(2, "compiler")
    place.arael("doctor", env=env).require({0, 2}, "compiler")
    assert place.half_built() == []


BROKEN = {
    "fails": "echo 'cc: fatal error: no luck' >&2; exit 1",
    "is killed": "kill -9 $$",
    "writes nothing": "exit 0",
    "writes garbage": 'for w; do o=$w; [ "$p" = -o ] && { echo garbage > "$o"; exit 0; }; p=$w; done',
    "writes a library that is none of Python": (
        'for w; do [ "$p" = -o ] && { echo "int x;" | gcc -shared -fPIC -x c - -o "$w"; exit; }; p=$w; done'
    ),
    "prints no UTF-8": "printf '\\377\\376 broken\\n' >&2; exit 1",
    "prints much": "yes 'error: again and again' | head -c 3000000 >&2; exit 1",
}


@pytest.mark.parametrize("kind", BROKEN)
def test_broken(place: Place, kind: str) -> None:
    """Named as the cause; nothing of it stays, so that a compiler that works is used at once."""
    env = {"CC": compiler(place, BROKEN[kind])}
    done = place.arael(*SOLVE, "--compiled", env=env).require(2, "compiler", "cc")
    assert len(done.text) < 10_000
    place.arael(*SOLVE, env=env).require({0, 2}, "expression machine", "compiler")
    place.arael("doctor", env=env).require({0, 1, 2}, "compiler", "cc")
    assert place.half_built() == []
    (place.folder / "home" / "cc").write_text('#!/bin/sh\nexec gcc "$@"\n')
    done = place.arael(*SOLVE, env=env).require(0, "converged")
    assert "expression machine" not in done.text


def test_silent_about_its_version(place: Place) -> None:
    env = {"CC": compiler(place, 'case "$1" in --version) exit 0;; esac; exec gcc "$@"')}
    place.arael(*SOLVE, "--compiled", env=env).require(0, "converged")
    place.arael("doctor", env=env).require({0, 1, 2}, "compiler")


def test_several_words(place: Place) -> None:
    path = compiler(place, 'exec gcc "$@"')
    env = {"CC": f"{shlex.quote(path)} -DX=1"}
    place.arael(*SOLVE, "--compiled", env=env).require(0, "converged")


def test_hangs(place: Place) -> None:
    """A compiler that never ends is ended, and named; so are the processes that it started."""
    mark = f"47{abs(hash(str(place.folder))) % 10**6}"
    env = {"CC": compiler(place, f"sleep {mark}"), "ARAEL_COMPILE_TIMEOUT": "2"}
    place.arael(*SOLVE, "--compiled", env=env, timeout=60).require(2, "compiler", "cc")
    assert place.half_built() == []
    if Path("/proc").is_dir():
        running = [p.read_bytes() for p in Path("/proc").glob("[0-9]*/cmdline") if _readable(p)]
        assert not [line for line in running if line == f"sleep\0{mark}\0".encode()]


def _readable(path: Path) -> bool:
    try:
        path.read_bytes()
    except OSError:
        return False
    return True


def test_hangs_and_is_interrupted(place: Place) -> None:
    import signal

    from tests.faults.processes import finished, wait_for

    env = {"CC": compiler(place, "exec sleep 300")}
    process = place.start([sys.executable, "-m", "arael", *SOLVE, "--compiled"], env=env)
    wait_for(lambda: place.in_cache("*.c"), process)
    process.send_signal(signal.SIGINT)
    finished(process, 60).require(1, "interrupted")
    assert place.half_built() == []
