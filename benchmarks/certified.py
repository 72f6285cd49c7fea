"""Digits of NIST's certified regressions: ``python -m benchmarks nist``.

The log relative error is the number of correct digits of the worst parameter of a set, and of the
worst standard error, at most 11 as certified. Every program runs at its default settings:
`arael.fit` from both starts of the collection and from starts that it finds, a model file, SciPy's
`curve_fit`, lmfit's `minimize`.
"""

from __future__ import annotations

import itertools
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import arael
from benchmarks import nist
from benchmarks.cases import DATA
from benchmarks.measure import table
from benchmarks.systems import Plan

Array = NDArray[np.float64]
Digits = tuple[float, float]

_MOST = 11.0
_FAILED = (0.0, 0.0)
# Terms of a sum that may come in any order: numbers of their parameters.
_TERMS: dict[str, tuple[tuple[int, ...], ...]] = {
    "ENSO": ((3, 4, 5), (6, 7, 8)),
    "Gauss1": ((2, 3, 4), (5, 6, 7)),
    "Gauss2": ((2, 3, 4), (5, 6, 7)),
    "Gauss3": ((2, 3, 4), (5, 6, 7)),
    "Lanczos1": ((0, 1), (2, 3), (4, 5)),
    "Lanczos2": ((0, 1), (2, 3), (4, 5)),
    "Lanczos3": ((0, 1), (2, 3), (4, 5)),
    "MGH17": ((1, 3), (2, 4)),
}
# Parameters whose sign does not matter.
_EVEN = {"Gauss1": (4, 7), "Gauss2": (4, 7), "Gauss3": (4, 7)}


def digits(found: Array, certified: Array) -> float:
    """Log relative error of the worst entry: its number of correct digits."""
    if not np.isfinite(found).all():
        return 0.0
    with np.errstate(divide="ignore"):
        every = -np.log10(np.abs(found - certified) / np.abs(certified))
    return float(np.clip(every, 0, _MOST).min())


def ordered(name: str, values: Array, certified: Array) -> NDArray[np.int64]:
    """The order of the parameters, with equal terms in the order that is closest to the certified.

    Parameters
    ----------
    values : with the signs that `even` gives them
    """
    best = np.arange(len(values))
    terms = _TERMS.get(name, ())
    for places in itertools.permutations(terms):
        order = np.arange(len(values))
        for to, where in zip(terms, places, strict=True):
            order[list(to)] = where
        if digits(values[order], certified) > digits(values[best], certified):
            best = order
    return best


def even(name: str, values: Array) -> Array:
    """Values with the sign of even parameters taken away."""
    found = values.copy()
    for k in _EVEN.get(name, ()):
        found[k] = abs(found[k])
    return found


def by_fit(name: str, start: Array | None, columns: dict[str, Array]) -> tuple[Array, Array, bool]:
    """Parameters, standard errors and whether it converged, by `arael.fit`."""
    count = 1 + max(int(k) for k in re.findall(r"b(\d)", nist.FORMULAS[name]))
    names = [f"b{k}" for k in range(1, count)]
    starts = None if start is None else dict(zip(names, start.tolist(), strict=True))
    found = arael.fit(f"y = {nist.FORMULAS[name]}", columns, start=starts)
    values = np.array([found.parameters[n] for n in names])
    return values, np.array([found.sigma[n] for n in names]), found.converged


def by_model(name: str, start: Array, data: Array) -> tuple[Array, Array, bool]:
    """The same by a model file on the interpreter."""
    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        path = Path(folder) / f"{name}.arael"
        path.write_text(nist.model_text(name, len(start)))
        model = nist.filled(arael.load(path, interpret=True), start, data)
    result = model.solve()
    values = np.array([float(model[f"b{k + 1}"].value) for k in range(len(start))])
    return values, model.covariance(scale="residual").sigma(), result.converged


def by_scipy(name: str, start: Array, columns: dict[str, Array]) -> tuple[Array, Array, bool]:
    """The same by SciPy's `curve_fit`."""
    from scipy.optimize import curve_fit

    x = np.array([column for key, column in columns.items() if key != "y"])
    found, covariance = curve_fit(_function(name), x, columns["y"], start)
    return found, np.sqrt(np.diag(covariance)), True


