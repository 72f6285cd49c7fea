"""Extension modules of kernels: import one by its file, or find out whether that works."""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.util
import os
import sys
from pathlib import Path
from typing import Any


def import_kernels(module: Path) -> Any:
    """Import an extension module by file and return its table of kernels.

    Raises
    ------
    ImportError
        It cannot be loaded, or is no module of kernels.
    """
    unique = f"arael_kernels_{hashlib.sha256(os.fsencode(module)).hexdigest()[:16]}"
    loaded = sys.modules.get(unique)
    if loaded is None:
        loaded = import_file(module)
        if not hasattr(loaded, "KERNELS"):
            raise ImportError(f"{module} holds no kernels", path=str(module))
        sys.modules[unique] = loaded
    return loaded.KERNELS


def import_file(module: Path) -> Any:
    """Import an extension module by file.

    Raises
    ------
    ImportError
        It cannot be loaded.
    """
    name = module.name.partition(".")[0]
    loader = importlib.machinery.ExtensionFileLoader(name, str(module))
    spec = importlib.util.spec_from_file_location(name, module, loader=loader)
    assert spec is not None
    loaded = importlib.util.module_from_spec(spec)
    loader.exec_module(loaded)
    return loaded


def require_loadable(module: Path) -> None:
    """Load a new module, first in a separate process: a damaged one may crash the process.

    Raises
    ------
    ImportError
        It cannot be loaded.
    """
    # imported here: start-up time
    import subprocess

    if "python" in os.path.basename(sys.executable or ""):
        name = module.name.partition(".")[0]
        command = [sys.executable, "-I", "-S", "-c", _LOAD, name, str(module)]
        try:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False
            )
        except (OSError, subprocess.SubprocessError):
            done = None  # no process can be started: find out here
        if done is not None and done.returncode:
            said = done.stderr.decode("utf-8", "replace").strip().splitlines()
            reason = said[-1] if said else f"a process that loads it ends with {done.returncode}"
            raise ImportError(reason, path=str(module))
    import_file(module)


_LOAD = """
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
loader = ExtensionFileLoader(*sys.argv[1:])
loader.exec_module(module_from_spec(spec_from_file_location(*sys.argv[1:], loader=loader)))
"""
