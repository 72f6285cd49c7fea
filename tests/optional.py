"""Parts that are not needed to run the tests: a test that uses one is skipped where it is absent.

The reason of the skip is the command that installs the part. `pytest --no-skips` turns each such
skip into a failure.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

import pytest


class Part(NamedTuple):
    """An optional part: the module that shows that it is there, and how to install it."""

    module: str
    install: str


PARTS = {
    "scikit-sparse": Part(
        "sksparse.cholmod", 'apt install libsuitesparse-dev && pip install "scikit-sparse<0.5"'
    ),
    "numba": Part("numba", "pip install numba"),
    "matplotlib": Part("matplotlib", 'pip install "arael[plot]"'),
    "rerun": Part("rerun", 'pip install "arael[rerun]"'),
    "pyarrow": Part("pyarrow", 'pip install "arael[arrow]"'),
    "h5py": Part("h5py", 'pip install "arael[hdf5]"'),
    "ezdxf": Part("ezdxf", 'pip install "arael[sketch]"'),
    "build123d": Part("build123d", 'pip install "arael[step]"'),
    "evo": Part("evo.core.metrics", "pip install evo"),
    "IPython": Part("IPython", "pip install ipython"),
    "cffi": Part("cffi", "pip install cffi"),
    "websockets": Part("websockets", 'pip install "arael[sketch]"'),
    "starlette": Part("starlette", 'pip install "arael[sketch]"'),
    "mcp": Part("mcp", 'pip install "arael[sketch]"'),
    "anywidget": Part("anywidget", 'pip install "arael[notebook]"'),
    "playwright": Part("playwright.sync_api", "pip install playwright"),
    "Dask": Part("distributed", 'pip install "arael[distributed]"'),
    "cryptography": Part("cryptography", "pip install cryptography"),
    "JAX": Part("jax", 'pip install "arael[jax]"'),
    "PyTorch": Part("torch", 'pip install "arael[torch]"'),
    "gtsam": Part("gtsam", "pip install gtsam"),
    "dask": Part("distributed", 'pip install "arael[distributed]"'),
}


@cache
def is_installed(part: str) -> bool:
    """Whether the optional part can be imported."""
    try:
        importlib.import_module(PARTS[part].module)
    except ImportError:
        return False
    return True


PROGRAMS = {
    "node": "apt install nodejs",
    "npm": "apt install npm",
    "cmake": "apt install cmake g++",
    "g++": "apt install g++",
    "clang": "apt install clang lld wasi-libc libclang-rt-14-dev-wasm32",
}
"""Programs that some tests call, and how to install them."""


def program(name: str) -> str:
    """Path of a program of `PROGRAMS`; the calling test is skipped where it is absent."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"needs {name}: {PROGRAMS[name]}")
    return found


HEADERS = {
    "ceres/ceres.h": "apt install libceres-dev",
    "Eigen/Dense": "apt install libeigen3-dev",
}
"""Headers that some tests compile against, and how to install them."""


def header(name: str) -> None:
    """Skip the calling test where the C++ compiler does not find a header of `HEADERS`."""
    compiler = shutil.which("g++")
    text = f"#include <{name}>\n"
    command = [compiler or "", "-x", "c++", "-M", "-I/usr/include/eigen3", "-"]
    if (
        compiler is None
        or subprocess.run(
            command, input=text, text=True, capture_output=True, check=False
        ).returncode
    ):
        pytest.skip(f"needs {name}: {HEADERS[name]}")


def reason(part: str) -> str:
    """Reason of a skip, with the command that installs the part."""
    return f"needs {part}: {PARTS[part].install}"


def needs(part: str) -> pytest.MarkDecorator:
    """Mark of a test that needs the optional part."""
    return pytest.mark.skipif(not is_installed(part), reason=reason(part))


def require(part: str) -> ModuleType:
    """Module of the optional part; where it is absent the calling test, or module, is skipped."""
    if not is_installed(part):
        pytest.skip(reason(part), allow_module_level=True)
    return importlib.import_module(PARTS[part].module)


def solvers(names: Iterable[str]) -> list[Any]:
    """Parameters of a test that runs with each linear solver: CHOLMOD is optional."""
    return [
        pytest.param(name, marks=needs("scikit-sparse")) if name == "cholmod" else name
        for name in names
    ]