def by_lmfit(name: str, start: Array, columns: dict[str, Array]) -> tuple[Array, Array, bool]:
    """The same by lmfit's `minimize`; ImportError without it."""
    import lmfit

    function = _function(name)
    x = np.array([column for key, column in columns.items() if key != "y"])
    parameters = lmfit.Parameters()
    for k, value in enumerate(start):
        parameters.add(f"b{k + 1}", value=float(value))
    found = lmfit.minimize(
        lambda p: function(x, *(one.value for one in p.values())) - columns["y"], parameters
    )
    errors = [np.nan if p.stderr is None else p.stderr for p in found.params.values()]
    return np.array([p.value for p in found.params.values()]), np.array(errors), found.success


def measured(name: str) -> Iterator[tuple[str, Digits, bool]]:
    """For each program and start its name, digits, and whether it says that it has converged."""
    values, _, data = nist.parsed((DATA / "nist" / f"{name}.dat").read_text())
    columns = nist.columns(name, data)
    certified, errors = values[:, 2], values[:, 3]
    programs: list[tuple[str, Callable[[], tuple[Array, Array, bool]]]] = [
        ("arael.fit, found", lambda: by_fit(name, None, columns))
    ]
    for k in (0, 1):
        start = values[:, k]
        programs += [
            (f"arael.fit, {k + 1}", lambda start=start: by_fit(name, start, columns)),
            (f"model file, {k + 1}", lambda start=start: by_model(name, start, data)),
            (f"SciPy, {k + 1}", lambda start=start: by_scipy(name, start, columns)),
            (f"lmfit, {k + 1}", lambda start=start: by_lmfit(name, start, columns)),
        ]
    for program, run in programs:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found, sigma, converged = run()
        except (RuntimeError, ValueError, arael.SolveError):
            yield program, _FAILED, False
            continue
        except ImportError:
            continue
        found = even(name, found)
        order = ordered(name, found, certified)
        yield program, (digits(found[order], certified), digits(sigma[order], errors)), converged


def run(plan: Plan, pictures: Path | None = None) -> list[str]:
    """The chapter: digits of parameters / standard errors by set, program and start."""
    names = [name for name in nist.FORMULAS if (DATA / "nist" / f"{name}.dat").exists()]
    names = names[:3] if plan.quick else names
    missing = sorted(set(nist.FORMULAS) - set(names))
    rows, columns = [], []
    with np.errstate(all="ignore"):
        for name in names:
            found = list(measured(name))
            columns = [program for program, _, _ in found]
            rows.append((name, found))
    texts = [
        [name, *(_text(digits, converged) for _, digits, converged in found)]
        for name, found in rows
    ]
    totals = [
        [f"at least {least} digits", *(
            f"{sum(found[k][1][0] >= least for _, found in rows)} of {len(rows)}"
            for k in range(len(columns))
        )]
        for least in (6, 8)
    ]  # fmt: skip
    lines = [
        "## Certified regressions",
        "",
        "Correct digits of the worst parameter / of the worst standard error (log relative error, "
        "at most 11); `!`: the program reports that it has not converged, or failed. The standard "
        "errors of Lanczos1 are rounding of its data, known to three digits.",
        "",
        *table(["set", *columns], [*texts, *totals]),
        "",
    ]
    if not any(program.startswith("lmfit") for program in columns):
        lines += ["lmfit is not installed: `pip install lmfit`.", ""]
    if missing and not plan.quick:
        lines += [f"Not there: {', '.join(missing)} (`ARAEL_DATA`).", ""]
    return lines


def _text(found: Digits, converged: bool) -> str:
    return f"{found[0]:.1f} / {found[1]:.1f}{'' if converged else ' !'}"


def _function(name: str) -> Callable[..., Array]:
    """A formula of the collection as a function of the columns and the parameters."""
    formula = nist.FORMULAS[name]
    count = max(int(k) for k in re.findall(r"b(\d)", formula))
    text = formula.replace("^", "**").replace("atan", "arctan")
    known = {n: getattr(np, n) for n in ("exp", "cos", "sin", "arctan", "sqrt", "pi")}
    code = compile(text, name, "eval")

    def function(x: Array, *b: float) -> Array:
        values = {f"b{k + 1}": b[k] for k in range(count)}
        data = {"x": x[0]} if len(x) == 1 else {"x1": x[0], "x2": x[1]}
        return np.asarray(eval(code, {"__builtins__": {}}, {**known, **values, **data}))

    return function
