"""Block losses: residuals whose squares sum to a function of the squared residual.

A constraint with residuals r and a loss rho costs ``rho(s)``, s = |r|^2. Its residuals are replaced
by ``r sqrt(rho(s) / s)``, whose squares sum to exactly that. Cost, gradient (``2 rho'(s) J' r``),
Gauss-Newton Hessian, Jacobian rows and covariance agree with each other. For a scalar residual the
Hessian is that of Gauss-Newton on ``sqrt(rho(r^2))``, the same as if the residual had been
robustified from within.

For several residuals, rows are ``(a (I - u u') + b u u') J`` with ``u = r / |r|``. The exact
gradient requires ``b = rho' sqrt(s / rho)``; ``a`` is free, because r has no part across itself.
The second derivative of ``rho(|r|^2)`` across r is exactly ``2 rho'(s)``, so ``a = sqrt(rho')``
(Triggs et al., "Bundle adjustment: a modern synthesis", 2000, section 4.3). The derivative of
``r sqrt(rho / s)`` would have ``a = sqrt(rho / s)``, which is larger and makes steps too short.
Where the loss is flat, ``rho' = 0`` would leave parameters without any curvature: `_ACROSS` is the
least share of ``rho / s`` that remains.

At s = 0 the factor is ``sqrt(rho'(0))``, which is 1 for the losses that have a name.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import TypeVar

from arael.check.typed import Loss
from arael.compiler.scalarise import Calls, Scalariser
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import jacobian
from arael.symbolic.series import polynomial

Seed = TypeVar("Seed", bound=Hashable)

# Of a loss of the model's own, below this share of curvature in its slope, rho(s) / s is taken from
# derivatives: there, rounding of rho(s) would cost more than the term that is left out.
_STRAIGHT = {False: 1e-5, True: 5e-3}

# Least s at which a loss of the model's own is evaluated, in f64 and in f32: a square root in it
# has no slope at zero.
_LEAST = {False: 1e-30, True: 1e-12}

# The loss `fair` is summed from a series below this residual, in units of its scale.
_FAIR_SERIES = 0.1

# Least curvature across the residual, as a share of rho(s) / s.
_ACROSS = 0.01


def robustify(
    scalariser: Scalariser, residuals: list[int], loss: Loss, single: bool = False
) -> list[int]:
    """Residuals whose squares sum to `loss` of the sum of the squares of `residuals`."""
    g = scalariser.graph
    with scalariser.at(loss.span):
        s = g.op("mul", residuals[0], residuals[0])
        for r in residuals[1:]:
            s = g.op("add", s, g.op("mul", r, r))
        length = s
        argument = g.input(loss)
        if loss.argument is None:
            ratio, slope = _named(scalariser, argument, loss)
        else:
            ratio, slope = _own(scalariser, argument, loss, single)
            s = g.op("max", s, g.const(_LEAST[single]))
        weight = g.op("sqrt", ratio)
        # Along the residual: rho' sqrt(s / rho), exactly 0 where the loss is flat.
        along = g.op("div", slope, weight)
        if len(residuals) == 1:
            weight, along = g.copy([weight, along], g, {argument: s})
            (r,) = residuals
            return [g.custom(g.op("mul", weight, r), [(r, along)])]
        across = g.op("sqrt", g.op("max", slope, g.op("mul", g.const(_ACROSS), ratio)))
        squared = g.op("max", argument, g.const(_LEAST[single]))
        # Of the change of s = |r|^2, which is 2 r' dr.
        more = g.op("div", g.op("mul", g.const(0.5), g.op("sub", along, across)), squared)
        weight, across, more = g.copy([weight, across, more], g, {argument: s})
        return [
            g.custom(g.op("mul", weight, r), [(r, across), (length, g.op("mul", more, r))])
            for r in residuals
        ]


def robust_rows(
    graph: Graph,
    residuals: list[int],
    seeds: Mapping[int, Mapping[Seed, int]],
    loss: Loss,
    functions: Calls,
    single: bool = False,
) -> tuple[list[int], list[dict[Seed, int]]]:
    """Residuals after a loss with a constant scale, and their derivatives.

    Parameters
    ----------
    seeds : derivatives of the residuals, as those of `arael.symbolic.jacobian.jacobian`
    """
    robust = robustify(Scalariser(graph, _NoUses(), functions), residuals, loss, single)
    return robust, jacobian(graph, robust, seeds, ["forward"])


class _NoUses:
    """What a loss with a constant scale reads: nothing."""

    def stored(self, slot: int, column: str) -> Sequence[tuple[int, int]]:
        raise AssertionError(column)

    def cached(self, slot: int, column: str, cache: str) -> Sequence[tuple[int, int]]:
        raise AssertionError(column)

    def formula(self, slot: int, column: str) -> Sequence[tuple[int, int]] | None:
        raise AssertionError(column)


def _named(scalariser: Scalariser, s: int, loss: Loss) -> tuple[int, int]:
    """``rho(s) / s`` and ``rho'(s)`` of a loss that has a name."""
    g = scalariser.graph
    (scale,) = scalariser.nodes(loss.value)
    slope, ratio = _LOSSES[loss.name]
    return ratio(g, s, scale), slope(g, s, scale)


