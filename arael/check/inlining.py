"""Rule: a function of the model can be inlined.

Allowed: functions that call each other in any order; unused ones; `derivs` that call any function,
including their own.

Not allowed: a formula that calls itself, directly or through others; a name in it that is neither
a parameter nor a constant; two parameters of one name; more or fewer `derivs` than parameters.
"""

from __future__ import annotations

from itertools import pairwise

from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES
from arael.check.declared import Declarations
from arael.check.report import Reporter
from arael.check.suggest import nearest
from arael.check.walk import subtrees
from arael.diagnostics.records import Label
from arael.syntax import tree


def check_functions(declarations: Declarations, report: Reporter) -> None:
    """Check all functions; those in error are marked, so that their calls are not reported."""
    visible = {*declarations.consts, *CONSTANTS, *IDENTITIES, *declarations.broken}
    callable_ = {*declarations.functions, *FUNCTIONS, *IDENTITIES, *declarations.broken}
    for name, function in declarations.functions.items():
        good = _counted(function, report)
        if not (_names(function, visible, callable_, report) and good):
            declarations.broken.add(name)
    _recursion(declarations, report)


def _counted(function: tree.Function, report: Reporter) -> bool:
    """Whether there is one derivative per parameter."""
    if function.derivs is None or len(function.derivs) == len(function.params):
        return True
    takes, gives = len(function.params), len(function.derivs)
    last = function.derivs[-1].span
    report.error(
        "E0670",
        function.derivs[0].span.to(last),
        f"`{function.name.id}` takes {takes} argument{'s' * (takes != 1)}, but has {gives} "
        f"derivative{'s' * (gives != 1)}",
        label="one expression per argument",
        labels=[Label(function.name.span, "declared here")],
        help=[
            "write the partial derivatives in order: "
            + f"`derivs [{', '.join(f'd/d{p.id}' for p in function.params)}]`"
        ],
    )
    return False


def _formulas(function: tree.Function) -> tuple[tree.Expr, ...]:
    return (*(() if function.body is None else (function.body,)), *(function.derivs or ()))


def _names(
    function: tree.Function, visible: set[str], callable_: set[str], report: Reporter
) -> bool:
    good = True
    parameters: dict[str, tree.Ident] = {}
    for parameter in function.params:
        if parameter.id in parameters:
            good = False
            report.error(
                "E0207",
                parameter.span,
                f"parameter `{parameter.id}` is declared twice",
                labels=[Label(parameters[parameter.id].span, "first declared here")],
            )
        parameters[parameter.id] = parameter
    nodes = [node for formula in _formulas(function) for node in subtrees(formula)]
    for before, node in pairwise([None, *nodes]):
        if not isinstance(node, tree.Name):
            continue
        called = isinstance(before, tree.Call)  # the function is the first part of a call
        names = callable_ if called else visible
        if node.id in names or (names is visible and node.id in parameters):
            continue
        good = False
        near = nearest(
            node.id, sorted(names) if names is callable_ else [*parameters, *sorted(names)]
        )
        if called:
            report.error(
                "E0205",
                node.span,
                f"unknown function `{node.id}`",
                label="not found",
                help=[f"did you mean `{near}`?"] if near else [],
            )
        else:
            report.error(
                "E0201",
                node.span,
                f"unknown name `{node.id}`",
                label=f"not a parameter of `{function.name.id}`",
                help=[f"did you mean `{near}`?"]
                if near
                else ["a function uses its parameters and constants only; pass it as an argument"],
            )
    return good


def _recursion(declarations: Declarations, report: Reporter) -> None:
    calls = {
        name: _calls(function, declarations) for name, function in declarations.functions.items()
    }
    finished: set[str] = set()
    for start in calls:
        # Depth-first search with an explicit stack: chains of functions may be long.
        trail: dict[str, None] = {}
        waiting: list[tuple[str, bool]] = [(start, False)]
        while waiting:
            name, leaving = waiting.pop()
            if leaving:
                finished.add(trail.popitem()[0])
            elif name in trail:
                on_trail = list(trail)
                circle = on_trail[on_trail.index(name) :]
                declarations.broken.update(circle)
                _report_cycle(circle, calls, declarations, report)
            elif name not in finished:
                trail[name] = None
                waiting.append((name, True))
                waiting.extend((c, False) for c in calls[name])


def _calls(function: tree.Function, declarations: Declarations) -> dict[str, tree.Call]:
    calls: dict[str, tree.Call] = {}
    for node in subtrees(function.body) if function.body is not None else ():
        if isinstance(node, tree.Call) and isinstance(node.func, tree.Name):
            name = node.func.id
            if name in declarations.functions:
                calls.setdefault(name, node)
    return calls


def _report_cycle(
    circle: list[str],
    calls: dict[str, dict[str, tree.Call]],
    declarations: Declarations,
    report: Reporter,
) -> None:
    shown = circle[:6]
    following = [*circle[1:], circle[0]]
    chain = " -> ".join([*circle, circle[0]] if len(circle) < 6 else [*shown, "...", circle[0]])
    report.error(
        "E0605",
        declarations.functions[circle[0]].name.span,
        f"function calls itself: {chain}",
        label="cannot be inlined",
        labels=[
            Label(calls[a][b].span, f"`{a}` calls `{b}` here")
            for a, b in zip(shown, following, strict=False)
        ],
        help=["recursion is not possible; write the function as a closed formula"],
    )
