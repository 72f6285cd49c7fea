"""Keys of entries: digests of everything that an entry depends on."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import sys
import sysconfig
from functools import lru_cache
from pathlib import Path

from arael.version import __version__

FORMAT = 2
"""Version of the files in the cache."""

LENGTH = 40
"""Characters of a key."""

# Comments of generated source: whole lines, and ends of lines. Directives of Cython are code, and
# the preprocessor's have no space behind the `#`.
_COMMENT = re.compile(r"^ *# (?!cython:).*\n| +# .*$", re.MULTILINE)


def digest(data: bytes) -> str:
    """SHA-256 as hexadecimal text."""
    return hashlib.sha256(data).hexdigest()


def model_key(text: str, root: str | None, precision: str | None, beside: str = "") -> str:
    """Key of what a model's text means.

    Parameters
    ----------
    text : the model
    root, precision : as chosen by the caller
    beside : folder of a model that imports others: the same text elsewhere imports other files
    """
    return _key(__version__, _package_stamp(), root or "", precision or "", beside, text)


def code_digest(source: str) -> str:
    """Digest of generated source without its comments, which name places of the model."""
    return digest(_COMMENT.sub("", source).encode())


def kernels_key(code: str, target: str) -> str:
    """Key of compiled kernels.

    Parameters
    ----------
    code : `code_digest` of their source
    target : instruction set, as in `arael.compiler.build.compile_flags`
    """
    return _key(
        __version__,
        _interface(),
        sysconfig.get_config_var("EXT_SUFFIX") or "",
        sys.version,
        _processor(),
        *(os.environ.get(name, "") for name in ("CC", "CFLAGS", "LDFLAGS")),
        target,
        code,
    )


def shipped_key(text: str, target: str) -> str:
    """Key of a model that was compiled when arael was installed."""
    return _key(__version__, sysconfig.get_config_var("EXT_SUFFIX") or "", target, text)


def is_key(name: str) -> bool:
    """Whether `name` has the form of a key."""
    return re.fullmatch(f"[0-9a-f]{{{LENGTH}}}", name) is not None


def _key(*parts: str) -> str:
    return digest("\0".join((str(FORMAT), *parts)).encode("utf-8", "surrogatepass"))[:LENGTH]


@lru_cache(maxsize=1)
def _package_stamp() -> str:
    """Digest the times of arael's own files, so that a checkout under work serves nothing stale."""
    stamps = []
    package = Path(__file__).parents[2]
    for part in ("check", "compiler", "manifolds", "operations", "runtime", "symbolic", "syntax"):
        for folder, _, names in os.walk(package / part):
            for name in names:
                if name.endswith((".py", ".pxd", ".lark")):
                    file = Path(folder, name)
                    with contextlib.suppress(OSError):
                        stamps.append(f"{file}:{file.stat().st_mtime_ns}")
    return digest("\n".join(sorted(stamps)).encode("utf-8", "surrogatepass"))


@lru_cache(maxsize=1)
def _interface() -> str:
    """Digest what else kernels are made from: what they share with the runtime, flags."""
    package = Path(__file__).parents[2]
    files = (
        package / "runtime" / "kernel.pxd",
        package / "runtime" / "lanes.h",
        package / "compiler" / "build.py",
    )
    parts = []
    for file in files:
        with contextlib.suppress(OSError):
            parts.append(digest(file.read_bytes()))
    return " ".join(parts)


@lru_cache(maxsize=1)
def _processor() -> str:
    """Identify the instruction set that ``-march=native`` stands for."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith(("flags", "Features")):
                return platform.machine() + line
    return platform.machine() + platform.processor()
