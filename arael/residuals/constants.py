"""Constraints with a named constant as an input of their programs, for derivatives by it.

The compiler folds the value of a constant into programs. Here a constraint is derived once more
from its typed formula, in which the constant is data.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.check.arithmetic import Values, evaluate
from arael.check.typed import (
    Apply,
    Component,
    ConstraintSite,
    Invoke,
    Literal_,
    Read,
    ScalarType,
    Total,
    Typed,
    TypedModel,
)
from arael.check.types import shape_of
from arael.check.walk import operands, postorder, with_operands
from arael.compiler.entities import StateModel, model_state
from arael.compiler.groups import compile_constraint
from arael.compiler.reread import typed_model
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic
from arael.residuals.declared import Declared
from arael.runtime.layout import CONSTANT, Group, Layout
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class VariedGroups:
    """Groups that read a constant, with it as an input.

    Attributes
    ----------
    groups : by their numbers, with the raw inputs `CONSTANT` of slot 0
    values : (scalars,) of the constant
    shape : of the constant
    """

    groups: dict[int, Group]
    values: Floats
    shape: tuple[int, ...]


def varied_groups(
    compiled: Any, declared: Declared, problem: Problem, name: str
) -> VariedGroups | None:
    """The groups of a problem that read a constant; None if none does.

    Parameters
    ----------
    compiled : the model
    declared : functions and constants of runtime residuals

    Raises
    ------
    AraelError
        E1060: it is read where no derivative by it is taken; the text has changed since.
    """
    typed = typed_model(compiled)
    varying = Varying(name)
    _refuse_components(typed, varying)
    found: dict[int, Group] = {}
    for number, site, states, functions in _sites(typed, declared, problem):
        residual, loss = varying.of(site.residual), site.loss
        if loss is not None:
            loss = replace(loss, value=varying.of([loss.value])[0])
        changed = replace(site, residual=tuple(residual), loss=loss)
        if changed.residual == site.residual and (
            loss is None or site.loss is None or loss.value is site.loss.value
        ):
            continue
        _refuse_functions(site, functions, varying)
        single = problem.layout.precision == "f32"
        varied = compile_constraint(changed, states, single, functions).group
        found[number] = _aligned(varied, problem.layout.groups[number], states, problem.layout)
    if varying.read is None or not found:
        return None
    type_ = varying.read.type
    return VariedGroups(found, np.array(varying.values), shape_of(type_))


def _sites(
    typed: TypedModel, declared: Declared, problem: Problem
) -> Iterator[tuple[int, ConstraintSite, Sequence[StateModel], Functions]]:
    """Number, formula, entities and functions of each group but those of own code."""
    functions = Functions(typed.functions)
    states = [model_state(site, functions) for site in typed.entities]
    groups = problem.layout.groups
    for number, site in enumerate(typed.constraints):
        if number >= len(groups) or site.label != groups[number].label:
            raise _refused("the text of the model is not what was compiled", "load it again")
        yield number, site, states, functions
    derived = getattr(problem.store, "derived", ())
    for number, one in enumerate(derived, len(typed.constraints)):
        yield number, one.site, one.models, declared.functions


def _aligned(varied: Group, group: Group, states: Sequence[StateModel], layout: Layout) -> Group:
    """A derived group with the slots and uses of the one that the problem has."""
    known = [
        (use.slot, layout.entities[use.entity].table, layout.entities[use.entity].prefix)
        for use in group.uses
    ]
    at = []
    for use in varied.uses:
        entity = states[use.entity].entity
        at.append(known.index((use.slot, entity.table, entity.prefix)))
    return msgspec.structs.replace(
        varied,
        slots=group.slots,
        uses=group.uses,
        states=tuple((at[use], offset) for use, offset in varied.states),
        jacobian=tuple((k, at[use], tangent) for k, use, tangent in varied.jacobian),
    )


# --- what no derivative is taken of -----------------------------------------------------------


def _refuse_components(typed: TypedModel, varying: Varying) -> None:
    """Refuse a constant in a formula of a component, whose state holds values of it."""
    for entity in typed.entities:
        for one in entity.components:
            parts = [part.value for part in one.updates]
            parts += [part.value for part in (*one.symbolic, *one.computed)]
            if any(map(varying.varies, parts)):
                raise _refused(
                    f"`{varying.name}` is read by the component `{one.struct}`, of which no "
                    "derivative by a constant is taken",
                    "make it a data field of the component",
                )


def _refuse_functions(site: ConstraintSite, functions: Functions, varying: Varying) -> None:
    """Refuse a constant in a function whose derivatives the model states: by arguments alone."""
    values = [*site.residual, *([] if site.loss is None else [site.loss.value])]
    stated = {one.name: one.derivs or () for one in functions.typed}
    for node in postorder(values):
        if not isinstance(node, Invoke):
            continue
        own = [*stated.get(node.function, ()), *([] if node.value is None else [node.value])]
        if any(varying.varies(one) for one in own):
            raise _refused(
                f"`{varying.name}` is read by `{node.function}`, whose `derivs` are by its "
                "arguments alone",
                "pass it as an argument",
            )


def _refused(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E1060", message, origin="sensitivity", help=(advice,)))


# --- formulas ---------------------------------------------------------------------------------


class Varying:
    """Replaces a constant by data.

    Attributes
    ----------
    read : the data, once the constant was met
    values : its numbers
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.read: Read | None = None
        self.values: Values = ()
        self._new: dict[Typed, Typed] = {}

    def of(self, formulas: Iterable[Typed]) -> list[Typed]:
        """Formulas with the constant as data, also where other constants are computed from it."""
        formulas = list(formulas)
        for node in postorder(formulas):
            if node in self._new:
                continue
            if isinstance(node, Literal_):
                self._new[node] = self._number(node)
                continue
            new = with_operands(node, [self._new[one] for one in operands(node)])
            if new is not node and isinstance(node, Total):
                raise _refused(
                    f"`{self.name}` is read in a sum over rows, of which no derivative by a "
                    "constant is taken",
                    "make it a data field of the root",
                )
            self._new[node] = new
        return [self._new[one] for one in formulas]

    def varies(self, formula: Typed) -> bool:
        """Whether a formula reads the constant."""
        return self.of([formula])[0] is not formula

    def _number(self, node: Literal_) -> Typed:
        constant = node.constant
        if constant is None:
            return node
        formula = constant.formula
        if constant.name == self.name:
            whole: Typed = self._data(formula)
        else:
            (whole,) = self.of([formula])
            if whole is formula:
                return node
        part = whole
        if not isinstance(formula.type, ScalarType):
            part = Component(type=node.type, span=node.span, of=whole, index=constant.component)
        if not constant.negative:
            return part
        return Apply(type=node.type, span=node.span, name="neg", args=(part,))

    def _data(self, formula: Typed) -> Read:
        if self.read is None:
            self.values = evaluate(formula)
            self.read = Read(
                type=formula.type, span=formula.span, slot=0, column=CONSTANT, version="data"
            )
        return self.read