def _own(scalariser: Scalariser, s: int, loss: Loss, single: bool) -> tuple[int, int]:
    """The same of a loss of the model's own, from its expression and two derivatives of it."""
    g = scalariser.graph
    assert loss.argument is not None
    scalariser.assume(loss.argument, [s])
    (rho,) = scalariser.nodes(loss.value)
    first = _slope(g, rho, s)
    bend = g.op("mul", s, _slope(g, first, s))
    straight = g.op("lt", g.op("abs", bend), g.op("mul", g.const(_STRAIGHT[single]), first))
    expanded = g.op("sub", first, g.op("mul", g.const(0.5), bend))
    return g.op("select", straight, expanded, g.op("div", rho, s)), first


def _slope(g: Graph, node: int, argument: int) -> int:
    """Derivative of `node` by `argument`."""
    (row,) = jacobian(g, [node], {argument: {0: g.const(1.0)}}, ["forward"])
    return row.get(0, g.const(0.0))


def _share(g: Graph, s: int, c: int) -> int:
    """The squared residual in units of the scale, s / c^2."""
    return g.op("div", s, g.op("mul", c, c))


def _cauchy(g: Graph, s: int, c: int) -> int:
    """c^2 log(1 + s / c^2)."""
    logarithm = g.op("log", g.op("add", g.const(1.0), _share(g, s, c)))
    return g.op("mul", g.op("mul", c, c), logarithm)


def _cauchy_ratio(g: Graph, s: int, c: int) -> int:
    """log(1 + x) / x after Kahan: log(u) / (u - 1) at the rounded u = 1 + x."""
    one = g.const(1.0)
    u = g.op("identity", g.op("add", one, _share(g, s, c)))
    nothing = g.op("eq", u, one)
    beyond = g.op("select", nothing, one, g.op("sub", u, one))
    return g.op("select", nothing, one, g.op("div", g.op("log", u), beyond))


def _geman_mcclure(g: Graph, s: int, c: int) -> int:
    """c^2 s / (c^2 + s), as c^2 (1 - 1 / (1 + s / c^2)), whose slope does not cancel."""
    one = g.const(1.0)
    rest = g.op("div", one, g.op("add", one, _share(g, s, c)))
    return g.op("mul", g.op("mul", c, c), g.op("sub", one, rest))


def _geman_mcclure_ratio(g: Graph, s: int, c: int) -> int:
    one = g.const(1.0)
    return g.op("div", one, g.op("add", one, _share(g, s, c)))


def _huber(g: Graph, s: int, k: int) -> int:
    """Linear beyond k: s up to k^2, 2 k sqrt(s) - k^2 beyond."""
    square = g.op("mul", k, k)
    beyond = g.op("sub", g.op("mul", g.op("mul", g.const(2.0), k), g.op("sqrt", s)), square)
    return g.op("select", g.op("le", s, square), s, beyond)


def _huber_ratio(g: Graph, s: int, k: int) -> int:
    """That is q (2 - q) with q = k / sqrt(s), and s not under k^2, where it is 1."""
    share = g.op("div", k, g.op("sqrt", g.op("max", s, g.op("mul", k, k))))
    return g.op("mul", share, g.op("sub", g.const(2.0), share))


def _tukey(g: Graph, s: int, c: int) -> int:
    """c^2 (1 - (1 - s / c^2)^3) / 3 up to c^2, c^2 / 3 beyond."""
    one, third = g.const(1.0), g.const(1 / 3)
    left = g.op("max", g.op("sub", one, _share(g, s, c)), g.const(0.0))
    cube = g.op("mul", left, g.op("mul", left, left))
    return g.op("mul", g.op("mul", third, g.op("mul", c, c)), g.op("sub", one, cube))


def _tukey_ratio(g: Graph, s: int, c: int) -> int:
    """1 - x + x^2 / 3 up to x = 1, 1 / (3 x) beyond."""
    one, third = g.const(1.0), g.const(1 / 3)
    x = _share(g, s, c)
    inside = g.op("sub", one, g.op("sub", x, g.op("mul", third, g.op("mul", x, x))))
    return g.op("select", g.op("le", x, one), inside, g.op("div", third, x))


