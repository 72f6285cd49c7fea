"""Uncertainty of a solution as a file."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import write_whole

ENDINGS = (".npz", ".json")
DENSE_LIMIT = 8000
"""Largest number of parameters for a full covariance, whose memory grows with its square."""


def check_ending(path: str) -> None:
    """Reject an invalid file name before any computation.

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
    """Write the uncertainty of every parameter atomically.

    JSON: ``sigma`` by name, and ``on_bound``, the parameters on an active bound. NPZ: ``names``
    (n,), ``sigma`` (n,), ``units`` (n,), ``on_bound`` (names); up to `DENSE_LIMIT` parameters also
    ``covariance`` (n, n), beyond it the marginal covariances (rows, k, k) of every collection that
    is solved for, under its path.

    Raises
    ------
    AraelError
        E0715 if the file cannot be written, E1008 if the system is singular.
    """
    found = instance.covariance()
    sigma = found.sigma()
    content = io.BytesIO()
    if Path(path).suffix.lower() == ".json":
        rows = dict(zip(found.names, sigma.tolist(), strict=True))
        content.write(json.dumps({"sigma": rows, "on_bound": found.on_bound}).encode())
    else:
        np.savez_compressed(
            content,
            names=np.array(found.names, dtype=np.str_),
            sigma=sigma,
            units=np.array(found.units, dtype=np.str_),
            on_bound=np.array(list(found.on_bound), dtype=np.str_),
            **_matrices(instance, found, parameters),
        )
    write_whole(path, lambda file: file.write(content.getbuffer()))


def _matrices(instance: Any, found: Any, parameters: int) -> dict[str, Any]:
    if parameters <= DENSE_LIMIT:
        return {"covariance": found.matrix}
    paths = (entity.table for entity in instance._compiled.layout.entities)
    return {path: found.marginals(path) for path in paths if path}
