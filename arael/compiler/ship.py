"""Models compiled ahead of use: the standard models on install, and those of other packages.

A shipped model is a folder like a cache entry, one per instruction set; at import the best one that
the processor runs is taken.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from arael.compiler import build, processor
from arael.compiler.cache import code_digest, kernels, shipped_key
from arael.compiler.cache.models import encode
from arael.compiler.compilation import compile_text
from arael.compiler.kernels import module_name
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render
from arael.syntax.files import read_source


def ship(models: Iterable[Path], folder: Path, targets: Sequence[str] | None = None) -> list[Path]:
    """Compile `models` into `folder`; return the folders made.

    Parameters
    ----------
    models : `.arael` files; each is copied into `folder`, beside its compiled forms
    targets : instruction sets (``x86-64-v3``, ``baseline``); by default those of this platform

    Raises
    ------
    AraelError
        A model is wrong, or there is no working C compiler.
    """
    chosen = list(processor.shipped_targets() if targets is None else targets)
    folder = folder.resolve()  # the C compiler runs elsewhere
    folder.mkdir(parents=True, exist_ok=True)
    # Deriving and Cython hold the interpreter lock, the C compiler does not.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        waiting = []
        for path in models:
            shutil.copyfile(path, folder / path.name)
            compilation = compile_text(read_source(path))
            text = compilation.sources[0].text
            source = compilation.emit()
            record = encode(compilation.known(code_digest(source)))
            name = module_name(path.stem)
            generated: Path | None = None  # the C code is the same for every target
            for target in chosen:
                entry = folder / f"{path.stem}-{target}"
                shutil.rmtree(entry, ignore_errors=True)
                entry.mkdir()
                (entry / "model.json").write_bytes(record)
                pyx = entry / f"{name}.pyx"
                pyx.write_text(source, encoding="utf-8")
                c_file = pyx.with_suffix(".c")
                if generated is None:
                    generated = build.cython_to_c(pyx).rename(folder / c_file.name)
                shutil.copyfile(generated, c_file)
                key, taken = shipped_key(text, target), compilation.seconds
                waiting.append(pool.submit(_finish, c_file, target, key, path, taken))
            if generated is not None:
                generated.unlink()
        return [job.result() for job in waiting]


def _finish(c_file: Path, target: str, key: str, path: Path, seconds: dict[str, float]) -> Path:
    build.compile_c(c_file, target)
    c_file.unlink()
    entry = c_file.parent
    kernels.seal(entry, key, path.stem, path.name, build.compiler_version(), seconds)
    return entry


#: Compiled when first used, unless the build is portable: `sketch` has twice as much code as all
#: others together, and who opens no sketch does not wait for it.
ON_FIRST_USE = ("sketch",)


def main(models: str, folder: str) -> None:
    """Compile the models of the folder `models` into `folder`; called while arael is built."""
    found = sorted(Path(models).glob("*.arael"))
    later = [p for p in found if p.stem in ON_FIRST_USE and not processor.is_portable()]
    try:
        ship([p for p in found if p not in later], Path(folder), processor.built_targets())
        for path in later:
            shutil.copyfile(path, Path(folder, path.name))
    except AraelError as error:
        raise SystemExit(render(error.diagnostics)) from None


if __name__ == "__main__":
    main(*sys.argv[1:])
