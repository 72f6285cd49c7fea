"""Covariances in the form of the models: principal axes and 1/sigma along each."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.geometry.arrays import Array, as_array, as_numbers


def decompose_covariance(covariance: ArrayLike) -> tuple[Array, Array]:
    """Principal axes of covariances: ``K = R diag(d) R'``.

    A raw difference e is whitened by ``cov_isigma * (cov_r' e)``: the components in sigmas along
    each axis, whose squares sum to ``e' K^-1 e``.

    Parameters
    ----------
    covariance : (..., k, k) symmetric, positive definite

    Returns
    -------
    cov_r : (..., k, k) principal axes as columns, the shortest first; a rotation (det = +1)
    cov_isigma : (..., k) 1 / sqrt(d), in the inverse of the unit of the difference

    Raises
    ------
    AraelError
        E1030 if a covariance is not symmetric or not positive definite, E1031 if it is not square.
    """
    k = as_array(covariance, _square(covariance), "covariance")
    size = np.abs(k).max(axis=(-2, -1), keepdims=True, initial=0.0)
    uneven = ~(np.abs(k - np.swapaxes(k, -1, -2)) <= 1e-9 * size).all(axis=(-2, -1))
    if uneven.any():
        raise _refused(uneven, "is not symmetric, or has entries that are not finite")
    values, axes = np.linalg.eigh(k)
    # A variance of 0 would be an infinite weight.
    poor = values[..., 0] <= values[..., -1] * k.shape[-1] * np.finfo(np.float64).eps
    if poor.any():
        smallest = values[..., 0][poor].flat[0]
        raise _refused(poor, f"is not positive definite: its smallest variance is {smallest:.3g}")
    mirrored = np.linalg.det(axes) < 0
    axes[..., :, -1] = np.where(mirrored[..., None], -axes[..., :, -1], axes[..., :, -1])
    return axes, 1 / np.sqrt(values)


def compose_covariance(cov_r: ArrayLike, cov_isigma: ArrayLike) -> Array:
    """Covariances (..., k, k) from `cov_r` and `cov_isigma`: inverse of `decompose_covariance`."""
    isigma = np.atleast_1d(as_numbers(cov_isigma, "cov_isigma"))
    k = isigma.shape[-1:]
    axes = as_array(cov_r, k + k, "cov_r")
    found: Array = (axes / isigma[..., None, :] ** 2) @ np.swapaxes(axes, -1, -2)
    return found


def whiten(raw: ArrayLike, cov_r: ArrayLike, cov_isigma: ArrayLike) -> Array:
    """Whitened differences (..., k): `raw` (..., k) in sigmas along the principal axes."""
    isigma = np.atleast_1d(as_numbers(cov_isigma, "cov_isigma"))
    k = isigma.shape[-1:]
    axes = as_array(cov_r, k + k, "cov_r")
    e = as_array(raw, k, "raw")
    found: Array = np.einsum("...ji,...j->...i", axes, e) * isigma
    return found


def ellipsoid(covariance: ArrayLike) -> tuple[Array, Array]:
    """One-sigma ellipsoids of covariances (..., k, k), singular ones included.

    Returns
    -------
    semi_axes : (..., k) their lengths, descending, in the unit of the quantity
    directions : (..., k, k) unit vectors along them as columns
    """
    k = as_array(covariance, _square(covariance), "covariance")
    values, axes = np.linalg.eigh(k)
    return np.sqrt(np.maximum(values[..., ::-1], 0.0)), axes[..., ::-1]


def _square(covariance: ArrayLike) -> tuple[int, int]:
    shape = as_numbers(covariance, "covariance").shape
    extent = shape[-1] if shape else 1
    return extent, extent


def _refused(bad: NDArray[np.bool_], why: str) -> AraelError:
    which = np.argwhere(np.atleast_1d(bad))[0].tolist()
    many = np.size(bad) > 1
    place = f"covariance[{', '.join(map(str, which))}]" if many else "covariance"
    return AraelError(
        Diagnostic(
            "E1030",
            f"`{place}` {why}",
            origin="arael.geometry",
            help=(
                "give every direction a variance above 0, for instance the sensor's resolution "
                "squared",
            ),
        )
    )
