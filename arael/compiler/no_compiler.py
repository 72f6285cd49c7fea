"""Failures of the C compiler: that there is none, or what it reported."""

from __future__ import annotations

import contextlib
import os
import re

from arael.compiler.time_limit import VARIABLE
from arael.diagnostics.records import AraelError, Diagnostic

# What compilers report where memory or space is exhausted, or one of their processes was ended.
_PASSING = (
    "no space left|quota|memory|cannot allocate|killed|terminated|signal|bus error|"
    "input/output error|too many open files|resource temporarily|file too large|"
    "cannot fork|vfork|read-only file system"
)


class NoCompiler(AraelError):
    """No working C compiler; models can still be interpreted.

    Attributes
    ----------
    passing : whether the reason may be temporary: disk space, memory, a killed process
    """

    def __init__(self, diagnostic: Diagnostic, passing: bool = False) -> None:
        super().__init__(diagnostic)
        self.passing = passing


def not_started(compiler: str, error: OSError) -> NoCompiler:
    """The compiler cannot be run at all."""
    return NoCompiler(
        Diagnostic(
            "E0803",
            f"the C compiler cannot be started: {error.strerror or error}",
            origin=compiler,
            help=("CC chooses another compiler",),
        ),
        passing=True,
    )


def failed(compiler: str, status: int, lines: tuple[str, ...]) -> NoCompiler:
    """The compiler ended with an error, after the output `lines`."""
    if any(re.search(r"Python\.h|stdio\.h|math\.h", line) for line in lines):
        return NoCompiler(
            Diagnostic(
                "E0802",
                "the C compiler works, but not for Python extension modules: headers are missing",
                origin=compiler,
                notes=lines[:3],
                help=("install the headers of Python (on Debian and Ubuntu: python3-dev)",),
            )
        )
    text = "\n".join(lines)
    return NoCompiler(
        Diagnostic(
            "E0803",
            f"the C compiler {_ending(status)} on generated kernels",
            origin=compiler,
            notes=lines[:12],
            help=(
                "`arael doctor` tells which compiler is used and whether it works; "
                "CC chooses another",
            ),
        ),
        passing=status < 0 or re.search(_PASSING, text, re.IGNORECASE) is not None,
    )


def _ending(status: int) -> str:
    if status >= 0:
        return f"ended with status {status}"
    # imported here: start-up time
    import signal

    with contextlib.suppress(ValueError):
        return f"was ended by {signal.Signals(-status).name}"
    return f"was ended by signal {-status}"


def too_slow(compiler: str, limit: float) -> NoCompiler:
    """It took longer than `limit` seconds."""
    return NoCompiler(
        Diagnostic(
            "E0807",
            f"the C compiler was stopped: it did not end within {limit:g} s",
            origin=compiler,
            help=(
                "`arael doctor` tells which compiler is used and whether it works",
                f"give a large model on a slow machine more time: `export {VARIABLE}=1800`",
            ),
        )
    )


def no_compiler() -> NoCompiler:
    """None is installed, or not the one that CC names."""
    wanted = os.environ.get("CC", "").strip()
    message = (
        f"the C compiler `{wanted}` named by CC was not found" if wanted else "no C compiler found"
    )
    return NoCompiler(
        Diagnostic(
            "E0801",
            message,
            origin="environment",
            notes=("models are compiled on this machine the first time they are used",),
            help=(
                "install one: `apt install gcc` (Debian, Ubuntu), `xcode-select --install` "
                "(macOS), Visual Studio Build Tools (Windows)",
                "without one, models run on the expression machine, which is slower",
            ),
        )
    )


def unloadable(error: ImportError, compiler: str) -> NoCompiler:
    """The error for a module that was compiled and cannot be loaded."""
    return NoCompiler(
        Diagnostic(
            "E0808",
            "the C compiler made a module that Python cannot load",
            origin=compiler,
            notes=(str(error),),
            help=(
                "compile for this machine and this Python: look at CC, CFLAGS and LDFLAGS, and "
                "try `arael doctor`",
            ),
        )
    )
