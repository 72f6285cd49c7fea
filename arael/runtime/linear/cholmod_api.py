"""SuiteSparse's CHOLMOD through either of the two interfaces of scikit-sparse."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic

Floats = NDArray[np.float64]


class Factor(Protocol):
    """A factorisation that reuses its symbolic part."""

    def factorise(self, matrix: Any) -> int:
        """Factorise a matrix of the same pattern; -1, or the row at whose pivot it failed."""

    def solve(self, b: Floats) -> Floats:
        """Solution for one right-hand side."""


class Factor04:
    """The interface of scikit-sparse 0.4: `analyze`, `Factor.cholesky_inplace`."""

    def __init__(self, module: Any, matrix: Any) -> None:
        self._module = module
        # Only the supernodal code stops at a negative pivot; the simplicial one computes L D L'.
        self._factor = module.analyze(matrix, mode="supernodal")

    def factorise(self, matrix: Any) -> int:
        """Factorise a matrix of the same pattern; -1, or the row at whose pivot it failed."""
        try:
            self._factor.cholesky_inplace(matrix)
        except self._module.CholmodNotPositiveDefiniteError as failure:
            return _row(self._factor.P(), failure.column)
        return -1

    def solve(self, b: Floats) -> Floats:
        """Solution for one right-hand side."""
        x: Floats = self._factor.solve_A(b)
        return x


class Factor05:
    """The interface of scikit-sparse 0.5: `CholeskyFactor` and its `factorize`."""

    def __init__(self, module: Any, matrix: Any) -> None:
        self._module = module
        self._factor = module.CholeskyFactor(matrix, lower=True, supernodal_mode="supernodal")

    def factorise(self, matrix: Any) -> int:
        """Factorise a matrix of the same pattern; -1, or the row at whose pivot it failed."""
        try:
            self._factor.factorize(matrix, ldl=False, beta=0.0)
        except self._module.CholmodNotPositiveDefiniteError as failure:
            # This interface reports the column only in the text of its message.
            column = re.search(r"column (\d+)", str(failure))
            return _row(self._factor.get_perm(), int(column[1]) if column else 0)
        return -1

    def solve(self, b: Floats) -> Floats:
        """Solution for one right-hand side."""
        return np.asarray(self._factor.solve(b), dtype=np.float64).reshape(b.shape)


def _row(permutation: NDArray[np.integer], column: int) -> int:
    return int(permutation[column]) if 0 <= column < len(permutation) else 0


def new_factor(matrix: Any) -> Factor:
    """Analyse a sparse symmetric matrix, given by its lower triangle in CSC format.

    Raises
    ------
    AraelError
        E0841 if scikit-sparse is missing or does not load.
    """
    try:
        module = import_module("sksparse.cholmod")
    except ImportError as failure:
        raise AraelError(_missing(failure)) from None
    return (
        Factor05(module, matrix) if hasattr(module, "CholeskyFactor") else Factor04(module, matrix)
    )


def _missing(failure: ImportError) -> Diagnostic:
    absent = isinstance(failure, ModuleNotFoundError)
    return Diagnostic(
        "E0841",
        "the solver 'cholmod' needs scikit-sparse, which "
        + ("is not installed" if absent else "does not load"),
        origin="solver cholmod",
        notes=(
            "scikit-sparse is built on your machine: it needs a C compiler and SuiteSparse with "
            "its headers (Debian and Ubuntu: apt-get install libsuitesparse-dev; conda and "
            "Homebrew: suitesparse)",
            "scikit-sparse 0.5 needs SuiteSparse 7.4 or newer; with an older one, "
            'pip install "scikit-sparse<0.5"',
        )
        + (() if absent else (str(failure),)),
        help=(
            'pip install "arael[cholmod]"',
            "or use the solver 'sparse', which needs nothing more and is usually faster",
        ),
    )
