"""Packages that some formats need, and that are optional parts of arael."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic

EXTRAS = {"pyarrow": "arrow", "h5py": "hdf5"}
"""Package -> the extra of arael that installs it."""


def required(module: str, name: str, format: str) -> Any:
    """Import a module of an optional package, for a file of a format.

    Raises
    ------
    AraelError
        E0725: it is not installed.
    """
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ImportError:
        raise AraelError(
            Diagnostic(
                "E0725",
                f"{format} files need {package}, which is not installed",
                origin=name,
                help=(f"pip install 'arael[{EXTRAS[package]}]'",),
            )
        ) from None
