"""Public data sets: found in the folder ARAEL_DATA names, or in `../shared/data`."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

FOLDER = Path(os.environ.get("ARAEL_DATA") or Path(__file__).parents[2] / "shared" / "data")


def public(name: str) -> Path:
    """Path of the data set `name`; the test is skipped where it is absent."""
    path = FOLDER / name
    if not path.exists():
        pytest.skip(
            f"needs public data: set ARAEL_DATA to a folder with {name} and others "
            "(CONTRIBUTING.md names their sources)"
        )
    return path
