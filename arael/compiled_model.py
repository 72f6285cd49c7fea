"""A compiled model: its layout, its kernels and where they came from."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from arael.diagnostics.model_warnings import InterpretedWarning
from arael.runtime.layout import Layout
from arael.runtime.machine.native_binding import Binding

if TYPE_CHECKING:
    from arael.compiler.meanwhile import Meanwhile


Precision = Literal["f32", "f64"]
Interpret = bool | Literal["meanwhile"] | None


@dataclass(frozen=True)
class Recipe:
    """What a model was loaded from: enough to load it again, in another process too.

    Attributes
    ----------
    text, name : text of the model, and its name in messages: the path of its file, if it has one
    precision, root, interpret : as given to `arael.load`
    """

    text: str
    name: str
    precision: Precision | None = None
    root: str | None = None
    interpret: Interpret = None


@dataclass(frozen=True, eq=False)
class CompiledModel:
    """A compiled model.

    Attributes
    ----------
    layout : the model as the runtime reads it
    kernels : capsule with the table of kernels, or None where the model is interpreted
    folder : cache entry or shipped folder it came from, or None
    origin : ``cache``, ``compiled``, ``shipped`` or ``interpreted``
    seconds : duration of each stage; empty on a warm start, without Cython and the C compiler where
        the kernels of a changed text were found
    bindings : implementations of native functions that the caller bound, by name
    meanwhile : the compilation that runs in the background, if there is one
    recipe : what it was loaded from; None if that was no text
    functions : what was given to `load` for native functions, by name
    plain : constraints without loss, by the number of their group, and the typed model: derived
        when first asked for
    """

    layout: Layout
    kernels: Any
    folder: Path | None
    origin: str
    seconds: dict[str, float]
    bindings: dict[str, Binding] = field(default_factory=dict)
    meanwhile: Meanwhile | None = None
    recipe: Recipe | None = None
    functions: Mapping[str, Any] = field(default_factory=dict)
    plain: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def current(self, level: int) -> CompiledModel:
        """Return the model with the kernels that were compiled meanwhile, if they are there.

        Parameters
        ----------
        level : how many calls up a warning is placed

        Warns
        -----
        InterpretedWarning
            The compilation has failed. What is returned does not warn again.
        """
        task = self.meanwhile
        if task is None:
            return self
        if task.kernels is not None:
            return replace(self, kernels=task.kernels, origin="compiled", meanwhile=None)
        if not task.failure:
            return self
        warn_of_machine(task.failure, level + 1)
        return replace(self, meanwhile=None)


def warn_of_machine(why: str, level: int) -> None:
    """Warn that a model runs on the expression machine, at the place `level` calls up."""
    warnings.warn(
        f"running on the expression machine, slower than compiled kernels: {why}; "
        "`arael doctor` reports details",
        InterpretedWarning,
        stacklevel=level,
    )
