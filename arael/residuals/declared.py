"""Functions and constants that runtime residuals may use: the model's, and further ones."""

from __future__ import annotations

from dataclasses import dataclass

from arael.check.constants import Constants
from arael.check.declared import Declarations
from arael.check.inlining import check_functions
from arael.check.items import gather
from arael.check.report import Reporter
from arael.check.scalar_functions import type_functions
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import Findings, Label, Source
from arael.runtime.layout import Layout
from arael.syntax import tree
from arael.syntax.parser import parse


@dataclass(frozen=True)
class Declared:
    """Functions and constants, checked.

    Attributes
    ----------
    functions : those with `derivs` in the form of graphs, and all of them typed
    """

    declarations: Declarations
    constants: Constants
    functions: Functions


def of_model(layout: Layout) -> Declared:
    """The declarations of a compiled model."""
    if not layout.items:
        nothing = Declarations()
        return Declared(nothing, Constants(nothing, Reporter(Findings())), Functions())
    return declared(Source(f"functions of {layout.source}", layout.items), Declarations())


def declared(source: Source, before: Declarations, fixed: frozenset[str] = frozenset()) -> Declared:
    """Functions and constants of a text together with those `before`, which may be replaced.

    Parameters
    ----------
    fixed : names of those that may not be replaced

    Raises
    ------
    AraelError
        With every mistake of the text; E0206 for a name of `fixed`, E0608 for other items than
        functions and constants.
    """
    report = Reporter(Findings())
    declarations = gather(parse(source), None, report)
    for struct in declarations.structs.values():
        report.error(
            "E0608", struct.node.span, "expected functions and constants", label="a struct"
        )
    items: list[tree.Function | tree.Const] = [
        *declarations.functions.values(),
        *declarations.consts.values(),
    ]
    for item in items:
        name = item.name.id
        if name in fixed:
            older = before.functions.get(name) or before.consts.get(name)
            report.error(
                "E0206",
                item.name.span,
                f"`{name}` is declared twice",
                label="declared again here",
                labels=[] if older is None else [Label(older.name.span, "the model declares it")],
                help=["choose another name"],
            )
    declarations.functions = {**before.functions, **declarations.functions}
    declarations.consts = {**before.consts, **declarations.consts}
    check_functions(declarations, report)
    constants = Constants(declarations, report)
    constants.check_all()
    typed = type_functions(constants, report)
    report.stop()
    return Declared(declarations, constants, Functions(typed))
