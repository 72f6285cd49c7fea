"""What a line of progress announces: how long a compilation will take."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from arael.compiler import estimate, progress
from arael.compiler.cache import kernels as kept
from arael.loading import standard_models
from tests.compiler.test_emit import emitted


def test_comments_take_no_time() -> None:
    code = "cdef void f() noexcept nogil:\n" + "    t0 = 1\n" * 100
    assert estimate.predicted(code) < estimate.predicted(code * 2)
    assert estimate.predicted(code) == estimate.predicted(code.replace("\n", "\n    # here\n"))


def test_the_standard_models_take_seconds() -> None:
    found = {
        name: estimate.predicted(emitted(path.read_text()))
        for name, path in standard_models().items()
        if name in ("linear", "slam")
    }
    assert 0.5 < found["linear"] < 1.5 < found["slam"] < 5


def test_what_this_machine_has_taken_scales_the_estimate(
    filled_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(filled_cache))
    (entry,) = kept.recent(5)
    (path,) = entry.folder.glob("*.pyx")
    source = path.read_text()
    taken = entry.manifest.seconds["cython"] + entry.manifest.seconds["compile"]
    assert estimate.expected_seconds(source) == pytest.approx(taken)
    path.write_bytes(b"\xa0" + path.read_bytes())  # a damaged entry: it is not verified here
    assert estimate.expected_seconds(source) == pytest.approx(taken)
    path.write_text(source)
    # Three compilations that took five times as long as foreseen, one that was fast.
    slow, fast = (source, 5 * estimate.predicted(source)), (source, 0.1)
    assert estimate._machine([slow, fast, slow, slow]) == pytest.approx(5)
    assert estimate._machine([]) == 1


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.2, "1 s"), (3.4, "3 s"), (13, "15 s"), (61, "60 s"), (170, "3 min")]
)
def test_estimates_are_round(seconds: float, text: str) -> None:
    assert estimate.shown(seconds) == text


def test_steps_within_this_process_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[str, float | None]] = []
    monkeypatch.setattr(
        progress, "listener", lambda what, seconds, limit: seen.append((what, seconds))
    )
    with progress.watched("compiling fit, about 3 s", 600):
        deadline = time.monotonic() + 10
        while not seen and time.monotonic() < deadline:
            time.sleep(0.05)
    assert [what for what, _ in seen] == ["compiling fit, about 3 s"] * len(seen)
    assert seen[0][1] is not None
    assert seen[0][1] >= 1
    assert seen[-1][1] is None
