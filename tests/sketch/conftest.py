"""Sketches in tests run on compiled kernels, except where a test says otherwise."""

from __future__ import annotations

import pytest

from arael.loading import load_compiled


@pytest.fixture(scope="session", autouse=True)
def kernels_of_sketches() -> None:
    """Compile the model of sketches, which a build from source leaves to its first use."""
    load_compiled("sketch")
