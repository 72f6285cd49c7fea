"""`load`: from a model's name or file to a class, compiled once and found again afterwards.

A warm start reads the cache entry and imports one extension module; the language rooms, lark,
SymPy, Cython and setuptools stay unimported.
"""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import os
import sys
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from arael.compiler import cache, processor
from arael.diagnostics.model_warnings import warn_of_model
from arael.diagnostics.records import AraelError, Diagnostic
from arael.log import log
from arael.runtime.layout import Layout, from_json, to_json
from arael.runtime.native_binding import Binding

if TYPE_CHECKING:
    from arael.model import Model

Precision = Literal["f32", "f64"]


class InterpretedWarning(UserWarning):
    """A model runs on the NumPy interpreter, which is correct and slow."""


@dataclass(frozen=True)
class Compiled:
    """A compiled model.

    Attributes
    ----------
    layout : what the runtime knows of it
    kernels : capsule with the table of kernels, or None where the model is interpreted
    folder : cache entry or shipped folder it came from, or None
    origin : ``cache``, ``compiled``, ``shipped`` or ``interpreted``
    seconds : what each stage of a compilation took; empty on a warm start
    bindings : what the caller bound to native functions, by name
    """

    layout: Layout
    kernels: Any
    folder: Path | None
    origin: str
    seconds: dict[str, float]
    bindings: dict[str, Binding] = field(default_factory=dict)


def load(
    model: str | os.PathLike[str],
    *,
    precision: Precision | None = None,
    root: str | None = None,
    interpret: bool | None = None,
    functions: Mapping[str, Any] | None = None,
) -> type[Model]:
    """Load a model as a class whose instances hold its data.

    Parameters
    ----------
    model : name of a standard model (``"slam"``) or path of a ``.arael`` file
    precision : ``"f64"`` or ``"f32"`` instead of what the root declares
    root : which root, where the file has several
    interpret : run on the NumPy interpreter (True), on compiled kernels or not at all (False), or
        on the interpreter only where there is no C compiler (None)
    functions : what to call for each ``extern fn`` of the model, by name: a function pointer of
        ctypes or cffi, a numba ``cfunc``, a capsule of Cython's, a `scipy.LowLevelCallable`, or a
        Python function of floats

    Returns
    -------
    A subclass of `arael.model.Model`.

    Raises
    ------
    AraelError
        The file cannot be read, the model is wrong (with every mistake found), or the environment
        lacks something; each diagnostic names the place and a way out.

    Warns
    -----
    ModelWarning
        Something in the model is probably not meant (``W....``), with the text of `arael check`.
    InterpretedWarning
        No C compiler was found, so the NumPy interpreter stands in.
    SlowFunctionWarning
        A Python function is bound to an ``extern fn``.
    """
    from arael.functions import Functions
    from arael.model import Model

    compiled = load_compiled(model, precision=precision, root=root, interpret=interpret)
    layout = compiled.layout
    warn_of_model(layout.warnings)
    if functions:
        from arael.face.native import bind_all

        compiled = replace(compiled, bindings=bind_all(layout, functions))

    def construct(self: Model, /, **values: Any) -> None:
        Model.__init__(self, compiled, **values)

    members = {
        "__init__": construct,
        "__doc__": layout.doc or f"The model {layout.name}.",
        "__module__": f"arael.models.{layout.name}",
        "compiled": compiled,
        "layout": layout,
        "functions": Functions(layout, compiled.bindings),
    }
    return type(layout.root, (Model,), members)


def load_compiled(
    model: str | os.PathLike[str],
    *,
    precision: Precision | None = None,
    root: str | None = None,
    interpret: bool | None = None,
) -> Compiled:
    """`load`, without the class."""
    if precision not in (None, "f32", "f64"):
        raise AraelError(
            Diagnostic(
                "E0811",
                f"unknown precision {precision!r}",
                origin="precision",
                help=("write `f32` or `f64`",),
            )
        )
    path = find_model(model)
    text = _read(path)
    if not interpret and root is None:
        shipped = _shipped(path, text, precision)
        if shipped is not None:
            return shipped
    # The same text beside other files to import is another model.
    beside = str(path.resolve().parent) if "import" in text else ""
    key = cache.key(text, root, precision, "interpreter" if interpret else "native", beside)
    entry = _usable(cache.find(key), interpret)
    if entry is not None:
        return _from_entry(entry, "cache", path=path)
    return _compile(path, key, root, precision, interpret)


