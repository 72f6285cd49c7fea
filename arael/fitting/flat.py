"""Flat directions of a fit, and the combinations of parameters that are determined beside them.

A direction is flat if a change of its parameters by a thousand times their size changes the
residuals by less than their standard deviation. Where one combination of the parameters of such
directions is determined it is named: a product of powers where they change in proportion (``c/d``
of a logistic curve that has become a jump, ``a*b``), or a weighted sum, if the residuals stay as
they are where the parameters change by as much as their values and the combination is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.display.measured import measured
from arael.runtime.assembly.components import graph_components

Array = NDArray[np.float64]

_FAR = 1e3
"""Change, in sizes of the parameters, that residuals do not show along a flat direction."""
_PART = 1e-6
"""Least share of a parameter in a flat direction, of which it is then a part."""
_PROPORTIONAL = 0.01
"""Largest deviation of the exponents of a product from whole numbers."""


def flat_directions(
    names: Sequence[str],
    x: Array,
    cost: Callable[[Array], float],
    matrix: Array,
    size: Array,
    deviation: float,
) -> tuple[str, ...]:
    """What is not determined, and what is in its place: a sentence a group of parameters.

    Parameters
    ----------
    names, x : (p,) the parameters and their values
    cost : sum of squared residuals at other values
    matrix : (n, p) derivatives of the whitened residuals
    size : (p,) magnitudes that the data give the parameters
    deviation : standard deviation of the whitened residuals; NaN if it is not known
    """
    weight = np.maximum(np.abs(x), size)
    _, values, rows = np.linalg.svd(matrix * weight, full_matrices=True)
    strength = np.zeros(len(x))
    strength[: len(values)] = values
    rounding = max(matrix.shape) * np.finfo(float).eps * strength[0]
    flat = strength <= np.fmax(deviation / _FAR, rounding)
    if not flat.any():
        return ()
    # a rise of the cost that is within the scatter, or within rounding of a curve without any
    rise = float(np.nan_to_num(deviation)) ** 2 + (1e-8 * float(np.linalg.norm(matrix * x))) ** 2
    most = cost(x) + rise
    directions = rows[flat].T * weight[:, None]
    share = np.abs(rows[flat].T @ rows[flat])
    label = graph_components(len(x), *np.nonzero(share > _PART))
    groups: Iterator[NDArray[Any]] = (np.flatnonzero(label == k) for k in np.unique(label))
    # standard errors of what is determined: the inverse without the flat directions
    inverse = weight[:, None] * rows[~flat].T * (deviation / strength[~flat])
    found = []
    for group in groups:
        along = np.linalg.norm(rows[flat][:, group], axis=1) > _PART
        if not along.any():
            continue

        def same(values: Array, group: NDArray[Any] = group) -> bool:
            """Whether the curve stays as it is with these values of the group."""
            moved = np.repeat(x[:, None], values.shape[1], axis=1)
            moved[group] = values
            return all(cost(one) <= most for one in moved.T)

        of = [names[k] for k in group]
        found.append(
            _sentence(
                of, x[group], weight[group], directions[group][:, along], inverse[group], same
            )
        )
    return tuple(found)


def _sentence(
    names: list[str],
    x: Array,
    weight: Array,
    directions: Array,
    inverse: Array,
    same: Callable[[Array], bool],
) -> str:
    listed = [f"`{name}`" for name in names]
    straight = x[:, None] + directions / np.abs(directions / weight[:, None]).max(axis=0)
    if len(names) == 1:
        why = "the curve hardly depends on it" if same(straight) else "others make up for it"
        return f"{listed[0]} is not determined: {why}"
    head = f"{', '.join(listed[:-1])} and {listed[-1]} are not determined"
    if x.all():
        shares = directions / x[:, None]
        powers = _normal(shares)
        doubled = x[:, None] * 2 ** (shares / np.abs(shares).max(axis=0))
        if powers is not None and same(doubled):
            whole = np.round(powers)
            if np.abs(powers - whole).max() <= _PROPORTIONAL:
                value = float(np.prod(x**whole))
                text = ("-" if value < 0 else "") + _product(names, whole)
                known = _with_error(abs(value), value * whole / x, inverse)
                return f"{head}, only {text} = {known}"
    weights = _normal(directions)
    if weights is None or not same(straight):
        return f"{head}: they can change together, and the curve hardly changes"
    factors = (f"{abs(w):.4g} ".removeprefix("1 ") for w in weights)
    signs = ("-" if w < 0 else "+" for w in weights)
    terms = zip(signs, factors, names, strict=True)
    text = " ".join(f"{sign} {factor}{name}" for sign, factor, name in terms).removeprefix("+ ")
    return f"{head}, only {text} = {_with_error(float(weights @ x), weights, inverse)}"


def _normal(directions: Array) -> Array | None:
    """The one vector normal to all directions, its least weight 1; None if there are several."""
    count = len(directions)
    vectors, values, _ = np.linalg.svd(directions)
    rank = int(np.count_nonzero(values > 1e-9 * values[0]))
    if rank != count - 1:
        return None
    found = vectors[:, -1]
    least = np.abs(found).min()
    if least <= _PART:
        return None
    return np.asarray(found / least * np.sign(found[0]))


def _product(names: list[str], exponents: Array) -> str:
    def factors(sign: int) -> list[str]:
        chosen = [(n, int(e * sign)) for n, e in zip(names, exponents, strict=True) if e * sign > 0]
        return [name if power == 1 else f"{name}^{power}" for name, power in chosen]

    over, under = factors(1), factors(-1)
    bottom = f"({'*'.join(under)})" if len(under) > 1 else "".join(under)
    return "*".join(over) + (f"/{bottom}" if bottom else "")


def _with_error(value: float, gradient: Array, inverse: Array) -> str:
    error = float(np.linalg.norm(gradient @ inverse))
    number, spread = measured(value, error)
    return f"{number} +- {spread}" if np.isfinite(error) else number
