"""arael: nonlinear least squares from readable model files.

    import arael

    Line = arael.load("linear")
    line = Line()
    line.data.extend(x=[0, 1, 2], y=[1, 3, 5])
    result = line.solve()

Names are imported on first use, so that ``import arael`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from arael.version import __version__

if TYPE_CHECKING:
    from arael import metrics as metrics
    from arael import sym as sym
    from arael.config import LmConfig as LmConfig
    from arael.diagnostics.model_warnings import ModelWarning as ModelWarning
    from arael.diagnostics.records import AraelError as AraelError
    from arael.diagnostics.records import Diagnostic as Diagnostic
    from arael.exporting import Export as Export
    from arael.exporting.exporter import export as export
    from arael.fitting.fit import fit as fit
    from arael.fitting.result import Fit as Fit
    from arael.functions import Function as Function
    from arael.io import read as read
    from arael.io import write as write
    from arael.loading import load as load
    from arael.loading import loads as loads
    from arael.log import log_to as log_to
    from arael.model import Model as Model
    from arael.model import Ref as Ref
    from arael.notes import Note as Note
    from arael.result import Result as Result
    from arael.runtime.failures import SolveError as SolveError
    from arael.runtime_residuals import (
        runtime_model as runtime_model,
    )
    from arael.runtime_residuals import (
        runtime_residual as runtime_residual,
    )
    from arael.schedule import Pass as Pass
    from arael.starts import Start as Start
    from arael.starts import initialise as initialise

_HOMES = {
    "AraelError": "arael.diagnostics.records",
    "Diagnostic": "arael.diagnostics.records",
    "Export": "arael.exporting",
    "Fit": "arael.fitting.result",
    "Function": "arael.functions",
    "LmConfig": "arael.config",
    "Model": "arael.model",
    "ModelWarning": "arael.diagnostics.model_warnings",
    "Note": "arael.notes",
    "Pass": "arael.schedule",
    "Ref": "arael.model",
    "Result": "arael.result",
    "SolveError": "arael.runtime.failures",
    "Start": "arael.starts",
    "export": "arael.exporting",
    "fit": "arael.fitting.fit",
    "initialise": "arael.starts",
    "load": "arael.loading",
    "loads": "arael.loading",
    "log_to": "arael.log",
    "read": "arael.io",
    "runtime_model": "arael.runtime_residuals",
    "runtime_residual": "arael.runtime_residuals",
    "write": "arael.io",
}

__all__ = ["__version__", "metrics", "sym", *sorted(_HOMES)]


def __getattr__(name: str) -> Any:
    if name in ("metrics", "plot", "sym"):
        return import_module(f"arael.{name}")
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'arael' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES, "metrics", "plot", "sym"})
