"""Uncertainty of a solution as a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic

ENDINGS = (".npz", ".json")
DENSE_LIMIT = 8000
"""Most parameters whose covariance is worked out: the matrix is inverted as a whole."""


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

    NPZ: ``names`` (n,), ``sigma`` (n,) and ``covariance`` (n, n). JSON: names and their sigma.

    Raises
    ------
    AraelError
        E0853 if the file cannot be written, E0855 if there are too many parameters, E1008 if the
        system is singular.
    """
    if parameters > DENSE_LIMIT:
        raise AraelError(
            Diagnostic(
                "E0855",
                f"the covariance of {parameters} parameters would take too much memory",
                origin=f"--covariance {path}",
                help=(f"up to {DENSE_LIMIT} parameters are possible",),
            )
        )
    found = instance.covariance()
    sigma = np.sqrt(np.diag(found.matrix))
    try:
        if Path(path).suffix.lower() == ".json":
            rows = dict(zip(found.names, sigma.tolist(), strict=True))
            Path(path).write_text(json.dumps({"sigma": rows}), encoding="utf-8")
        else:
            with open(path, "wb") as file:
                np.savez_compressed(
                    file, names=np.array(found.names), sigma=sigma, covariance=found.matrix
                )
    except OSError as error:
        raise AraelError(
            Diagnostic("E0853", f"cannot write the result: {error.strerror}", origin=path)
        ) from error
