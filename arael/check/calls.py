"""Rule: a call names an existing function and passes matching arguments.

Allowed: ``atan2(y, x)``, ``M.transpose()`` and ``transpose(M)``, functions of the
model in any order.

Not allowed: ``sin(1, 2)``, ``norm(3)``, ``sine(x)``, a method on a struct.
"""

from __future__ import annotations

from arael.check.access import constant_index
from arael.check.binding import BROKEN, Binding, Broken, Collection, Entity
from arael.check.builtins import (
    FUNCTIONS,
    IDENTITIES,
    METHODS,
    ROW_METHODS,
    Signature,
    is_number,
)
from arael.check.look_ups import look_up
from arael.check.scope import ConstantScope
from arael.check.suggest import nearest
from arael.check.typed import INT, REAL, Invoke, Literal_, MatrixType, Typed, VectorType
from arael.check.typist import Typist
from arael.diagnostics.records import Label, Span
from arael.syntax import tree

# Methods of other libraries, and what arael writes.
_OTHER_METHODS = {
    "length": "norm(v)", "magnitude": "norm(v)", "normalize": "unit(v)", "normalized": "unit(v)",
    "ln": "log(x)", "pow": "x ^ n",
}  # fmt: skip


def call(t: Typist, node: tree.Call) -> Binding:
    """``f(args)`` or ``obj.method(args)``."""
    func = node.func
    if isinstance(func, tree.Attribute):
        return _method(t, node, func)
    if not isinstance(func, tree.Name):
        return t.fail(
            "E0205", func.span, "expected the name of a function", label="cannot be called"
        )
    if func.id in t.declarations.functions:
        return _user(t, node, t.declarations.functions[func.id])
    if func.id in FUNCTIONS:
        args = _arguments(t, node.args)
        return BROKEN if args is None else _builtin(t, node, func.id, func.span, args)
    if func.id in IDENTITIES:
        if node.args:
            return _arity(t, node, func.span, func.id, "no", len(node.args))
        return t.apply(node, func.id, [], IDENTITIES[func.id])
    return _unknown(t, node, func)


def _unknown(t: Typist, node: tree.Call, func: tree.Name) -> Broken:
    _arguments(t, node.args)
    if func.id in t.declarations.broken:
        return BROKEN
    help_: list[str] = []
    if func.id in ROW_METHODS:
        help_ = [f"write `M.{func.id}(i)`"]
    else:
        near = nearest(func.id, [*t.declarations.functions, *FUNCTIONS, *IDENTITIES])
        if near:
            help_ = [f"did you mean `{near}`?"]
    return t.fail(
        "E0205", func.span, f"unknown function `{func.id}`", label="not found", help=help_
    )


def _arguments(t: Typist, nodes: tuple[tree.Expr, ...]) -> list[Typed] | None:
    """Values of arguments; None if one of them is in error."""
    typed: list[Typed] = []
    broken = False
    for node in nodes:
        value = t.number(node)
        if isinstance(value, Broken):
            broken = True
        else:
            typed.append(value)
    return None if broken else typed


def _arity(
    t: Typist, node: tree.Call, at: Span, name: str, takes: str, count: int, *labels: Label
) -> Broken:
    noun = "argument" if takes == "1" else "arguments"
    return t.fail(
        "E0303",
        node.span,
        f"`{name}` takes {takes} {noun}, found {count}",
        label="in this call",
        labels=labels,
    )


def _builtin(
    t: Typist, node: tree.Call, name: str, at: Span, args: list[Typed], method: bool = False
) -> Binding:
    signature: Signature = FUNCTIONS[name]
    if len(args) < signature.least or (signature.most is not None and len(args) > signature.most):
        count = len(args) - method
        takes = signature.arity if not method else (str(signature.least - 1).replace("0", "no"))
        return _arity(t, node, at, name, takes, count)
    result = signature.result([a.type for a in args])
    if result is None:
        types_text = ", ".join(str(a.type) for a in args)
        labels = [Label(a.span, f"this is {a.type}") for a in args]
        labels += [label for a in args for label in t.origin(a)]
        help_: list[str] = []
        if name == "norm" and args[0].type == INT:
            help_ = ["write `abs(x)` for a scalar"]
        return t.fail(
            "E0302",
            node.span,
            f"`{name}` takes {signature.takes}, found {types_text}",
            labels=labels,
            help=help_,
        )
    operation, type_ = result if isinstance(result, tuple) else (name, result)
    if name in ("min", "max") and len(args) > 2:
        first, *rest = args
        for other in rest:
            joined = t.apply(node, name, [first, other], type_)
            if not isinstance(joined, Typed):
                return BROKEN
            first = joined
        return first
    return t.apply(node, operation, args, type_)


