"""From Cython source to an extension module: Cython, the C compiler, the flags.

Nothing here is imported when a model is found in the cache.
"""

from __future__ import annotations

import contextlib
import io
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from arael.compiler.extension import require_loadable
from arael.compiler.garbage import rare_collections
from arael.compiler.no_compiler import (
    NoCompiler,
    failed,
    no_compiler,
    not_started,
    too_slow,
    unloadable,
)
from arael.compiler.processes import TimedOut, run_bounded
from arael.compiler.time_limit import compile_limit
from arael.diagnostics.records import AraelError, Diagnostic

# Instruction sets to build for: this machine's, the architecture's smallest, or the value of an
# `-march` option (`x86-64-v3`).
NATIVE = "native"
BASELINE = "baseline"


HEADERS = Path(__file__).resolve().parents[1] / "runtime"
"""Folder of ``lanes.h``, which generated kernels include."""

# By default GCC unrolls short loops over the lanes completely before its vectoriser runs.
FLAGS = [
    "-O3",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fopenmp-simd",
    "--param=max-completely-peel-times=7",
]
"""Flags of GCC and Clang on which the speed of kernels depends, on every machine."""

PROBE_LIMIT = 20.0
"""Seconds that the C compiler may take for the smallest extension module."""


def compile_flags(target: str = NATIVE) -> list[str]:
    """List the flags of the C compiler.

    Errno and floating-point traps are disabled: they are not used and prevent vectorisation.
    NaN and infinity are preserved, because solves report them.
    """
    if sys.platform == "win32":
        return ["/O2", "/fp:precise", "/DNDEBUG"]
    # Assertions of Python's headers would bring the headers' paths along.
    flags = [*FLAGS, "-w", "-g0", "-DNDEBUG", *machine_flags(target)]
    if has_vector_library():
        flags.append("-DARAEL_LIBMVEC")
    return flags


def machine_flags(target: str) -> list[str]:
    """List the flags that choose the instruction set."""
    machine = platform.machine().lower()
    if machine in ("x86_64", "amd64"):
        # 512-bit registers where there are any: the default of many compilers is 256.
        wide = ["-mprefer-vector-width=512"]
        return wide if target == BASELINE else [f"-march={target}", *wide]
    return ["-mcpu=native"] if target == NATIVE and machine in ("aarch64", "arm64") else []


def has_vector_library() -> bool:
    """Whether glibc's vector mathematics can be linked (Linux on x86-64 with glibc)."""
    return (
        sys.platform == "linux"
        and platform.machine() == "x86_64"
        and platform.libc_ver()[0] == "glibc"
    )


def link_flags() -> list[str]:
    """Libraries of the generated module."""
    if sys.platform == "win32":
        return []
    return ["-lmvec", "-lm"] if has_vector_library() else ["-lm"]


def find_compiler() -> str | None:
    """Path of the C compiler that would be used, or None."""
    if sys.platform == "win32":
        return shutil.which("cl")
    chosen = _extra("CC")
    usual = (sysconfig.get_config_var("CC") or "cc").split()[:1]
    for candidate in chosen[:1] or (*usual, "cc", "gcc", "clang"):
        compiler = shutil.which(candidate)
        if compiler:
            return compiler
    return None


def require_compiler() -> None:
    """Raise NoCompiler (E0801) if there is none."""
    if find_compiler() is None:
        raise no_compiler()


def compiler_identity() -> str:
    """Path and age of the compiler and of Python's headers, and how long it may take.

    A compilation that failed with the same identity would fail again.
    """
    path = find_compiler()
    if path is None:
        return "none"
    header = os.path.join(sysconfig.get_path("include"), "Python.h")
    ages = []
    for file in (path, header):
        with contextlib.suppress(OSError):
            ages.append(f"{file}:{os.stat(file).st_mtime_ns}")
    return " ".join((*ages, str(compile_limit())))


