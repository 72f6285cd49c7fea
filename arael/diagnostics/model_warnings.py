"""Warnings of a model and of its data as warnings of Python."""

from __future__ import annotations

import warnings
from collections.abc import Iterable


class ModelWarning(UserWarning):
    """A probable mistake in a model; its text is that of `arael check`."""


class DataWarning(UserWarning):
    """Something in a file has no field in the model, or is not known when a file is written."""


class InterpretedWarning(UserWarning):
    """A model runs on the expression machine, which is correct and slower than kernels."""


def warn_of_model(texts: Iterable[str], stacklevel: int = 3) -> None:
    """Issue each rendered warning of a model, at the place of the caller's caller."""
    for text in texts:
        warnings.warn(text.rstrip("\n"), ModelWarning, stacklevel=stacklevel)
