"""Public data sets: found in the folder ARAEL_DATA names, or in `../shared/data`."""

from __future__ import annotations

import os
from collections.abc import Iterable
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


def held(names: Iterable[str], pattern: str) -> list[str]:
    """Those of `names` whose file, ``pattern.format(name)``, is in the folder of data sets.

    All of them where the folder has none, so that their tests are skipped and say what is missing.
    """
    every = list(names)
    return [name for name in every if (FOLDER / pattern.format(name)).exists()] or every
