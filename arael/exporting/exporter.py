"""`export`: from a model to the files of a project."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO, Literal

from arael.compiler.compilation import compile_text
from arael.compiler.groups import Kernel
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.exporting.c_functions import Functions, functions_of
from arael.exporting.ceres import CeresProject, cmake_of
from arael.exporting.gtsam import gtsam_header
from arael.exporting.plan import plan_of
from arael.exporting.project import SHOWN, files_of
from arael.exporting.rows import Rows
from arael.exporting.sample import model_values, samples_of
from arael.exporting.solver import Solver
from arael.exporting.solver_project import checked_values, solver_files
from arael.exporting.wasm import wasm_files
from arael.io.files import shown, write_whole
from arael.loading import find_model
from arael.model import Model
from arael.runtime.layout import Layout
from arael.syntax.files import read_source


@dataclass(frozen=True)
class Export:
    """The files of an exported project.

    Attributes
    ----------
    target : what it was exported to
    files : text of each file by its name; of a module of WebAssembly its bytes
    functions : what the C functions are called and read
    left_out : constraints that read collections for which `size` has no rows
    """

    target: str
    files: Mapping[str, str | bytes]
    functions: Functions
    left_out: tuple[str, ...] = ()

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write all files into `folder`, which is made if it is not there; return their paths.

        Raises
        ------
        AraelError
            A file cannot be written; each is written whole or not at all.
        """
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
        except OSError as failure:
            reason = (failure.strerror or str(failure)).lower()
            raise AraelError(
                Diagnostic("E0715", f"the folder cannot be made: {reason}", origin=shown(folder))
            ) from None
        paths = [Path(folder, name) for name in self.files]
        for path, text in zip(paths, self.files.values(), strict=True):
            content = text if isinstance(text, bytes) else text.encode()
            write_whole(path, partial(_put, content))
        return paths

    def __repr__(self) -> str:
        return f"Export(to={self.target!r}, files={list(self.files)})"


def export(
    model: str | os.PathLike[str],
    to: Literal["c", "ceres", "gtsam", "wasm"] = "c",
    *,
    data: Model | None = None,
    constraint: str | Sequence[str] | None = None,
    precision: Literal["f64", "f32"] | None = None,
    root: str | None = None,
    size: Mapping[str, int] | Literal["data"] | None = None,
) -> Export:
    """Export a model to source code that runs without Python.

    Parameters
    ----------
    model : name of a standard model (``"slam"``) or path of a ``.arael`` file
    to : ``"c"``: for each constraint a C99 function of plain arrays for residuals and derivatives,
        for each entity its retraction and local coordinates; ``"ceres"``: on these functions cost
        functions and manifolds of Ceres, and a function that builds a problem; ``"gtsam"``: factors
        on GTSAM's types of poses and points; ``"wasm"``: a solver of fixed size as a WebAssembly
        module, with a loader, types and a page
    data : instance of the model; `main.c` evaluates the first rows of its data
    constraint : only these, as ``"Edge.between"``
    precision : instead of what the root declares
    root : which root, where the file has several
    size : also a whole solver, for at most so many rows of each collection (``{"poses": 10}``);
        one that is left out has those of `data`, and without data none; ``"data"``: for the rows
        and refs of `data`

    Raises
    ------
    AraelError
        The model is wrong; E1501: a constraint sums over a list of any length; E1502: there is no
        such constraint, or `data` is of another model or has residuals added from Python; E1503: a
        solver of that size cannot be made; E1504: what the target does not have; E1505: no compiler
        of WebAssembly.

    Examples
    --------
    >>> import arael
    >>> project = arael.export("pose_graph_2d")
    >>> list(project.files)
    ['pose_graph_2d.h', 'pose_graph_2d.c', 'main.c', 'CMakeLists.txt']
    """
    if to not in TARGETS:
        raise wrong_argument("export", "to", " or ".join(map(repr, TARGETS)), to)
    if data is not None and not isinstance(data, Model):
        raise wrong_argument("export", "data", "an instance of the model", data)
    if size not in (None, "data") and not _is_sizes(size):
        raise wrong_argument("export", "size", 'numbers of rows by collection, or "data"', size)
    if not (constraint is None or _is_names(constraint)):
        raise wrong_argument("export", "constraint", "a name, or several", constraint)
    path = find_model(model)
    source = read_source(path)
    program = compile_text(source, root=root, precision=precision).program
    kernels, left_out = _chosen(program.kernels, constraint, size if data is None else None)
    functions = functions_of(program.layout, kernels)
    if data is not None:
        _check_data(data, program.layout)
    files = _FILES[to](_Request(functions, source.text, data, size))
    return Export(to, files, functions, left_out)


@dataclass(frozen=True)
class _Request:
    """What is exported: functions of a model, its text, and data and size where given."""

    functions: Functions
    text: str
    data: Model | None
    size: Mapping[str, int] | Literal["data"] | None

    @property
    def stem(self) -> str:
        """Name of the files."""
        return self.functions.prefix.removesuffix("_")

    def functions_files(self) -> dict[str, str]:
        """The functions in C, and a program that calls them."""
        samples = None if self.data is None else samples_of(self.functions, self.data, SHOWN)
        return files_of(self.functions, self.text, samples)

    def solver(self, size: Mapping[str, int] | Literal["data"]) -> Solver:
        """A solver of that size."""
        if size == "data" and self.data is None:
            raise AraelError(
                Diagnostic("E1503", "the size is that of the data, and there is no data")
            )
        sizes = size if isinstance(size, Mapping) else {}
        return Solver(self.functions, plan_of(self.functions, sizes, self.data))


