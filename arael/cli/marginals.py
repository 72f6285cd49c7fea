"""Uncertainty of a solution as a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic

ENDINGS = (".npz", ".json")
DENSE_LIMIT = 8000
"""Most parameters whose covariance is written as a whole; its memory grows with the square."""


def check_ending(path: str) -> None:
    """Refuse a file name before anything is computed for it.

    Raises
    ------
    AraelError
        E0855 if its ending is neither ``.npz`` nor ``.json``.
    """
    if Path(path).suffix.lower() not in ENDINGS:
        raise AraelError(
            Diagnostic(
                "E0855",
                "covariances are written as .npz or .json",
                origin=f"--covariance {path}",
                help=(f"for instance {Path(path).with_suffix('.npz').name}",),
            )
        )


def write_marginals(instance: Any, parameters: int, path: str) -> None:
    """Write the uncertainty of every parameter.

    JSON: names and their sigma. NPZ: ``names`` (n,), ``sigma`` (n,), ``units`` (n,); up to
    `DENSE_LIMIT` parameters also ``covariance`` (n, n), beyond it the marginal covariances
    (rows, k, k) of every collection that is solved for, under its path.

    Raises
    ------
    AraelError
        E0853 if the file cannot be written, E1008 if the system is singular.
    """
    found = instance.covariance()
    sigma = found.sigma()
    try:
        if Path(path).suffix.lower() == ".json":
            rows = dict(zip(found.names, sigma.tolist(), strict=True))
            Path(path).write_text(json.dumps({"sigma": rows}), encoding="utf-8")
        else:
            with open(path, "wb") as file:
                np.savez_compressed(
                    file,
                    names=np.array(found.names),
                    sigma=sigma,
                    units=np.array(found.units),
                    **_matrices(instance, found, parameters),
                )
    except OSError as error:
        raise AraelError(
            Diagnostic("E0853", f"cannot write the result: {error.strerror}", origin=path)
        ) from error


def _matrices(instance: Any, found: Any, parameters: int) -> dict[str, Any]:
    if parameters <= DENSE_LIMIT:
        return {"covariance": found.matrix}
    paths = (entity.table for entity in instance._compiled.layout.entities)
    return {path: found.marginals(path) for path in paths if path}
