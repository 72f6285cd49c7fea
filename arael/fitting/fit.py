"""`arael.fit`: a formula, a table of points, the parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import public
from arael.fitting.curve import Curve, Parameter, Points, curve_of
from arael.fitting.estimates import estimates
from arael.fitting.formula import Formula, measured_column, read_formula
from arael.fitting.messages import check_parameter, mistake
from arael.fitting.polish import polished
from arael.fitting.result import Fit
from arael.fitting.scales import exponents, magnitude
from arael.fitting.starts import find_start
from arael.fitting.table import Table, pair_of, table_of

Array = NDArray[np.float64]
Trace = Callable[[str], object]


@public
def fit(
    formula: str,
    data: Any,
    measured: Any = None,
    *,
    y: str | None = None,
    sigma: float | str | Any = None,
    start: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
    fixed: Mapping[str, float] | None = None,
    loss: str | None = None,
    group: str | None = None,
    shared: Iterable[str] = (),
    absolute_sigma: bool = True,
    trace: Trace | None = None,
    **settings: Any,
) -> Fit:
    """Fit a formula to points by least squares.

    Names in the formula that are columns of the data are data, all others are parameters. Starts
    that are not given are found: linear parameters are eliminated, the others searched over scales
    drawn from the data.

    Parameters
    ----------
    formula : ``"y = a * exp(-b * x)"``; without ``y =`` the column `y` or ``"y"`` is predicted. A
        formula that contains it is a residual to minimise, and so is the difference of the sides of
        an equation, ``"hypot(x - a, y - b) = r"`` or ``"0 = ..."``.
    data : columns by name (arrays, or one number for all points), a data frame, the path of a CSV
        file or a list of paths. Points with a missing value (NaN) are left out. With `measured`
        the values of the column ``x``.
    measured : values of the column ``y``, so that ``fit(formula, x, y)`` reads as `curve_fit` does
    y : the predicted column
    sigma : standard deviation of the points: a number, an array, or the name of a column. Without
        it the scatter of the points about the curve is used, ``sqrt(cost / (points - parameters))``
    start : start values by parameter; with all of them nothing is searched
    bounds : (low, high) by parameter, None or infinite for none
    fixed : values of parameters that are not solved for
    loss : robust loss of each point, as after `loss` in a model file: ``"cauchy(2)"``
    group : column whose values divide the points into groups, numbers or texts; of several files
        ``"file"`` is such a column
    shared : parameters that all groups have in common; each group has its own of all others
    absolute_sigma : whether `sigma` is known; else only ratios of it count, and the scatter gives
        the scale
    trace : called with each line of the trace of the last solve
    **settings : of the solver, see `arael.LmConfig`

    Returns
    -------
    Fit

    Raises
    ------
    AraelError
        E01xx: mistakes of the formula; E0870 a formula that cannot be fitted, E0871 a missing
        column, E0872 a parameter or its start or bounds, E0873 data that do not fit; E07xx: of a
        file.
    SolveError
        E1008: the points do not determine the parameters; the free directions are named.

    Examples
    --------
    >>> import arael
    >>> x = [0, 1, 2, 3, 4]
    >>> found = arael.fit("y = a * exp(-b * x)", {"x": x, "y": [2.0, 1.2, 0.8, 0.4, 0.3]})
    >>> print(f"{found.parameters['b']:.2f} +- {found.sigma['b']:.2f}")
    0.49 +- 0.02
    """
    if trace is not None and not callable(trace):
        raise wrong_argument("fit", "trace", "a function of a line", trace, "write `trace=print`")
    _check_arguments(formula, y, group, start=start, bounds=bounds, fixed=fixed)
    shared = _names(shared)
    table = table_of(data if measured is None else pair_of(data, measured, y))
    found = read_formula(formula, y, table.titles, table.name)
    points, skipped = _points(table, found, sigma, group)
    if group is None and shared:
        raise mistake("E0872", "shared parameters need groups", "shared", 'give `group="column"`')
    parameters = _parameters(found, start or {}, bounds or {}, fixed or {}, group, shared)
    _check_counts(points, parameters, group)
    curve = curve_of(found, parameters, points, loss)
    values = _start(curve, found)
    curve.put(values)
    options = {"rel_precision": 1e-14, **settings}
    result = curve.model.solve(trace=trace, **options)
    here = curve.get()
    on_bound = _on_bound(curve, here)
    moves = curve.free & np.array([name not in on_bound for name in curve.names])
    best, promise = polished(curve, here, moves) if moves.any() else (here, 0.0)
    curve.put(best)
    known = sigma is not None and absolute_sigma
    return Fit(
        found,
        curve,
        result,
        estimates(
            curve, best, moves, _sizes(curve, found), scatter=not known, robust=loss is not None
        ),
        known=known,
        values=best,
        starts=dict(zip(curve.names, values.tolist(), strict=True)),
        on_bound=on_bound,
        skipped=skipped,
        promise=promise,
    )


def _check_arguments(formula: Any, y: Any, group: Any, **by_name: Any) -> None:
    """Reject arguments of other types: E0870 a formula, E0871 columns, E0872 values by name."""
    if not isinstance(formula, str):
        raise mistake(
            "E0870",
            f"a formula is text, found {type(formula).__name__}",
            "formula",
            'write "a * x"; `Model.add_residuals` takes functions'
            if callable(formula)
            else 'write "a * x"',
        )
    for where, column in (("y", y), ("group", group)):
        if column is not None and not isinstance(column, str):
            raise mistake(
                "E0871",
                f"expected the name of a column, found {type(column).__name__}",
                where,
                f'put the values into the data, and write {where}="name"',
            )
    for where, given in by_name.items():
        if given is not None and not isinstance(given, Mapping):
            value = "(0, 1)" if where == "bounds" else "1.5"
            raise mistake(
                "E0872",
                f"expected values by the names of parameters, found {type(given).__name__}",
                where,
                f'write {where}={{"a": {value}}}',
            )


def _names(shared: Any) -> tuple[str, ...]:
    """The names of shared parameters; a text is one name, not its letters."""
    try:
        return (shared,) if isinstance(shared, str) else tuple(shared)
    except TypeError:
        raise mistake(
            "E0872",
            f"expected names of parameters, found {type(shared).__name__}",
            "shared",
            'write shared=["a"]',
        ) from None


def _start(curve: Curve, formula: Formula) -> Array:
    if all(p.start is not None for p in curve.parameters):
        return np.array(
            [np.clip(p.start, p.low, p.high) for p in curve.parameters if p.start is not None]
        )
    return find_start(curve, formula.text, formula.predicts)


def _sizes(curve: Curve, formula: Formula) -> Array:
    """(p,) magnitudes of the parameters by the units that formula and data give them."""
    columns = curve.points.columns
    units = exponents(formula.text, formula.predicts, formula.parameters, tuple(columns))
    size = [magnitude(unit, columns) for unit in units]
    return np.array([size[formula.parameters.index(p.name)] for p in curve.parameters])


def _points(table: Table, formula: Formula, sigma: Any, group: str | None) -> tuple[Points, int]:
    """The points that have all values, and the number of those that have not."""
    names = list(formula.columns)
    if isinstance(sigma, str):
        sigma = measured_column(sigma, table.titles, table.name)
        names += [] if sigma in names else [sigma]
    columns = table.columns(names)
    whole = np.ones(table.size, dtype=bool)
    for column in columns.values():
        whole &= ~np.isnan(column)
    if isinstance(sigma, str):
        deviation, where = columns[sigma], f"{table.name}: {table.titles[sigma]}"
    else:
        deviation, where = _numbers(1.0 if sigma is None else sigma, table.size), "sigma"
        if np.isnan(deviation).all():
            raise mistake(
                "E0873", "the standard deviation is nan", where, "write a positive number, or none"
            )
        whole &= ~np.isnan(deviation)
    texts = [""] * table.size
    if group is not None:
        texts = table.texts(measured_column(group, table.titles, table.name))
        whole &= np.array([text != "" for text in texts])
    rows = np.flatnonzero(whole)
    if not len(rows):
        raise mistake("E0873", "no point has all the values that the fit reads", table.name)
    bad = rows[~(deviation[rows] > 0) | np.isinf(deviation[rows])]
    if len(bad):
        raise mistake(
            "E0873",
            f"the standard deviation of point {bad[0]} is {deviation[bad[0]]:g}",
            where,
            "standard deviations are positive numbers",
        )
    names_of_groups = tuple(dict.fromkeys(texts[row] for row in rows))
    number = {text: k for k, text in enumerate(names_of_groups)}
    return (
        Points(
            {name: columns[name][rows] for name in formula.columns},
            np.ascontiguousarray(deviation[rows]),
            np.array([number[texts[row]] for row in rows], dtype=np.int64),
            names_of_groups if group is not None else (),
        ),
        table.size - len(rows),
    )


def _numbers(given: Any, size: int) -> Array:
    try:
        found = np.asarray(given, dtype=np.float64)
        return np.array(np.broadcast_to(found, size))
    except (TypeError, ValueError):
        raise mistake(
            "E0873",
            f"expected a number or {size} numbers, found {given!r:.60}",
            "sigma",
        ) from None


def _parameters(
    formula: Formula,
    start: Mapping[str, float],
    bounds: Mapping[str, tuple[float | None, float | None]],
    fixed: Mapping[str, float],
    group: str | None,
    shared: Iterable[str],
) -> list[Parameter]:
    for what, given in (("start", start), ("bounds", bounds), ("fixed", fixed), ("shared", shared)):
        for name in given:
            check_parameter(name, formula.parameters, what)
    if all(name in fixed for name in formula.parameters):
        raise mistake("E0872", "all parameters are fixed: there is nothing to fit", "fixed")
    for name in fixed:
        if name in start and start[name] != fixed[name]:
            raise mistake(
                "E0872",
                f"'{name}' is fixed at {fixed[name]!r:.40} and starts at {start[name]!r:.40}",
                "start",
                "give one of the two",
            )
    common = set(shared)
    return [
        _parameter(
            name,
            fixed.get(name, start.get(name)),
            bounds.get(name, (None, None)),
            name in fixed,
            group is not None and name not in common,
        )
        for name in formula.parameters
    ]


def _check_counts(points: Points, parameters: list[Parameter], group: str | None) -> None:
    """Reject fewer points than free parameters: E0873, of which group."""
    free = [p for p in parameters if not p.fixed]
    own = [p.name for p in free if p.own] if group is not None else [p.name for p in free]
    for number, name in enumerate(points.groups or ("",)):
        count = int((points.group == number).sum()) if group is not None else len(points.sigma)
        if count >= len(own):
            continue
        advice = "fix some of them, or add points"
        of = "the data have"
        if group is not None:
            advice = "leave its points out, fix some of them, or share them between groups"
            of = f"the group '{name}' of '{group}' has"
        noun = f"{count} point{'s' * (count != 1)}"
        raise mistake(
            "E0873",
            f"{of} {noun} for {len(own)} parameters: {', '.join(own)}",
            "fit" if group is None else "group",
            advice,
        )


def _parameter(name: str, start: Any, bounds: Any, fixed: bool, own: bool) -> Parameter:
    try:
        if isinstance(bounds, str):
            raise TypeError
        low, high = (
            default if bound is None else float(bound)
            for bound, default in zip(bounds, (-math.inf, math.inf), strict=True)
        )
    except (TypeError, ValueError):
        raise mistake(
            "E0872", f"the bounds of '{name}' are {bounds!r:.60}", "bounds", "write (low, high)"
        ) from None
    where = "fixed" if fixed else "start"
    if not low < high:
        raise mistake("E0872", f"the bounds {low:g} .. {high:g} of '{name}' are empty", "bounds")
    try:
        value = None if start is None else float(start)
    except (TypeError, ValueError):
        value = math.nan
    if value is not None and not math.isfinite(value):
        raise mistake("E0872", f"expected a number for '{name}', found {start!r:.60}", where)
    if value is not None and not low <= value <= high:
        what = "fixed value" if fixed else "start"
        raise mistake(
            "E0872",
            f"the {what} {value:g} of '{name}' is beyond {low:g} .. {high:g}",
            where,
            "widen the bounds, or give a value within them",
        )
    if fixed:  # on its bound, a fixed parameter is still fixed
        low, high = -math.inf, math.inf
    return Parameter(name, low, high, value, fixed, own)


def _on_bound(curve: Curve, x: Array) -> dict[str, str]:
    """Parameters on an active bound, each with the bound in words."""
    residuals, matrix = curve(x)
    slope = matrix.T @ residuals
    square = (matrix**2).sum(axis=0)
    found = {}
    for k, name in enumerate(curve.names):
        if not curve.free[k]:
            continue
        slack = 1e-14 * (1 + abs(x[k]))
        step = -slope[k] / square[k] if square[k] else 0.0
        least = 1e-8 * (1 + abs(x[k]))
        if x[k] <= curve.low[k] + slack and step <= least:
            found[name] = f"its lower bound {curve.low[k]:g}"
        elif x[k] >= curve.high[k] - slack and step >= -least:
            found[name] = f"its upper bound {curve.high[k]:g}"
    return found
