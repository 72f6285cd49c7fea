"""Processes that are ended at the worst moment: in a compilation, in writing, in a solve."""

from __future__ import annotations

import signal
import sys

import pytest

from tests.faults.processes import Place, finished, wait_for

pytestmark = pytest.mark.slow
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGKILL]


@pytest.mark.parametrize("number", SIGNALS, ids=lambda s: s.name)
def test_during_a_compilation(place: Place, number: signal.Signals) -> None:
    process = place.start(
        [sys.executable, "-m", "arael", "solve", "line.arael", "line.json", "--compiled"]
    )
    wait_for(lambda: place.in_cache("*.c"), process)
    process.send_signal(number)
    done = finished(process).clean()
    assert done.code != 0
    if number == signal.SIGINT:
        assert "interrupted" in done.err
        assert place.half_built() == []
    place.arael("solve", "line.arael", "line.json", "--compiled").require(0, "converged")
    place.arael("cache", "clear").require(0, "removed")
    assert place.half_built() == []


# The command, which sends itself a signal when it first calls the function named first.
AT = """
import os, signal, sys
def die(*args, **more):
    os.kill(os.getpid(), int(sys.argv[2]))
    return kept(*args, **more)
kept = getattr(os, sys.argv[1])
from arael.cli.main import run
import arael.io.files
setattr(os, sys.argv[1], die)
sys.exit(run(sys.argv[3:]))
"""


@pytest.mark.parametrize("moment", ["fsync", "replace", "chmod"])
@pytest.mark.parametrize("number", SIGNALS, ids=lambda s: s.name)
def test_during_output(place: Place, moment: str, number: signal.Signals) -> None:
    """What is there after it is the old file or the new one, whole."""
    (place.folder / "out.json").write_text("old")
    words = ["solve", "slow.arael", "slow.json", "-o", "out.json", "--interpret"]
    place.arael(*words).require({0, 1})  # so that what follows finds its model in the cache
    new = (place.folder / "out.json").read_text()
    (place.folder / "out.json").write_text("old")
    done = place.script(AT, moment, str(int(number)), *words).clean()
    assert done.code == (1 if number == signal.SIGINT else -number), done.text
    assert (place.folder / "out.json").read_text() in ("old", new)
    if number == signal.SIGINT:
        assert place.leftovers("out.json") == []
    place.arael(*words).require({0, 1})
    assert (place.folder / "out.json").read_text() == new


# The command with a trace that takes its time, so that a signal arrives within the solve.
SLOWED = """
import sys, time
import arael.runtime.solve as solve
def write(line):
    print(line, file=sys.stderr, flush=True)
    time.sleep(0.05)
solve.to_stderr = write
import arael.solving
arael.solving.to_stderr = write
from arael.cli.main import run
sys.exit(run(sys.argv[1:]))
"""


@pytest.mark.parametrize("number", SIGNALS, ids=lambda s: s.name)
def test_during_a_solve(place: Place, number: signal.Signals) -> None:
    log = place.folder / "home" / "trace"
    words = ["solve", "slow.arael", "slow.json", "-o", "out.json", "--interpret", "-v"]
    with log.open("w") as stderr:
        process = place.start([sys.executable, "-c", SLOWED, *words], stderr=stderr)
        wait_for(lambda: log.read_text().count("\n") > 4, process)
        process.send_signal(number)
        done = finished(process).clean()
    told = log.read_text()
    assert "Traceback" not in told
    if number == signal.SIGINT:
        assert done.code == 1, done.text + told
        assert "interrupted" in done.text + told
        assert '"a"' in (place.folder / "out.json").read_text()
        assert place.leftovers("out.json") == []
    else:
        assert done.code == -number
        assert place.leftovers() == []
    assert (place.folder / "slow.json").read_text() == "{}\n"