def _method_help(t: Typist, func: tree.Attribute, near: str) -> list[str]:
    """Help for an unknown method."""
    if func.name in _OTHER_METHODS:
        return [f"write `{_OTHER_METHODS[func.name]}`"]
    if func.name in FUNCTIONS or func.name in t.declarations.functions:
        return [f"`{func.name}` is a function: write `{func.name}({func.obj.span.text})`"]
    return [f"did you mean `{near}`?"] if near else []


def _method(t: Typist, node: tree.Call, func: tree.Attribute) -> Binding:
    owner = t.visit(func.obj)
    if isinstance(owner, Broken):
        _arguments(t, node.args)
        return BROKEN
    if isinstance(owner, Collection):
        return look_up(t, node, func, owner)
    if isinstance(owner, Entity) or func.name not in METHODS:
        names = sorted(METHODS)
        near = nearest(func.name, names)
        _arguments(t, node.args)
        what = owner.place.struct.name if isinstance(owner, Entity) else "a value"
        return t.fail(
            "E0205",
            func.name_span,
            f"{what} has no method `{func.name}`",
            label="unknown method",
            help=_method_help(t, func, near if not isinstance(owner, Entity) else ""),
        )
    value = t.as_value(owner, func.obj.span)
    if isinstance(value, Broken):
        return BROKEN
    if func.name in ROW_METHODS:
        return _row(t, node, func, value)
    args = _arguments(t, node.args)
    if args is None:
        return BROKEN
    return _builtin(t, node, func.name, func.name_span, [value, *args], method=True)


def _row(t: Typist, node: tree.Call, func: tree.Attribute, value: Typed) -> Binding:
    """``M.row(i)`` and ``M.col(i)``."""
    if len(node.args) != 1:
        return _arity(t, node, func.name_span, func.name, "1", len(node.args))
    if not isinstance(value.type, MatrixType):
        return t.fail(
            "E0302",
            func.obj.span,
            f"`{func.name}` takes a matrix, found {value.type}",
            labels=t.origin(value),
        )
    matrix = value.type
    rows = func.name == "row"
    i = constant_index(t, node.args[0], matrix.rows if rows else matrix.columns, str(matrix))
    if i is None:
        return BROKEN
    at = Literal_(type=INT, span=node.args[0].span, value=float(i))
    size = matrix.columns if rows else matrix.rows
    return t.apply(node, ROW_METHODS[func.name], [value, at], VectorType(size))


def _user(t: Typist, node: tree.Call, function: tree.Function) -> Binding:
    """A call of a function of the model: its formula inlined, with its own derivatives."""
    name = function.name.id
    args: list[Typed] = []
    for arg in node.args:
        value = t.value(arg)
        if not isinstance(value, Broken):
            args.append(value)
    if len(node.args) != len(function.params):
        return _arity(
            t,
            node,
            node.func.span,
            name,
            str(len(function.params)),
            len(node.args),
            Label(function.name.span, "declared here"),
        )
    if len(args) < len(node.args) or name in t.declarations.broken:
        return BROKEN
    if function.derivs is None:
        return _expanded(t, node, function, args)
    for value in args:
        if not is_number(value.type):
            return t.fail(
                "E0671",
                value.span,
                f"`{name}` takes scalars, found {value.type}",
                label=f"this is {value.type}",
                labels=[
                    Label(function.name.span, "a function with `derivs`"),
                    *t.origin(value),
                ],
                help=["call it for each component"],
            )
    formula = _expanded(t, node, function, args) if function.body is not None else None
    if isinstance(formula, Broken):
        return BROKEN
    assert formula is None or isinstance(formula, Typed)
    return t.make(Invoke(type=REAL, span=node.span, function=name, args=tuple(args), value=formula))


def _expanded(t: Typist, node: tree.Call, function: tree.Function, args: list[Typed]) -> Binding:
    """The formula of a function for these arguments; cached by arguments."""
    name = function.name.id
    assert function.body is not None
    key = (name, tuple(args))
    if key not in t.expanded:
        parameters: dict[str, tuple[Binding, Span]] = {
            p.id: (a, p.span) for p, a in zip(function.params, args, strict=True)
        }
        scope = ConstantScope(t.declarations, t.constant, parameters, f"`{name}`")
        with t.inside(name, node.span, scope):
            result = t.value(function.body)
        t.expanded[key] = result
    return t.expanded[key]