def _c_files(request: _Request) -> dict[str, str]:
    files = request.functions_files()
    if request.size is not None:
        solver = request.solver(request.size)
        files.update(solver_files(solver, request.text, request.data))
    return files


def _wasm_files(request: _Request) -> dict[str, str | bytes]:
    data, size = request.data, request.size
    if data is None and size is None:
        raise AraelError(
            Diagnostic(
                "E1503",
                "a WebAssembly module is a solver of fixed size, and there is none",
                help=("write --size NAME=N,... for its collections, or give a data file",),
            )
        )
    solver = request.solver(size or "data")
    files = {**request.functions_files(), **solver_files(solver, request.text, data)}
    values = {} if data is None else checked_values(solver, data)
    return wasm_files(solver, files, values)


def _ceres_files(request: _Request) -> dict[str, str]:
    """Files for Ceres; `main.cpp` solves the problem of the data, if there is some."""
    files = _library_files(request, "ceres")
    functions, data = request.functions, request.data
    read = {slot.table for one in functions.constraints for slot in one.group.slots}
    project = CeresProject(functions, Rows(functions, read | {""}))
    head = f"// Ceres problem of the model in {request.stem}.h."
    files[f"{request.stem}_ceres.h"] = project.header(head)
    if data is not None:
        files["main.cpp"] = project.main(model_values(functions, project.rows, data))
    files["CMakeLists.txt"] = cmake_of(request.stem, data is not None)
    return files


def _gtsam_files(request: _Request) -> dict[str, str]:
    files = _library_files(request, "gtsam")
    return {**files, f"{request.stem}_gtsam.h": gtsam_header(request.functions)}


def _library_files(request: _Request, to: str) -> dict[str, str]:
    """The functions in C, for a library that solves in double precision."""
    if request.size is not None:
        raise AraelError(
            Diagnostic("E1503", f"a size is of the solver in C, and {to} has its own solver")
        )
    if request.functions.real == "float":
        raise AraelError(
            Diagnostic(
                "E1504",
                f"the model is in f32, and {to} solves in double precision",
                help=("write --precision f64",),
            )
        )
    files = request.functions_files()
    return {name: files[name] for name in (f"{request.stem}.h", f"{request.stem}.c")}


_FILES: dict[str, Callable[[_Request], Mapping[str, str | bytes]]] = {
    "c": _c_files,
    "ceres": _ceres_files,
    "gtsam": _gtsam_files,
    "wasm": _wasm_files,
}

TARGETS = tuple(_FILES)


def _chosen(
    kernels: tuple[Kernel, ...], constraint: str | Sequence[str] | None, size: object
) -> tuple[tuple[Kernel, ...], tuple[str, ...]]:
    """Constraints to export, and the labels of those that read collections without a size."""
    if constraint is not None:
        labels = list(dict.fromkeys(kernel.group.label for kernel in kernels))
        wanted = [constraint] if isinstance(constraint, str) else list(constraint)
        for name in wanted:
            if name not in labels:
                raise _no_constraint(name, labels)
        kernels = tuple(kernel for kernel in kernels if kernel.group.label in wanted)
    if not isinstance(size, Mapping):
        return kernels, ()
    rows = {*size, ""}
    kept = tuple(k for k in kernels if {slot.table for slot in k.group.slots} <= rows)
    if not kept:  # the plan says which size is missing
        return kernels, ()
    return kept, tuple(k.group.label for k in kernels if k not in kept)


def _check_data(data: Model, layout: Layout) -> None:
    """Refuse data of another model, and residuals that are not in the model's file."""
    name = data._compiled.layout.name
    if name != layout.name:
        raise AraelError(
            Diagnostic("E1502", f"the data is of the model `{name}`, expected `{layout.name}`")
        )
    residuals = data._residuals
    added = [] if residuals is None else [*residuals, *residuals.code]
    if added:
        raise AraelError(
            Diagnostic(
                "E1502",
                f"the model has residuals that were added from Python: {', '.join(added)}",
                help=("write them as constraints of the model file",),
            )
        )


def _is_sizes(size: object) -> bool:
    return isinstance(size, Mapping) and all(
        isinstance(name, str) and type(count) is int for name, count in size.items()
    )


def _is_names(names: object) -> bool:
    return isinstance(names, str) or (
        isinstance(names, Sequence) and all(isinstance(name, str) for name in names)
    )


def _put(content: bytes, file: BinaryIO) -> None:
    file.write(content)


def _no_constraint(name: str, labels: Sequence[str]) -> AraelError:
    near = closest(name, labels)
    hint = f"did you mean `{near[0]}`?" if near else f"there are {', '.join(labels)}"
    return AraelError(Diagnostic("E1502", f"there is no constraint `{name}`", help=(hint,)))
