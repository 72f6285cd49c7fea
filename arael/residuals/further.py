"""Functions and constants that a caller declares for runtime residuals, beside the model's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec

from arael.diagnostics.records import AraelError, Source
from arael.face.native import bind_all
from arael.residuals.declared import Declared, declared
from arael.residuals.schema import Schema
from arael.runtime.evaluation.unbound import unbound
from arael.runtime.layout import Layout
from arael.runtime.machine.native_binding import Binding


@dataclass(frozen=True)
class Further:
    """Declarations of the model and of the caller.

    Attributes
    ----------
    schema : the model
    declared : all functions and constants
    layout : of the model, with the native functions of the caller
    bindings : of these functions, by name
    calls : arguments of each call that declared some
    """

    schema: Schema
    declared: Declared
    layout: Layout
    bindings: dict[str, Binding] = field(default_factory=dict)
    calls: tuple[tuple[str, dict[str, Any]], ...] = ()

    @classmethod
    def of(cls, schema: Schema) -> Further:
        """The model's own."""
        return cls(schema, schema.declared, schema.layout)

    def extended(self, text: str, bind: Mapping[str, Any]) -> Further:
        """With the items of `text`, which may replace earlier ones of the caller.

        Raises
        ------
        AraelError
            As `Residuals.functions`.
        """
        model = self.schema.declared.declarations
        extended_declarations = declared(
            Source("functions", text),
            self.declared.declarations,
            fixed=frozenset({*model.functions, *model.consts}),
        )
        added = [
            f for f in extended_declarations.functions.layouts() if f.name not in model.functions
        ]
        natives = {f.name: f for f in added if f.native}
        layout = msgspec.structs.replace(self.schema.layout, functions=tuple(natives.values()))
        bindings = {**self.bindings, **bind_all(layout, bind, stacklevel=4)}
        for name, function in natives.items():
            if name not in bindings:
                raise AraelError(
                    unbound(function, layout, way=f'functions(..., bind={{"{name}": ...}})')
                )
        before = {f.name: f for f in self.layout.functions}
        # Existing functions keep their numbers, which programs refer to.
        functions = tuple({**before, **natives}.values())
        layout = msgspec.structs.replace(self.schema.layout, functions=functions)
        calls = (*self.calls, (text, dict(bind)))
        return Further(self.schema, extended_declarations, layout, bindings, calls)
