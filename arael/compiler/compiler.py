"""The compiler, stage by stage. Each stage is a pure function whose result can be printed.

text -> tree -> typed model -> IR with Jacobians -> Cython source -> extension module
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from arael.check.check import check
from arael.check.typed import TypedModel
from arael.compiler.emit.module import emit_module
from arael.compiler.entities import StateModel, model_state
from arael.compiler.groups import Kernel, compile_constraint
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic, Findings, Source
from arael.runtime.layout import LAYOUT_VERSION, Constant, Layout
from arael.syntax.parser import parse
from arael.syntax.tree import File, Import

# More operations than this in one model would keep a C compiler busy for minutes; a real model has
# a few thousand.
MAX_OPERATIONS = 60_000

# Generated source of a SLAM model has 0.12 MB.
MAX_SOURCE = 3 << 20

# The smallest constraint makes 4 kB of source, so more than these would be too much source. That is
# said before they are derived.
MAX_CONSTRAINTS = 1000


@dataclass(frozen=True)
class Program:
    """The IR of a model: what the runtime needs and what the printer of kernels needs."""

    layout: Layout
    kernels: tuple[Kernel, ...]


def syntax(source: Source) -> File:
    """Text to tree."""
    return parse(source)


def types(
    tree: File,
    findings: Findings,
    root: str | None = None,
    load: Callable[[Import], File] | None = None,
) -> TypedModel:
    """Tree to typed model: names, shapes, refs, guards."""
    return check(tree, load=load, root=root, findings=findings)


def derive(
    model: TypedModel, source: str, precision: str | None = None, warnings: tuple[str, ...] = ()
) -> Program:
    """Typed model to IR: residuals and their derivatives as straight-line programs."""
    if len(model.constraints) > MAX_CONSTRAINTS:
        raise _too_much_source(
            f"the model has {len(model.constraints)} constraints, more than {MAX_CONSTRAINTS}",
            source,
        )
    functions = Functions(model.functions)
    states: list[StateModel] = [model_state(site, functions) for site in model.entities]
    single = (precision or model.precision) == "f32"
    kernels = tuple(
        compile_constraint(site, states, single, functions) for site in model.constraints
    )
    operations = sum(k.group.operations_after for k in kernels)
    if operations > MAX_OPERATIONS:
        largest = max(kernels, key=lambda k: k.group.operations_after).group
        raise AraelError(
            Diagnostic(
                "E0620",
                f"the model takes {operations} operations an evaluation, "
                f"more than {MAX_OPERATIONS}",
                origin=largest.where,
                notes=(
                    f"the largest constraint is {largest.label} with "
                    f"{largest.operations_after} operations",
                ),
                help=("split the residual, or move what depends on data alone into the data",),
            )
        )
    layout = Layout(
        version=LAYOUT_VERSION,
        name=model.name,
        root=model.root,
        precision=precision or model.precision,  # type: ignore[arg-type]
        source=source,
        tables=model.tables,
        entities=tuple(s.entity for s in states),
        groups=tuple(k.group for k in kernels),
        passes=model.passes,
        blocks=model.blocks,
        warnings=warnings,
        functions=functions.layouts(),
        constants=tuple(Constant(name, text) for name, text in model.constants),
        marginalize=model.marginalize,
        doc=model.doc,
    )
    return Program(layout, kernels)


def emit(program: Program, source_hash: str, refreshed: bool = True) -> str:
    """IR to Cython source; see `emit_module` for `refreshed`."""
    layout = program.layout
    text = emit_module(
        layout.name,
        Path(layout.source).name,
        source_hash,
        layout.precision,
        layout.entities,
        program.kernels,
        layout.natives,
        refreshed=refreshed,
    )
    if len(text) > MAX_SOURCE:
        raise _too_much_source(
            f"{len(program.kernels)} constraints make {len(text) / (1 << 20):.1f} MB of source, "
            f"more than {MAX_SOURCE >> 20}",
            layout.source,
        )
    return text


def _too_much_source(said: str, source: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0620",
            said,
            origin=source,
            help=("put what many constraints have in common into one, with data that differs",),
        )
    )