def compiler_version() -> str:
    """First line of the compiler's ``--version``, or ""."""
    path = find_compiler()
    if path is None:
        return ""
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(
            [path, "--version"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=PROBE_LIMIT,
            check=False,
        )
        said = (done.stdout.strip() or done.stderr.strip()).decode("utf-8", "replace")
        return next(iter(said.splitlines()), "")
    return ""


def probe(folder: Path) -> NoCompiler | None:
    """Compile and load the smallest extension module in `folder`; return what went wrong, or None.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    source = folder / "arael_probe.c"
    source.write_text(_PROBE, encoding="utf-8")
    try:
        module = compile_c(source, limit=min(PROBE_LIMIT, compile_limit()))
        require_loadable(module)
    except NoCompiler as error:
        return error
    except ImportError as error:
        return unloadable(error, find_compiler() or "")
    return None


_PROBE = """
#include <Python.h>
#include <math.h>
static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "arael_probe", 0, -1, 0};
PyMODINIT_FUNC PyInit_arael_probe(void) { return PyModule_Create(&definition); }
"""


@rare_collections()
def cython_to_c(pyx: Path) -> Path:
    """Run Cython on `pyx`; return the C file beside it."""
    # imported here: start-up time
    from Cython.Compiler import Main
    from Cython.Compiler.Options import default_options

    package_root = str(Path(__file__).resolve().parents[2])
    c_file = pyx.with_suffix(".c")
    options: Any = vars(Main)["CompilationOptions"](
        {
            **default_options,
            "language_level": 3,
            "include_path": [package_root],
            "output_file": str(c_file),
            "emit_linenums": False,
        }
    )
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        result: Any = vars(Main)["compile_single"](str(pyx), options, full_module_name=pyx.stem)
    if result.num_errors:
        raise AraelError(
            Diagnostic(
                "E0810",
                "the generated kernels were refused by Cython; this is a fault of arael",
                origin=str(pyx),
                notes=tuple(said.getvalue().strip().splitlines()[-12:]),
                help=("please report it together with the model",),
            )
        )
    text = c_file.read_text(encoding="utf-8")
    c_file.write_text(_FILES.sub(_names_only, text, count=1), encoding="utf-8")
    return c_file


# The files that Cython would name in tracebacks: part of the module, with their folders.
_FILES = re.compile(r"(?<=__pyx_f\[\] = \{\n)(?: *\".*\",\n)+")


def _names_only(files: re.Match[str]) -> str:
    return re.sub(r'".*[/\\]([^/\\"]+)"', r'"\1"', files[0])


def compile_c(
    c_file: Path,
    target: str = NATIVE,
    what: str = "compiling",
    limit: float | None = None,
    spent: float = 0.0,
) -> Path:
    """Compile and link one generated C file; return the extension module beside it.

    Parameters
    ----------
    what : for reports of progress
    limit : seconds that the compiler may take, instead of `compile_limit`
    spent : seconds that went before, for reports of progress

    Raises
    ------
    NoCompiler
        There is none, or it cannot compile an extension module here.
    """
    require_compiler()
    module = c_file.with_name(c_file.stem + (sysconfig.get_config_var("EXT_SUFFIX") or ".so"))
    if sys.platform == "win32":
        return _compile_with_setuptools(c_file, module, target)
    compiler = _command()
    folders = sysconfig.get_path("include"), sysconfig.get_path("platinclude"), str(HEADERS)
    include = [f"-I{folder}" for folder in folders]
    shared = ["-shared", "-fPIC"]
    if sys.platform == "darwin":
        shared = ["-bundle", "-undefined", "dynamic_lookup", "-fPIC"]
    _run(
        [
            *compiler,
            *compile_flags(target),
            *_extra("CFLAGS"),
            *include,
            *shared,
            c_file.name,  # by its name, as __FILE__ becomes part of the module
            "-o",
            str(module),
            *_extra("LDFLAGS"),
            *link_flags(),
        ],
        c_file,
        what,
        compile_limit() if limit is None else limit,
        spent,
    )
    if not module.is_file():
        raise NoCompiler(
            Diagnostic(
                "E0803",
                "the C compiler reported success, but made no module",
                origin=compiler[0],
                help=("`arael doctor` shows which compiler is used; CC chooses another",),
            )
        )
    return module


def _command() -> list[str]:
    path = find_compiler()
    assert path is not None
    chosen = os.environ.get("CC", "").split()
    return [path, *chosen[1:]]


def _extra(variable: str) -> list[str]:
    return os.environ.get(variable, "").split()


def _run(command: Sequence[str], source: Path, what: str, limit: float, spent: float) -> None:
    try:
        done = run_bounded(command, source.parent, limit, what, spent)
    except TimedOut:
        raise too_slow(command[0], limit) from None
    except OSError as error:
        raise not_started(command[0], error) from None
    if done.status != 0:
        raise failed(command[0], done.status, done.lines)


def _compile_with_setuptools(c_file: Path, module: Path, target: str) -> Path:
    # imported here: start-up time
    from setuptools._distutils.ccompiler import new_compiler
    from setuptools._distutils.errors import CCompilerError, DistutilsError

    compiler = new_compiler()
    try:
        objects = compiler.compile(
            [str(c_file)],
            output_dir=str(c_file.parent),
            include_dirs=[sysconfig.get_path("include"), str(HEADERS)],
            extra_preargs=compile_flags(target),
        )
        compiler.link_shared_object(
            objects,
            str(module),
            library_dirs=[str(Path(sys.base_prefix) / "libs")],
            export_symbols=[f"PyInit_{c_file.stem}"],
        )
    except (CCompilerError, DistutilsError) as error:
        raise NoCompiler(
            Diagnostic("E0803", "the C compiler failed", origin="cl", notes=(str(error)[:500],))
        ) from error
    return module
