"""From graphs to SymPy, for users who want to go on there, for LaTeX, and as an oracle of tests."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from arael.runtime.machine.library import FUNCTIONS
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Names, default_name

if TYPE_CHECKING:
    import sympy

_LARGEST_DENOMINATOR = 1024


def to_sympy(
    g: Graph,
    nodes: Iterable[int],
    symbols: Callable[[Hashable], Any] | None = None,
) -> list[Any]:
    """Convert nodes to SymPy expressions over the reals.

    Parameters
    ----------
    g, nodes : what to convert
    symbols : gives the expression that stands for an input's key; by default a real symbol of its
    name

    Returns
    -------
    One expression per node. Numbers that are short binary fractions become rationals. ``identity``
    and prescribed derivatives have no counterpart in SymPy: their values are taken.
    """
    import sympy as sp

    table = _operations()
    built: dict[int, Any] = {}
    for node in g.live(nodes := list(nodes)):
        name, value = g.ops[node], g.value(node)
        if value is not None:
            built[node] = _number(value)
        elif name == "input":
            key = g.key(node)
            built[node] = (
                sp.Symbol(default_name(key), real=True) if symbols is None else symbols(key)
            )
        elif g.is_free(node):
            built[node] = built[g.args[node][0]]
        elif name in g.functions:
            native = sp.Function(g.functions[name].name, real=True)
            built[node] = native(*(built[a] for a in g.args[node]))
        else:
            built[node] = table[name](*(built[a] for a in g.args[node]))
    return [built[node] for node in nodes]


def latex(g: Graph, node: int, names: Names = default_name) -> str:
    """Write `node` in LaTeX's mathematics, by SymPy; names may be LaTeX themselves."""
    import sympy as sp

    (expression,) = to_sympy(g, [node], lambda key: sp.Symbol(names(key), real=True))
    return str(sp.latex(expression))


def _number(value: float) -> Any:
    import sympy as sp

    if value != value or value in (float("inf"), float("-inf")):
        return sp.nan if value != value else sp.oo if value > 0 else -sp.oo
    numerator, denominator = value.as_integer_ratio()
    if denominator <= _LARGEST_DENOMINATOR:
        return sp.Rational(numerator, denominator)
    return sp.Float(value)


def _operations() -> Mapping[str, Callable[..., sympy.Expr]]:
    import sympy as sp

    from arael.symbolic.functions import sympy_function

    def condition(number: Any) -> Any:
        """Undo `indicator`, so that conditions do not become numbers and conditions again."""
        if isinstance(number, sp.Piecewise) and number.args[0][0] == 1 and len(number.args) == 2:
            return number.args[0][1]
        return sp.Ne(number, 0)

    def indicator(truth: Any) -> Any:
        return sp.Piecewise((1, truth), (0, True))

    return {
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
        "neg": lambda a: -a,
        **{f.name: sympy_function(f) for f in FUNCTIONS},
        "pow": lambda a, b: a**b,
        "cbrt": lambda a: sp.sign(a) * sp.Abs(a) ** sp.Rational(1, 3),
        "log2": lambda a: sp.log(a, 2),
        "log10": lambda a: sp.log(a, 10),
        "hypot": lambda a, b: sp.sqrt(a**2 + b**2),
        "expm1": lambda a: sp.exp(a) - 1,
        "log1p": lambda a: sp.log(1 + a),
        "lgamma": lambda a: sp.log(sp.Abs(sp.gamma(a))),
        "abs": sp.Abs,
        "sign": sp.sign,
        "heaviside": lambda a: sp.Heaviside(a, sp.Rational(1, 2)),
        "floor": sp.floor,
        "ceil": sp.ceiling,
        "round": lambda a: sp.sign(a) * sp.floor(sp.Abs(a) + sp.Rational(1, 2)),
        "min": sp.Min,
        "max": sp.Max,
        "identity": lambda a: a,
        "lt": lambda a, b: indicator(sp.Lt(a, b)),
        "le": lambda a, b: indicator(sp.Le(a, b)),
        "eq": lambda a, b: indicator(sp.Eq(a, b)),
        "ne": lambda a, b: indicator(sp.Ne(a, b)),
        "and": lambda a, b: indicator(sp.And(condition(a), condition(b))),
        "or": lambda a, b: indicator(sp.Or(condition(a), condition(b))),
        "not": lambda a: indicator(sp.Not(condition(a))),
        "select": lambda c, a, b: sp.Piecewise((a, condition(c)), (b, True)),
    }
