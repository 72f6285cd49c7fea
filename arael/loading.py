"""`load`: from a model's name or file to a class, compiled once and cached.

A warm start reads two cache entries (the layout of the text, and its kernels) and imports one
extension module; the language packages, lark, SymPy, Cython and setuptools are not imported.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arael.compiled_model import (
    CompiledModel,
    Interpret,
    Precision,
    Recipe,
    warn_of_machine,
)
from arael.compiler import processor
from arael.compiler.cache import code_digest, models
from arael.compiler.cache import kernels as kept
from arael.compiler.cache.keys import model_key, shipped_key
from arael.compiler.extension import import_kernels
from arael.compiler.kernels import Loaded, find_kernels, kernels_of, standing_failure
from arael.compiler.no_compiler import NoCompiler
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import user_frames
from arael.diagnostics.model_warnings import InterpretedWarning, warn_of_model
from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.diagnostics.suggest import closest
from arael.functions import Functions
from arael.log import log
from arael.model import Model
from arael.runtime.layout import Layout
from arael.syntax.files import read_source, source_of

if TYPE_CHECKING:
    from arael.compiler.compilation import Compilation
    from arael.model import Model

__all__ = ["CompiledModel", "InterpretedWarning", "Recipe", "load", "load_compiled", "loads"]


def load(
    model: str | os.PathLike[str],
    *,
    precision: Precision | None = None,
    root: str | None = None,
    interpret: Interpret = None,
    functions: Mapping[str, Any] | None = None,
) -> type[Model]:
    """Load a model as a class whose instances hold its data.

    Parameters
    ----------
    model : name of a standard model (``"slam"``) or path of a ``.arael`` file
    precision : ``"f64"`` or ``"f32"`` instead of what the root declares
    root : which root, where the file has several
    interpret : run on the expression machine (True), on compiled kernels or not at all (False), or
        on the machine only where there is no C compiler (None); ``"meanwhile"``: on the
        machine until another process has compiled the kernels. An instance changes over to them
        when its next solve begins, never within one; results agree to rounding.
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
        lacks something; each diagnostic names the place and a remedy.

    Warns
    -----
    ModelWarning
        Something in the model is probably a mistake (``W....``), with the text of `arael check`.
    InterpretedWarning
        No C compiler was found, so the expression machine is used. With ``"meanwhile"``: when
        the next solve begins after the compilation has failed, with the reason.
    SlowFunctionWarning
        A Python function is bound to an ``extern fn``.
    """
    __tracebackhide__ = True
    with user_frames:
        compiled = load_compiled(model, precision=precision, root=root, interpret=interpret)
        return class_of(compiled, functions)


def loads(
    text: str,
    *,
    name: str = "model.arael",
    precision: Precision | None = None,
    root: str | None = None,
    interpret: Interpret = None,
    functions: Mapping[str, Any] | None = None,
) -> type[Model]:
    """Load a model from its text, otherwise as `load` does.

    Parameters
    ----------
    text : a model as in a ``.arael`` file
    name : its name in messages; files that it imports are looked for beside a file of that name
    precision, root, interpret, functions : see `load`

    Returns
    -------
    A subclass of `arael.model.Model`.

    Raises
    ------
    AraelError
        As `load`.

    Examples
    --------
    >>> import arael
    >>> Mean = arael.loads("root R { param m: real = 0; c: vec3; constraint at { c - [m, m, m] } }")
    >>> mean = Mean(c=[1, 2, 6])
    >>> mean.solve().converged, round(float(mean.m), 6)
    (True, 3.0)
    """
    __tracebackhide__ = True
    with user_frames:
        return class_of(_compiled_text(text, name, precision, root, interpret), functions)


def class_of(compiled: CompiledModel, functions: Mapping[str, Any] | None = None) -> type[Model]:
    """The class of a compiled model, with native functions bound."""
    layout = compiled.layout
    warn_of_model(layout.warnings, stacklevel=4)  # at the caller of `load` or `loads`
    if functions:
        # imported here: start-up time
        from arael.face.native import bind_all

        bindings = bind_all(layout, functions, stacklevel=4)
        compiled = replace(compiled, bindings=bindings, functions=dict(functions))

    def construct(self: Model, /, **values: Any) -> None:
        __tracebackhide__ = True
        with user_frames:
            Model.__init__(self, compiled.current(level=3), **values)

    name = layout.name.encode("utf-8", "replace").decode()  # names of files need not be UTF-8
    members = {
        "__init__": construct,
        "__reduce__": _reduced,
        "__doc__": layout.doc or f"The model {name}.",
        "__module__": f"arael.models.{name}",
        "compiled": compiled,
        "layout": layout,
        "functions": Functions(layout, compiled.bindings),
    }
    return type(layout.root, (Model,), members)


def _reduced(model: Model) -> tuple[Any, ...]:
    """What pickle stores of a loaded model: its text, bound functions and data, no machine code."""
    # imported here: start-up time
    from arael.copying import state_of

    compiled = model._compiled
    return _unpickled, (compiled.recipe, dict(compiled.functions), state_of(model))


def _unpickled(recipe: Recipe, functions: Mapping[str, Any], state: Any) -> Model:
    # imported here: start-up time
    from arael.copying import restore

    kind: Any = loads(
        recipe.text,
        name=recipe.name,
        precision=recipe.precision,
        root=recipe.root,
        interpret=recipe.interpret,
        functions=functions,
    )
    model: Model = kind.__new__(kind)
    model._begin(kind.compiled)
    restore(model, state)
    return model


def load_compiled(
    model: str | os.PathLike[str],
    *,
    precision: Precision | None = None,
    root: str | None = None,
    interpret: Interpret = None,
) -> CompiledModel:
    """`load`, without the class."""
    _check_choices(precision, interpret, root)
    source = read_source(find_model(model))  # read once: what is looked up would be compiled
    return _load_source(source, precision, root, interpret)


def _compiled_text(
    text: str, name: str, precision: Precision | None, root: str | None, interpret: Interpret
) -> CompiledModel:
    """`loads`, without the class; called by it directly, as `load_compiled` is by `load`."""
    if not isinstance(text, str):
        raise AraelError(
            Diagnostic(
                "E0103",
                f"the text of a model is a string, found {type(text).__name__}",
                origin="loads",
                help=("`arael.load(path)` reads a file",),
            )
        )
    _check_choices(precision, interpret, root)
    if not isinstance(name, str):
        raise wrong_argument("loads", "name", "the name of the model in messages", name)
    source = source_of(text.encode("utf-8", "surrogatepass"), name)
    return _load_source(source, precision, root, interpret)


def _check_choices(precision: Any, interpret: Any, root: Any) -> None:
    if root is not None and not isinstance(root, str):
        raise wrong_argument("load", "root", "the name of a root", root)
    if precision is not None and (
        not isinstance(precision, str) or precision not in ("f32", "f64")
    ):
        raise AraelError(
            Diagnostic(
                "E0811",
                f"unknown precision {precision!r}",
                origin="precision",
                help=("write `f32` or `f64`",),
            )
        )
    if not (
        interpret is None
        or isinstance(interpret, bool)
        or (isinstance(interpret, str) and interpret == "meanwhile")
    ):
        raise AraelError(
            Diagnostic(
                "E0827",
                f"`interpret` is {interpret!r}",
                origin="interpret",
                help=('write `True`, `False`, `None` or `"meanwhile"`',),
            )
        )


def _load_source(
    source: Source, precision: Precision | None, root: str | None, interpret: Interpret
) -> CompiledModel:
    """Take a model from the installation or the cache, or compile it."""
    recipe = Recipe(source.text, source.name, precision, root, interpret)
    return replace(_found_or_compiled(source, recipe), recipe=recipe)


def _found_or_compiled(source: Source, recipe: Recipe) -> CompiledModel:
    path, interpret = Path(source.name), recipe.interpret
    precision, root = recipe.precision, recipe.root
    only = interpret is True
    if not only and root is None:
        shipped = _shipped(path, source, precision)
        if shipped is not None:
            return shipped
    # The same text beside other files to import is another model.
    beside = str(path.resolve().parent) if "import" in source.text else ""
    key = model_key(source.text, root, precision, beside)
    found = models.find(key, source)
    if found is not None:
        if only:
            return CompiledModel(found.layout, None, None, "interpreted", {})
        loaded = find_kernels(found.code)
        if loaded is not None:
            return _with_kernels(found.layout, loaded)
        if interpret is not False:
            failure = standing_failure(found.code)
            if failure is not None:
                return _interpreted(found.layout, failure)
    return _compile(source, key, root, precision, interpret)


def find_model(model: str | os.PathLike[str]) -> Path:
    """Path of a model given by file or by the name of a standard model.

    Raises
    ------
    AraelError
        E0812 if there is neither.
    """
    if not isinstance(model, str | os.PathLike):
        raise AraelError(
            Diagnostic(
                "E0812",
                f"a model is the path of a file or a standard model's name, found "
                f"{type(model).__name__}",
                origin="load",
                help=("for a model in a string, `arael.loads(text)`",),
            )
        )
    name = os.fspath(model)
    path = Path(name)
    if path.suffix == ".arael" or path.is_file() or os.sep in name:
        return path
    known = standard_models()
    if name in known:
        return known[name]

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


def _shipped(path: Path, source: Source, precision: str | None) -> CompiledModel | None:
    """Take the model as compiled when arael was installed, if it is that very text."""
    folder = Path(__file__).resolve().parent / "models"
    for target in processor.usable_targets():
        name = f"{path.stem}-{target}" + (f"-{precision}" if precision else "")
        entry = kept.read_entry(folder / name)
        if entry is None or entry.manifest.key != shipped_key(source.text, target):
            continue
        found = models.read(entry.folder / "model.json", source)
        if found is None or entry.module is None:
            continue
        try:
            table = import_kernels(entry.module)
        except ImportError:  # a module of another platform or Python
            continue
        layout = found.layout
        log("compile", "debug", f"found {layout.name} ({layout.precision}) compiled: shipped")
        return CompiledModel(layout, table, entry.folder, "shipped", {})
    return None


def _compile(
    source: Source, key: str, root: str | None, precision: str | None, interpret: Interpret
) -> CompiledModel:
    """Compile a model and keep the result."""
    # imported here: start-up time
    from arael.compiler.compilation import compile_text

    compilation = compile_text(source, root, precision)
    layout = compilation.layout
    if interpret is True:
        with contextlib.suppress(AraelError):  # a cache that cannot be used is not needed
            models.store(key, compilation.known(""))
        return CompiledModel(layout, None, None, "interpreted", compilation.seconds)
    code = compilation.emit()
    if interpret == "meanwhile":
        return _started(source, key, compilation, code)
    try:
        loaded = kernels_of(code, layout.name, source.name)
    except NoCompiler as error:
        if interpret is False:
            raise
        models.store(key, compilation.known(code_digest(code)))
        return _interpreted(layout, error.diagnostics[0].message, compilation.seconds, level=7)
    models.store(key, compilation.known(code_digest(code)))
    return _with_kernels(layout, loaded, compilation.seconds)


def _started(source: Source, key: str, compilation: Compilation, code: str) -> CompiledModel:
    """Compile in the background, if the kernels are not there."""
    # imported here: start-up time
    from arael.compiler.meanwhile import Meanwhile

    layout = compilation.layout
    with contextlib.suppress(AraelError):  # the compilation will report it
        models.store(key, compilation.known(code_digest(code)))
    loaded = find_kernels(code_digest(code))
    if loaded is not None:
        return _with_kernels(layout, loaded, compilation.seconds)
    task = Meanwhile(code, layout.name, source.name)
    return CompiledModel(layout, None, None, "interpreted", compilation.seconds, meanwhile=task)


def _with_kernels(
    layout: Layout, loaded: Loaded, seconds: Mapping[str, float] | None = None
) -> CompiledModel:
    taken = {**(seconds or {}), **loaded.seconds}
    if loaded.compiled:
        stages = ", ".join(f"{stage} {time:.2f} s" for stage, time in taken.items())
        log("compile", "info", f"compiled {layout.name} ({layout.precision}): {stages}")
    else:
        log("compile", "debug", f"found {layout.name} ({layout.precision}) compiled: cache")
    origin = "compiled" if loaded.compiled else "cache"
    return CompiledModel(layout, loaded.table, loaded.folder, origin, taken)


def _interpreted(
    layout: Layout, why: str, seconds: dict[str, float] | None = None, level: int = 6
) -> CompiledModel:
    warn_of_machine(why, level + 1)
    return CompiledModel(layout, None, None, "interpreted", seconds or {})
