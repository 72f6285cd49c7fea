"""The typed model of a compiled one, from the text that was loaded."""

from __future__ import annotations

from typing import Any

from arael.check.typed import TypedModel
from arael.compiler import compiler
from arael.compiler.imports import Imports
from arael.diagnostics.records import Findings, Source
from arael.syntax.files import read_source


def typed_model(compiled: Any) -> TypedModel:
    """The typed model, which is kept with the compiled one; imported files are read once more.

    Raises
    ------
    AraelError
        What is wrong with a text that has changed since.
    """
    found: TypedModel | None = compiled.plain.get("typed")
    if found is None:
        recipe, layout = compiled.recipe, compiled.layout
        source = Source(recipe.name, recipe.text) if recipe else read_source(layout.source)
        tree = compiler.syntax(source)
        found = compiled.plain["typed"] = compiler.types(tree, Findings(), layout.root, Imports())
    return found
