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

from arael.diagnostics.records import AraelError, Diagnostic

# Instruction sets to build for: this machine's, the architecture's smallest, or the value of an
# `-march` option (`x86-64-v3`).
NATIVE = "native"
BASELINE = "baseline"


class NoCompiler(AraelError):
    """No working C compiler; models can still be interpreted."""


def compile_flags(target: str = NATIVE) -> list[str]:
    """List the flags of the C compiler.

    Errno and traps are given up, because nobody reads them and they keep loops from vectorising.
    NaN and infinity survive: they must reach the report.
    """
    if sys.platform == "win32":
        return ["/O2", "/fp:precise"]
    flags = ["-O3", "-fno-math-errno", "-fno-trapping-math", "-fopenmp-simd", "-w", "-g0"]
    # GCC would write out short loops over the lanes before it looks whether they vectorise.
    flags.append("--param=max-completely-peel-times=7")
    flags += machine_flags(target)
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
    command = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    for candidate in (command.split()[0], "cc", "gcc", "clang"):
        if os.environ.get("CC") and candidate != command.split()[0]:
            break
        found = shutil.which(candidate)
        if found:
            return found
    return None


def require_compiler() -> None:
    """Raise NoCompiler (E0801) if there is none."""
    if find_compiler() is None:
        raise NoCompiler(_no_compiler())


def compiler_identity() -> str:
    """Path and age of the compiler, or "": what fails with it need not be tried again."""
    path = find_compiler()
    if path is None:
        return "none"
    with contextlib.suppress(OSError):
        return f"{path}:{os.stat(path).st_mtime_ns}"
    return path


def compiler_version() -> str:
    """First line of what the compiler says of itself, or ""."""
    path = find_compiler()
    if path is None:
        return ""
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(
            [path, "--version"], capture_output=True, text=True, timeout=20, check=False
        )
        return (done.stdout or done.stderr).splitlines()[0].strip()
    return ""


def cython_to_c(pyx: Path) -> Path:
    """Run Cython on `pyx`; return the C file beside it."""
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
    return c_file


def compile_c(c_file: Path, target: str = NATIVE) -> Path:
    """Compile and link one generated C file; return the extension module beside it.

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
    include = [f"-I{sysconfig.get_path('include')}", f"-I{sysconfig.get_path('platinclude')}"]
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
            str(c_file),
            "-o",
            str(module),
            *_extra("LDFLAGS"),
            *link_flags(),
        ],
        c_file,
    )
    return module


def _command() -> list[str]:
    path = find_compiler()
    assert path is not None
    chosen = os.environ.get("CC", "").split()
    return [path, *chosen[1:]]


def _extra(variable: str) -> list[str]:
    return os.environ.get(variable, "").split()


def _run(command: Sequence[str], source: Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=source.parent)
    if done.returncode == 0:
        return
    said = (done.stderr or done.stdout).strip().splitlines()
    if any(re.search(r"Python\.h|stdio\.h|math\.h", line) for line in said):
        raise NoCompiler(
            Diagnostic(
                "E0802",
                "the C compiler works, but not for Python extension modules: headers are missing",
                origin=command[0],
                notes=tuple(said[:3]),
                help=("install the headers of Python (on Debian and Ubuntu: python3-dev)",),
            )
        )
    raise NoCompiler(
        Diagnostic(
            "E0803",
            f"the C compiler ended with status {done.returncode} on generated kernels",
            origin=command[0],
            notes=tuple(said[:12]),
            help=(
                "`arael doctor` tells which compiler is used and whether it works; "
                "CC chooses another",
            ),
        )
    )


def _no_compiler() -> Diagnostic:
    wanted = os.environ.get("CC")
    message = (
        f"the C compiler `{wanted}` named by CC was not found" if wanted else "no C compiler found"
    )
    return Diagnostic(
        "E0801",
        message,
        origin="environment",
        notes=("models are compiled on this machine the first time they are used",),
        help=(
            "install one: `apt install gcc` (Debian, Ubuntu), `xcode-select --install` (macOS), "
            "Visual Studio Build Tools (Windows)",
            "without one, models run on the NumPy interpreter, which is slow",
        ),
    )


def _compile_with_setuptools(c_file: Path, module: Path, target: str) -> Path:
    from setuptools._distutils.ccompiler import new_compiler
    from setuptools._distutils.errors import CCompilerError, DistutilsError

    compiler = new_compiler()
    try:
        objects = compiler.compile(
            [str(c_file)],
            output_dir=str(c_file.parent),
            include_dirs=[sysconfig.get_path("include")],
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
