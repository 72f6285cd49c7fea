"""Models in text and data in text, and what reading the one into the other finds."""

from __future__ import annotations

import contextlib
from functools import cache
from pathlib import Path

from arael import io
from arael.compiler import compiler
from arael.diagnostics.records import AraelError, Diagnostic, Findings, Source
from arael.runtime.layout import LAYOUT_VERSION, Layout
from arael.runtime.store import Store
from tests.hand_layouts import pose_graph


@cache
def layout_of(model: str) -> Layout:
    """The layout of a model's text, without kernels; of pose_graph_2d if there is none."""
    if not model:
        return pose_graph(2)
    typed = compiler.types(compiler.syntax(Source("model.arael", model)), Findings())
    return Layout(
        LAYOUT_VERSION, typed.name, typed.root, typed.precision, "model.arael",
        typed.tables, (), (), typed.passes,
    )  # fmt: skip


def found(model: str, text: str, kind: str, folder: Path) -> list[Diagnostic]:
    """What is wrong with a data file of this text."""
    (folder / f"data.{kind}").write_text(text)
    try:
        with contextlib.chdir(folder):
            io.read(Store(layout_of(model)), f"data.{kind}")
    except AraelError as failure:
        return list(failure.diagnostics)
    return []