def _usable(entry: cache.Entry | None, interpret: bool | None) -> cache.Entry | None:
    """The entry, unless it lacks kernels that could be had or have to be."""
    if entry is None or interpret or entry.module is not None:
        return entry
    from arael.compiler import build

    changed = entry.manifest.without != build.compiler_identity()
    return None if changed or interpret is False else entry


def find_model(model: str | os.PathLike[str]) -> Path:
    """Path of a model given by file or by the name of a standard model.

    Raises
    ------
    AraelError
        E0812 if there is neither.
    """
    name = os.fspath(model)
    path = Path(name)
    if path.suffix == ".arael" or path.is_file() or os.sep in name:
        return path
    known = standard_models()
    if name in known:
        return known[name]
    from arael.diagnostics.suggest import closest

    near = closest(name, [*known, *(p.name for p in Path().glob("*.arael"))])
    raise AraelError(
        Diagnostic(
            "E0812",
            f"no model `{name}`: neither a file nor a standard model",
            origin=name,
            notes=("standard models: " + ", ".join(sorted(known)),),
            help=tuple(f"did you mean `{n}`?" for n in near),
        )
    )


def standard_models() -> dict[str, Path]:
    """Name and file of the models that come with arael."""
    here = Path(__file__).resolve().parent
    checkout = here.parent / "models"
    folder = checkout if (here.parent / "pyproject.toml").is_file() else here / "models"
    return {p.stem: p for p in sorted(folder.glob("*.arael"))}


def _read(path: Path) -> str:
    """Text of the model; what is wrong with the file is told by the syntax room."""
    try:
        if path.is_file() and path.stat().st_size <= 1 << 20:
            return path.read_bytes().decode("utf-8")
    except (OSError, UnicodeDecodeError):
        pass
    from arael.syntax.files import read_source

    return read_source(path).text


def _shipped(path: Path, text: str, precision: str | None) -> Compiled | None:
    """Take the model as compiled when arael was installed, if it is that very text."""
    folder = Path(__file__).resolve().parent / "models"
    for target in processor.usable_targets():
        name = f"{path.stem}-{target}" + (f"-{precision}" if precision else "")
        entry = cache.read_entry(folder / name)
        if entry is None:
            continue
        if entry.manifest.key == cache.shipped_key(text, target):
            return _from_entry(entry, "shipped")
    return None


def _from_entry(
    entry: cache.Entry,
    origin: str,
    seconds: dict[str, float] | None = None,
    path: Path | None = None,
) -> Compiled:
    layout = from_json(entry.layout)
    if path is not None and layout.source != str(path):
        layout = from_json(_moved(entry.layout, layout.source, str(path)))
    module = entry.module
    if module is None:
        _warn_interpreted(entry.manifest.compiler)
        return Compiled(layout, None, entry.folder, "interpreted", seconds or {})
    if seconds:
        stages = ", ".join(f"{stage} {time:.2f} s" for stage, time in seconds.items())
        log("compile", "info", f"compiled {layout.name} ({layout.precision}): {stages}")
    else:
        log("compile", "debug", f"found {layout.name} ({layout.precision}) compiled: {origin}")
    return Compiled(layout, _kernels(module), entry.folder, origin, seconds or {})


def _moved(layout: bytes, before: str, now: str) -> bytes:
    """The layout of a file with the same text elsewhere: its messages name the file at hand."""
    old, new = (msgspec.json.encode(name)[1:-1] for name in (before, now))
    # Places begin with the file; in warnings, which are rendered, they stand behind an arrow.
    for start, end in ((b'"', b'"'), (b'"', b":"), (b" --> ", b":")):
        layout = layout.replace(start + old + end, start + new + end)
    return layout


def _kernels(module: Path) -> Any:
    """Import an extension module by file and take its table of kernels."""
    name = module.name.partition(".")[0]
    unique = f"arael_kernels_{hashlib.sha256(str(module).encode()).hexdigest()[:16]}"
    loaded = sys.modules.get(unique)
    if loaded is None:
        loader = importlib.machinery.ExtensionFileLoader(name, str(module))
        spec = importlib.util.spec_from_file_location(name, module, loader=loader)
        assert spec is not None
        loaded = importlib.util.module_from_spec(spec)
        loader.exec_module(loaded)
        sys.modules[unique] = loaded
    return loaded.KERNELS


