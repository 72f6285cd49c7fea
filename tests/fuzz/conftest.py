"""Fuzz tests use limits and timers of POSIX; what options the suite lacks has a default here."""

from __future__ import annotations

import os

import pytest

if os.name != "posix":
    collect_ignore_glob = ["test_*.py"]


@pytest.fixture
def fuzz_seed(request: pytest.FixtureRequest) -> int:
    return int(request.config.getoption("--fuzz-seed", 0))


@pytest.fixture
def fuzz_seconds(request: pytest.FixtureRequest) -> float:
    return float(request.config.getoption("--fuzz-seconds", 5.0))
