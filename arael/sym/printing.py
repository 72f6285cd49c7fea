"""Expressions as text: the language's notation, LaTeX, Python, C."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any

from arael.check.typed import MatrixType, QuaternionType, TransformType, ValueType, VectorType
from arael.sym.errors import fail
from arael.sym.expr import Expr, postorder, size
from arael.sym.latex import LATEX, finished, latex_name
from arael.sym.lowering import lower
from arael.sym.value import Value
from arael.symbolic.graph import Graph
from arael.symbolic.printers.c import c as c_expression
from arael.symbolic.printers.c import c_prelude
from arael.symbolic.printers.infix import LARGEST_TREE, Form, Names, Notation, call, write
from arael.symbolic.printers.python import python as python_expression
from arael.symbolic.printers.text import TEXT
from arael.symbolic.scalars import SCALARS

_FUNCTIONS = {name: call(name, f.arity) if f.arity else Form(name) for name, f in SCALARS.items()}
_TEXT = Notation({**_FUNCTIONS, **TEXT.forms}, TEXT.literal, TEXT.negation)


def text(value: Value) -> str:
    """Write a value in the notation of the language."""
    entries = [_as_written(e, _TEXT, str) for e in value.entries]
    return shaped(value.type, entries)


def latex(value: Value) -> str:
    """Write a value in LaTeX's mathematics."""
    entries = [
        finished(_as_written(e, LATEX, lambda key: latex_name(str(key)))) for e in value.entries
    ]
    if isinstance(value, Expr):
        return entries[0]
    type_ = value.type
    columns = type_.columns if isinstance(type_, MatrixType) else 1
    rows = [" & ".join(entries[i : i + columns]) for i in range(0, len(entries), columns)]
    return "\\begin{bmatrix} " + " \\\\ ".join(rows) + " \\end{bmatrix}"


def python(value: Value) -> str:
    """Write a value as a Python expression over NumPy, imported as ``np``."""
    entries = [_as_code(e, python_expression) for e in value.entries]
    return (
        entries[0]
        if isinstance(value, Expr)
        else f"np.array({shaped(_listed(value.type), entries)})"
    )


def c(value: Value, real: str = "double") -> str:
    """Write a value as a C expression; one of several scalars as a braced list of them."""
    if real not in ("double", "float"):
        raise ValueError(f"C's real numbers are `double` or `float`, not {real!r}")
    entries = [
        _as_code(e, lambda g, n, names: c_expression(g, n, names, real), simplify=True)
        for e in value.entries
    ]
    return entries[0] if isinstance(value, Expr) else "{" + ", ".join(entries) + "}"


def c_function(name: str, value: Value, by: Sequence[Expr | str] | None = None) -> str:
    """Write a C function of doubles that computes a value, shared subexpressions once.

    A scalar is returned; the scalars of anything else are written to ``out``. The text begins with
    what it needs of ``math.h`` and more.

    Parameters
    ----------
    name : of the C function
    value : what it computes
    by : its arguments; by default the variables in alphabetical order
    """
    from arael.sym.sharing import cse

    names = [code_name(str(v)) for v in (value.free_vars if by is None else by)]
    shared = cse(value)
    (result,) = shared.values
    scalar = isinstance(value, Expr)
    parameters = [f"double {n}" for n in names] + ([] if scalar else ["double *out"])
    lines = [f"{'double' if scalar else 'void'} {name}({', '.join(parameters) or 'void'}) {{"]
    lines += [f"    const double {t.name} = {c(e)};" for t, e in shared.temporaries]
    if scalar:
        lines.append(f"    return {c(result)};")
    else:
        lines += [f"    out[{i}] = {c(e)};" for i, e in enumerate(result.entries)]
    return c_prelude() + "\n".join([*lines, "}"]) + "\n"


def code_name(key: Hashable) -> str:
    """Name of a variable in Python and C."""
    return str(key).replace(".", "_")


def _as_written(e: Expr, notation: Notation, names: Names) -> str:
    _check_size(e)
    g = Graph(simplify=False)
    forms: dict[str, Form] = {}
    made: dict[int, int] = {}
    for node in postorder([e]):
        args = tuple(made[id(a)] for a in node.args)
        if node.op == "const":
            made[id(node)] = g.const(node.data)
        elif node.op == "symbol":
            made[id(node)] = g.input(node.data)
        elif node.op == "call":
            key = f"call {node.data.name}"
            template = call(node.data.name, len(args)).template
            forms[key] = Form(template, operands=(0,) * len(args))
            made[id(node)] = g.intern(key, args)
        else:
            made[id(node)] = g.intern(node.op, args)
    if forms:
        notation = Notation({**notation.forms, **forms}, notation.literal, notation.negation)
    return write(g, made[id(e)], notation, names)


def _as_code(e: Expr, print_: Callable[[Graph, int, Names], str], *, simplify: bool = False) -> str:
    _check_size(e)
    lowered = lower([e], simplify=simplify)

    def inner(arg: Expr) -> str:
        return _as_code(arg, print_, simplify=simplify)

    def name(key: Any) -> str:
        if isinstance(key, Expr):  # a call of a native function
            return f"{key.data.name}({', '.join(inner(a) for a in key.args)})"
        return code_name(key)

    _check_size_of(lowered.graph.tree_operations(lowered.nodes))
    return print_(lowered.graph, lowered.nodes[0], name)


def _check_size(e: Expr) -> None:
    _check_size_of(size([e], LARGEST_TREE + 1))


def _check_size_of(operations: int) -> None:
    if operations > LARGEST_TREE:
        fail(
            "E0653",
            f"written out, the expression has more than {LARGEST_TREE} operations",
            origin="printing",
            help=("take out what is shared first, with `cse`",),
        )


def _listed(type_: ValueType) -> ValueType:
    """Matrices by rows, anything else as a plain list."""
    return type_ if isinstance(type_, MatrixType) else VectorType(1)


def shaped(type_: ValueType, entries: list[str]) -> str:
    """Write the scalars of a value of type `type_`, each written already."""
    if isinstance(type_, MatrixType):
        n = type_.columns
        rows = [f"[{', '.join(entries[i : i + n])}]" for i in range(0, len(entries), n)]
        return f"[{', '.join(rows)}]"
    if isinstance(type_, QuaternionType):
        return f"quat({', '.join(entries)})"
    if isinstance(type_, TransformType):
        return f"{type_}({', '.join(entries)})"
    return f"[{', '.join(entries)}]" if isinstance(type_, VectorType) else entries[0]