def _warn_interpreted(why: str) -> None:
    if why:
        warnings.warn(
            f"running on the NumPy interpreter, which is slow: {why}; `arael doctor` tells more",
            InterpretedWarning,
            stacklevel=4,
        )


def _compile(
    path: Path, key: str, root: str | None, precision: str | None, interpret: bool | None
) -> Compiled:
    """Compile a model and keep the result; another process may have done so meanwhile."""
    from arael.compiler import build, compiler

    dependencies: dict[str, str] = {}
    program, seconds = compile_program(path, root, precision, dependencies)
    layout = program.layout
    try:
        with cache.building(key) as folder:
            entry = _usable(cache.find(key), interpret)
            if entry is not None:
                return _from_entry(entry, "cache", path=path)
            (folder / "layout.json").write_bytes(to_json(layout))
            described, without = "", ""
            if not interpret:
                source = compiler.emit(program, cache.digest(path.read_bytes())[:16])
                try:
                    build_module(folder, f"kernels_{layout.name}_{key[:8]}", source, seconds)
                    described = build.compiler_version()
                except build.NoCompiler as error:
                    described, without = error.diagnostics[0].message, build.compiler_identity()
                    cache.keep_failure(key, str(error))
                    if interpret is False:
                        raise
            entry = cache.store(
                key,
                folder,
                layout.name,
                str(path.resolve()),
                described,
                seconds,
                dependencies,
                without,
            )
    except AraelError as error:
        if interpret and any(d.code.startswith("E080") for d in error.diagnostics):
            return Compiled(layout, None, None, "interpreted", seconds)
        raise
    return _from_entry(entry, "interpreted" if interpret else "compiled", seconds)


def kernels_of(layout: Layout, source: str) -> Any:
    """Kernels of generated source, compiled or found in the cache; a capsule ``arael.kernels``.

    Parameters
    ----------
    layout : what they belong to
    source : Cython source, as `arael.compiler.compiler.emit` makes it

    Raises
    ------
    AraelError
        E0801-E0803: there is no working C compiler; E0804 the cache cannot be written.
    """
    from arael.compiler import build

    key = cache.key(source, layout.root, layout.precision, "native")
    entry = _usable(cache.find(key), False)
    if entry is None or entry.module is None:
        seconds: dict[str, float] = {}
        with cache.building(key) as folder:
            (folder / "layout.json").write_bytes(to_json(layout))
            build_module(folder, f"kernels_{layout.name}_{key[:8]}", source, seconds)
            described = build.compiler_version()
            entry = cache.store(key, folder, layout.name, layout.source, described, seconds, {})
    assert entry.module is not None
    return _kernels(entry.module)


def build_module(
    folder: Path, name: str, source: str, seconds: dict[str, float], target: str = "native"
) -> None:
    """Write, cythonise and compile kernels into `folder`.

    Raises
    ------
    arael.compiler.build.NoCompiler
        There is none, or it does not work; the source stays.
    """
    from arael.compiler import build

    pyx = folder / f"{name}.pyx"
    pyx.write_text(source, encoding="utf-8")
    build.require_compiler()
    started = time.perf_counter()
    c_file = build.cython_to_c(pyx)
    seconds["cython"] = time.perf_counter() - started
    started = time.perf_counter()
    try:
        build.compile_c(c_file, target)
    finally:
        c_file.unlink(missing_ok=True)
    seconds["compile"] = time.perf_counter() - started


def compile_program(
    path: Path, root: str | None, precision: str | None, dependencies: dict[str, str]
) -> tuple[Any, dict[str, float]]:
    """Run the stages up to the IR; return the program and what each stage took."""
    started = time.perf_counter()
    from arael.compiler import compiler
    from arael.compiler.imports import Imports
    from arael.diagnostics.records import Findings
    from arael.diagnostics.render import render
    from arael.syntax.files import read_source

    seconds = {"import": time.perf_counter() - started}

    imports = Imports()
    started = time.perf_counter()
    tree = compiler.syntax(read_source(path))
    seconds["syntax"] = time.perf_counter() - started
    findings = Findings()
    started = time.perf_counter()
    model = compiler.types(tree, findings, root, imports)
    dependencies |= imports.digests()
    seconds["check"] = time.perf_counter() - started
    started = time.perf_counter()
    said = tuple(render([d], color=False, width=100) for d in findings.warnings)
    program = compiler.derive(model, str(path), precision, said)
    seconds["derive"] = time.perf_counter() - started
    return program, seconds
