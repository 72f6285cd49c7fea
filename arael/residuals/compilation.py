"""Runtime residuals compiled to kernels, through the compiler and the cache of models."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import msgspec

from arael.compiler.compiler import Program, emit
from arael.compiler.groups import Kernel
from arael.compiler.kernels import kernels_of
from arael.residuals.derivation import Derived
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.layout import Entity, Layout


def compile_all(derived: Sequence[Derived], layout: Layout) -> None:
    """Compile residuals into one module, or load it from the cache, and use its kernels.

    Residuals that differ in their rows and data only, like the dimensions of a sketch, share a
    kernel.

    Parameters
    ----------
    derived : the residuals
    layout : of the model, with the native functions that the residuals may call

    Raises
    ------
    AraelError
        E0801-E0803 there is no working C compiler, E0620 the kernels would be too large. Nothing is
        changed then.
    """
    if not derived:
        return
    entities: list[Entity] = []
    shared: dict[Hashable, int] = {}
    kernels: list[Kernel] = []
    numbers = []
    for residual in derived:
        kernel = _numbered(residual, entities)
        number = shared.setdefault(_code_of(kernel, entities), len(kernels))
        if number == len(kernels):
            kernels.append(kernel)
        numbers.append(number)
    whole = msgspec.structs.replace(
        layout,
        name=f"{layout.name}_residuals",
        source=f"residuals of {layout.name}",
        tables=(),
        entities=tuple(entities),
        groups=tuple(kernel.group for kernel in kernels),
        passes=(),
        blocks=(),
    )
    source = emit(Program(whole, tuple(kernels)), "of formulas given at run time", refreshed=False)
    capsule = kernels_of(source, whole.name, whole.source).table
    for number, residual in zip(numbers, derived, strict=True):
        residual.compiled = GroupKernel(capsule, number)


def _code_of(kernel: Kernel, entities: Sequence[Entity]) -> Hashable:
    """Key of a kernel: residuals with equal keys share one kernel."""
    group = kernel.group
    used = [use.entity for use in group.uses]
    return (
        group.residuals,
        group.states,
        group.data_count,
        group.uniform_count,
        group.jacobian,
        group.lead,
        tuple((entities[e].state, entities[e].tangent, used.index(e)) for e in used),
        kernel.gradient,
        kernel.products,
        group.workspace,
        *((t.ops, t.args, t.constants, t.outputs) for t in (kernel.cost, kernel.linearise)),
    )


def _numbered(derived: Derived, entities: list[Entity]) -> Kernel:
    """The kernel of a residual with entities numbered as in `entities`, which may grow."""
    numbers = []
    for entity in derived.states:
        if entity not in entities:
            entities.append(entity)
        numbers.append(entities.index(entity))
    group = derived.kernel.group
    uses = tuple(msgspec.structs.replace(u, entity=numbers[u.entity]) for u in group.uses)
    return replace(derived.kernel, group=msgspec.structs.replace(group, uses=uses))
