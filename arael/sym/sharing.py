"""Common subexpressions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from arael.sym.expr import LEAVES, Expr, free_names, postorder, remake
from arael.sym.shapes import as_value
from arael.sym.value import Value

_COMMUTE = frozenset({"add", "mul", "and", "or", "eq", "ne"})
_FREE = frozenset({"neg"})


class Shared(NamedTuple):
    """Expressions with what they share taken out.

    Attributes
    ----------
    temporaries : pairs of a new variable and what it stands for; each may use those before it
    values : the values, over variables and temporaries
    """

    temporaries: list[tuple[Expr, Expr]]
    values: list[Value]

    def __str__(self) -> str:
        lines = [f"{name} = {value}" for name, value in self.temporaries]
        return "\n".join([*lines, *map(str, self.values)])


def cse(values: Value | Sequence[Any], prefix: str = "t") -> Shared:
    """Take out what occurs more than once, as temporaries ``t0``, ``t1``, ... in order of use.

    ``a + b`` and ``b + a`` are the same, as their values are equal to the last bit; sums are not
    reordered beyond that. Names that the expressions use already are passed over.
    """
    wanted = [values] if isinstance(values, Value) else [as_value(v) for v in values]
    roots = [e for v in wanted for e in v.entries]
    order = list(postorder(roots))
    numbers, uses = _numbered(order, roots)
    taken = set(free_names(roots))
    temporaries: list[tuple[Expr, Expr]] = []
    new: dict[int, Expr] = {}
    for node in order:
        number = numbers[id(node)]
        if number in new:
            continue
        args = tuple(new[numbers[id(a)]] for a in node.args)
        made = node if not args else remake(node, args)
        if node.op not in LEAVES and node.op not in _FREE and args and uses[number] > 1:
            name = Expr("symbol", (), _fresh(prefix, len(temporaries), taken))
            temporaries.append((name, made))
            made = name
        new[number] = made
    entries = iter([new[numbers[id(r)]] for r in roots])
    return Shared(temporaries, [v.with_entries([next(entries) for _ in v.entries]) for v in wanted])


def _numbered(order: list[Expr], roots: list[Expr]) -> tuple[dict[int, int], dict[int, int]]:
    """Equal numbers for equal expressions, by ``id``; and how often each number is used."""
    known: dict[Any, int] = {}
    numbers: dict[int, int] = {}
    uses: dict[int, int] = {}
    for node in order:
        args = tuple(numbers[id(a)] for a in node.args)
        key = (node.op, node.data, tuple(sorted(args)) if node.op in _COMMUTE else args)
        fresh = key not in known
        number = known.setdefault(key, len(known))
        numbers[id(node)] = number
        if fresh:
            uses[number] = 0
            for a in args:
                uses[a] += 1
    for root in roots:
        uses[numbers[id(root)]] += 1
    return numbers, uses


def _fresh(prefix: str, at: int, taken: set[str]) -> str:
    name = f"{prefix}{at}"
    while name in taken:
        name += "_"
    taken.add(name)
    return name
