"""Compiled models on workers: content by its hash, verified on arrival and before use.

The client vouches for a hash. A worker loads nothing but the content of that hash: the layout of
the model, the source of its kernels, and for each architecture an extension module that was
compiled once, by the client or by a worker that has a compiler.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from arael.compiled_model import CompiledModel, Precision, Recipe
from arael.compiler.cache import code_digest, digest, kernels_key
from arael.compiler.cache import kernels as kept
from arael.compiler.extension import import_kernels, require_loadable
from arael.compiler.kernels import TARGET, kernels_of
from arael.compiler.no_compiler import NoCompiler
from arael.diagnostics.model_warnings import InterpretedWarning
from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.distributed.contents import ARRIVED, unvouched
from arael.loading import class_of
from arael.model import Model
from arael.runtime.layout import Layout
from arael.version import __version__

if TYPE_CHECKING:
    from distributed import Client


BY_CHOICE = "the model was loaded with interpret=True"
NOT_SENT = "the worker joined later, and has no C compiler"

_LOOK = 1.0
"""Seconds after which it is looked whether a worker that compiles is still there."""


class Content(msgspec.Struct, frozen=True):
    """What is sent of a model.

    Attributes
    ----------
    version : of arael, the same on both sides
    text, name, precision, root : as in `arael.compiled_model.Recipe`
    layout : the model as the runtime reads it, with the places of the client's file
    code : Cython source of its kernels; "" to run it on the expression machine everywhere
    modules : name and bytes of the extension module, by architecture
    without : why there is none for other architectures
    """

    version: str
    text: str
    name: str
    precision: Precision | None
    root: str | None
    layout: Layout
    code: str
    modules: dict[str, tuple[str, bytes]]
    without: dict[str, str] = {}


class About(msgspec.Struct, frozen=True):
    """What a worker is: version of arael, architecture of kernels, whether it has a compiler."""

    version: str
    architecture: str
    compiler: bool


@dataclass(frozen=True)
class Shipped:
    """A model on the workers of a client.

    Attributes
    ----------
    hash : SHA-256 of the content, which the client vouches for
    identity : SHA-256 of what the model means, the same for all architectures
    interpreted : workers that run it on the expression machine, with the reason
    """

    hash: str
    identity: str
    interpreted: Mapping[str, str]


def architecture() -> str:
    """Key of everything but the source that kernels depend on, in this process."""
    return kernels_key("", TARGET)


def describe() -> About:
    """Describe this process to the client."""
    # imported here: start-up time
    from arael.compiler.build import find_compiler

    return About(__version__, architecture(), find_compiler() is not None)


def ship(client: Client, model: type[Model]) -> Shipped:
    """Give a model to every worker of `client`, those that join later included.

    Kernels are compiled once for each architecture: here for this one, on a worker with a compiler
    for others. A worker for whose architecture there is neither interprets the model.

    Parameters
    ----------
    model : class that `arael.load` returned

    Raises
    ------
    AraelError
        E0882 a worker has no arael, or another version; E0884 the model has native functions.
    """
    content = content_of(model.compiled)  # type: ignore[attr-defined]
    identity = digest(
        msgspec.msgpack.encode((content.text, content.precision, content.root, content.layout))
    )
    workers = _workers(client)
    modules = dict(content.modules)
    without: dict[str, str] = {}
    reasons: dict[str, str] = {}
    if content.code:
        for wanted in sorted({about.architecture for about in workers.values()} - modules.keys()):
            alike = {a: about for a, about in workers.items() if about.architecture == wanted}
            module, why = _compiled_by(client, content, alike)
            if module is not None:
                modules[wanted] = module
            else:
                reasons[wanted] = why
                without.update(dict.fromkeys(alike, why))
    else:
        without = dict.fromkeys(workers, BY_CHOICE)
    data = msgspec.msgpack.encode(
        msgspec.structs.replace(content, modules=modules, without=reasons)
    )
    found = digest(data)
    # Kept by the scheduler, so that a worker that joins or is restarted gets it too.
    client.register_plugin(_arrival(found, data), name=f"arael-{found[:16]}")
    return Shipped(found, identity, without)


def content_of(compiled: CompiledModel) -> Content:
    """What is sent of a compiled model.

    Raises
    ------
    AraelError
        E0884 if native functions are bound: they are addresses in this process.
    """
    recipe = compiled.recipe
    if compiled.bindings or recipe is None:
        raise AraelError(
            Diagnostic(
                "E0884",
                "a model with native functions cannot be sent to other processes",
                origin=recipe.name if recipe else "model",
                help=("write the functions in the model, as `fn`",),
            )
        )
    code = ""
    modules: dict[str, tuple[str, bytes]] = {}
    if recipe.interpret is not True:
        code = _source(compiled, recipe)
        entry = None if compiled.folder is None else kept.read_entry(compiled.folder)
        if entry is not None and entry.module is not None and compiled.kernels is not None:
            modules[architecture()] = (entry.module.name, entry.module.read_bytes())
    return Content(
        __version__,
        recipe.text,
        recipe.name,
        recipe.precision,
        recipe.root,
        compiled.layout,
        code,
        modules,
    )


def _source(compiled: CompiledModel, recipe: Recipe) -> str:
    if compiled.folder is not None:
        for path in compiled.folder.glob("*.pyx"):
            return path.read_text(encoding="utf-8")
    # imported here: start-up time
    from arael.compiler.compilation import compile_text

    return compile_text(Source(recipe.name, recipe.text), recipe.root, recipe.precision).emit()


def _workers(client: Client) -> dict[str, About]:
    found: dict[str, About] = {}
    for address, about in client.run(describe, on_error="return").items():
        if isinstance(about, OSError):  # of the connection: it has died meanwhile
            continue
        if isinstance(about, BaseException):
            raise _unfit(address, f"cannot run arael: {about}")
        if about.version != __version__:
            raise _unfit(address, f"has arael {about.version}, and this is {__version__}")
        found[address] = about
    return found


def _unfit(address: str, what: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0882",
            f"worker {address} {what}",
            origin="cluster",
            help=(f"install it there: pip install 'arael[distributed]=={__version__}'",),
        )
    )


def _compiled_by(
    client: Client, content: Content, workers: Mapping[str, About]
) -> tuple[tuple[str, bytes] | None, str]:
    """The extension module that one of `workers` compiled, or None and the reason."""
    why = "neither it nor a worker like it has a C compiler"
    for address in sorted(a for a, about in workers.items() if about.compiler):
        future = client.submit(
            compile_kernels, content.code, content.layout.name, workers=[address], pure=False
        )
        made = _made(client, future, address)
        if not isinstance(made, str):
            return made, ""
        why = made
    return None, why


def _made(client: Client, future: Any, address: str) -> tuple[str, bytes] | str:
    """What a worker compiled, or why it did not; a worker that is gone is not waited for."""
    while True:
        try:
            made: tuple[str, bytes] | str = future.result(timeout=_LOOK)
            return made
        except TimeoutError:
            info: Any = client.scheduler_info
            if address in info(n_workers=-1)["workers"]:
                continue
            future.cancel()
            return f"the worker that was to compile it has left: {address}"
        except Exception as error:  # Dask's, of a worker that ended; or the machine's, as of a disk
            what = str(error).partition("\n")[0] or "it has ended"
            return f"worker {address} could not compile it: {what}"


def compile_kernels(code: str, name: str) -> tuple[str, bytes] | str:
    """Compile kernels on this worker; the module's name and bytes, or why that failed."""
    try:
        loaded = kernels_of(code, name, name)
    except AraelError as error:
        return error.diagnostics[0].message
    entry = kept.read_entry(loaded.folder)
    if entry is None or entry.module is None:
        return "the cache of the worker does not keep the kernels"
    return entry.module.name, entry.module.read_bytes()


