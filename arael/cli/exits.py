"""Exit codes of the `arael` command."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Exit codes, the same for every command."""

    OK = 0
    """Solved, or nothing found wrong."""
    NOT_CONVERGED = 1
    """The solve ended without converging, or `fmt --check` found files to format."""
    BAD_INPUT = 2
    """A model, a data file, an option or the environment is invalid."""
    INTERNAL = 3
    """A defect in arael."""
