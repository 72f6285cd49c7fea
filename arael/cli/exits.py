"""What the `arael` command's exit codes mean."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Exit codes, the same for every command."""

    OK = 0
    """Solved, or nothing found wrong."""
    NOT_CONVERGED = 1
    """The solve ended without converging, or `fmt --check` found files to format."""
    BAD_INPUT = 2
    """A model, a data file, an option or the environment is not as it must be."""
    INTERNAL = 3
    """A defect in arael."""