def _arrival(vouched: str, data: bytes) -> Any:
    # imported here: start-up time
    from arael.distributed.arrival import Arrival

    return Arrival(vouched, data)


def load(vouched: str) -> type[Model]:
    """Load the model of a hash in this worker process; see `loaded`."""
    return loaded(vouched)[0]


@lru_cache(maxsize=16)
def loaded(vouched: str) -> tuple[type[Model], str]:
    """The model of a hash in this worker process, and why it is interpreted, "" if it is not.

    Raises
    ------
    AraelError
        E0883 if no content of that hash has arrived, or it was changed since.
    """
    data = ARRIVED.get(vouched)
    if data is None:
        raise unvouched(vouched, "no content of this hash has arrived at the worker")
    if digest(data) != vouched:
        raise unvouched(vouched, "the content was changed after its arrival")
    content = msgspec.msgpack.decode(data, type=Content)
    recipe = Recipe(content.text, content.name, content.precision, content.root)
    table, folder, seconds = _kernels(content)
    why = ""
    if table is None:
        why = content.without.get(architecture(), NOT_SENT) if content.code else BY_CHOICE
    origin = "interpreted" if table is None else "shipped"
    with warnings.catch_warnings(action="ignore"):  # warnings of the model: the client gave them
        kind = class_of(
            CompiledModel(content.layout, table, folder, origin, seconds, recipe=recipe)
        )
    return kind, why


def _kernels(content: Content) -> tuple[Any, Path | None, dict[str, float]]:
    """Kernels for this process, their entry, and what compiling them took."""
    if not content.code:
        return None, None, {}
    sent = content.modules.get(architecture())
    if sent is not None:
        folder = _placed(content, *sent)
        entry = kept.read_entry(folder)
        if entry is not None and entry.module is not None:
            return import_kernels(entry.module), folder, {}
    try:
        with warnings.catch_warnings(action="ignore", category=InterpretedWarning):
            made = kernels_of(content.code, content.layout.name, content.name)
    except NoCompiler:
        return None, None, {}
    return made.table, made.folder, made.seconds


def _placed(content: Content, name: str, module: bytes) -> Path:
    """Folder of the cache entry with an extension module, by the hash of its bytes.

    The entry is separate from that of kernels compiled here: what is loaded is what was sent.
    """
    key = digest(module + code_digest(content.code).encode())[:40]
    entry = kept.find(key)
    if entry is not None and entry.manifest.files.get(name) == digest(module):
        return entry.folder
    with kept.building(key) as folder:
        entry = kept.find(key)  # another process may have stored it meanwhile
        if entry is not None and entry.manifest.files.get(name) == digest(module):
            return entry.folder
        (folder / Path(name).name).write_bytes(module)
        made = kept.store(
            key, folder, content.layout.name, content.name, "sent", {}, require_loadable
        )
    return made.folder
