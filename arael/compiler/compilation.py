"""The stages up to the IR for one text, and their results."""

from __future__ import annotations

import time
from dataclasses import dataclass

from arael.compiler import compiler
from arael.compiler.cache.keys import FORMAT, digest
from arael.compiler.cache.models import Known, relative_names
from arael.compiler.cache.warnings import stored
from arael.compiler.compiler import Program
from arael.compiler.garbage import rare_collections
from arael.compiler.imports import Imports
from arael.diagnostics.records import Diagnostic, Findings, Source
from arael.diagnostics.render import render
from arael.runtime.layout import Layout
from arael.runtime.relocation import detached


@dataclass(frozen=True)
class Compilation:
    """A model from its text to the IR.

    Attributes
    ----------
    program : the IR
    warnings : what was found worth a warning
    sources : the model's text and those of the files it imports, as they were read; a file that is
        imported under two names comes twice
    seconds : what each stage took
    """

    program: Program
    warnings: tuple[Diagnostic, ...]
    sources: tuple[Source, ...]
    seconds: dict[str, float]

    @property
    def layout(self) -> Layout:
        """The model as the runtime reads it."""
        return self.program.layout

    def emit(self) -> str:
        """Cython source of the model's kernels."""
        return compiler.emit(self.program, digest(self.sources[0].text.encode())[:16])

    def known(self, code: str) -> Known:
        """What the cache stores of the model.

        Parameters
        ----------
        code : digest of its generated code; "" where there is none
        """
        names = relative_names(self.sources)
        texts = [source.text for source in self.sources]
        return Known(
            FORMAT,
            code,
            {n: digest(t.encode()) for n, t in zip(names[1:], texts[1:], strict=True)},
            stored(self.warnings, self.sources),
            detached(self.layout, [source.name for source in self.sources]),
        )


@rare_collections()
def compile_text(
    source: Source, root: str | None = None, precision: str | None = None
) -> Compilation:
    """Parse, check and derive a model.

    Parameters
    ----------
    source : its text, and the name of its file, by which imports are found
    root : which root, where the file has several
    precision : instead of what the root declares

    Raises
    ------
    AraelError
        Everything that is wrong with the model.
    """
    seconds: dict[str, float] = {}
    imports = Imports()
    findings = Findings()
    started = time.perf_counter()
    tree = compiler.syntax(source)
    seconds["syntax"] = time.perf_counter() - started
    started = time.perf_counter()
    model = compiler.types(tree, findings, root, imports)
    seconds["check"] = time.perf_counter() - started
    started = time.perf_counter()
    warnings = findings.warnings
    said = tuple(render([d], color=False, width=100) for d in warnings)
    program = compiler.derive(model, source.name, precision, said)
    seconds["derive"] = time.perf_counter() - started
    sources = (source, *(Source(name, s.text) for name, s in imports.read.items()))
    return Compilation(program, warnings, sources, seconds)