def _soft_l1(g: Graph, s: int, c: int) -> int:
    """2 c^2 (sqrt(1 + s / c^2) - 1)."""
    one = g.const(1.0)
    root = g.op("sqrt", g.op("add", one, _share(g, s, c)))
    return g.op("mul", g.op("mul", g.const(2.0), g.op("mul", c, c)), g.op("sub", root, one))


def _soft_l1_ratio(g: Graph, s: int, c: int) -> int:
    """2 / (1 + sqrt(1 + x)): the difference above, rationalised."""
    one = g.const(1.0)
    root = g.op("sqrt", g.op("add", one, _share(g, s, c)))
    return g.op("div", g.const(2.0), g.op("add", one, root))


def _welsch(g: Graph, s: int, c: int) -> int:
    """c^2 (1 - exp(-s / c^2))."""
    falling = g.op("exp", g.op("neg", _share(g, s, c)))
    return g.op("mul", g.op("mul", c, c), g.op("sub", g.const(1.0), falling))


def _welsch_ratio(g: Graph, s: int, c: int) -> int:
    """(1 - exp(-x)) / x."""
    x = _share(g, s, c)
    zero, one = g.const(0.0), g.const(1.0)
    nothing = g.op("eq", x, zero)
    away = g.op("select", nothing, one, x)
    value = g.op("div", g.op("neg", g.op("expm1", g.op("neg", away))), away)
    return g.op("select", nothing, one, value)


def _fair_slope(g: Graph, s: int, c: int) -> int:
    """1 / (1 + y), y = sqrt(s) / c. Not derived from rho: sqrt has no derivative at zero."""
    one = g.const(1.0)
    return g.op("div", one, g.op("add", one, g.op("div", g.op("sqrt", s), c)))


def _fair_ratio(g: Graph, s: int, c: int) -> int:
    """2 (y - log(1 + y)) / y^2, by a series for small y, where the difference cancels.

    With z = y / (2 + y), log(1 + y) = 2 (z + z^3/3 + z^5/5 + ...) and y - 2 z = y z, so that the
    ratio is 2 / (2 + y) (1 - 2 z / (2 + y) (1/3 + z^2/5 + z^4/7 + ...)).
    """
    one, two = g.const(1.0), g.const(2.0)
    y = g.op("div", g.op("sqrt", s), c)
    small = g.op("lt", y, g.const(_FAIR_SERIES))
    away = g.op("select", small, one, y)
    rest = g.op("sub", away, g.op("log1p", away))
    closed = g.op("div", g.op("mul", two, rest), g.op("mul", away, away))
    share = g.op("div", two, g.op("add", two, y))
    z = g.op("mul", g.op("mul", g.const(0.5), share), y)
    terms = polynomial(g, g.op("mul", z, z), [1 / k for k in range(3, 17, 2)])
    series = g.op("mul", share, g.op("sub", one, g.op("mul", g.op("mul", share, z), terms)))
    return g.op("select", small, series, closed)


def _dcs(g: Graph, s: int, c: int) -> int:
    """Quadratic up to c^2, c^2 (3 s - c^2) / (s + c^2) beyond, as c^2 (3 - 4 / (1 + s / c^2))."""
    square = g.op("mul", c, c)
    rest = g.op("div", g.const(4.0), g.op("add", g.const(1.0), _share(g, s, c)))
    beyond = g.op("mul", square, g.op("sub", g.const(3.0), rest))
    return g.op("select", g.op("le", s, square), s, beyond)


def _dcs_ratio(g: Graph, s: int, c: int) -> int:
    """(3 - 1/x) / (1 + x) with x not under 1, where it is 1."""
    one = g.const(1.0)
    x = g.op("max", _share(g, s, c), one)
    above = g.op("sub", g.const(3.0), g.op("div", one, x))
    return g.op("div", above, g.op("add", one, x))


_Function = Callable[[Graph, int, int], int]


def _derived(rho: _Function) -> _Function:
    """The slope of `rho`, by differentiation."""
    return lambda g, s, c: _slope(g, rho(g, s, c), s)


# rho'(s), and rho(s) / s in a form that is finite and loses no digits from s = 0 on. Sources:
# docs/robust.md.
_LOSSES: dict[str, tuple[_Function, _Function]] = {
    "cauchy": (_derived(_cauchy), _cauchy_ratio),
    "dcs": (_derived(_dcs), _dcs_ratio),
    "fair": (_fair_slope, _fair_ratio),
    "geman_mcclure": (_derived(_geman_mcclure), _geman_mcclure_ratio),
    "huber": (_derived(_huber), _huber_ratio),
    "soft_l1": (_derived(_soft_l1), _soft_l1_ratio),
    "tukey": (_derived(_tukey), _tukey_ratio),
    "welsch": (_derived(_welsch), _welsch_ratio),
}
