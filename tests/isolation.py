"""No test reads or writes the user's cache, settings or history; child processes inherit this.

The folders lie in pytest's own cache (`.pytest_cache/d/arael`), so that models stay compiled from
one run to the next and are shared by the workers of a run: entries are keyed by content, and
locked while they are built. `pytest --cache-clear` empties them.
"""

from __future__ import annotations

import atexit
import os
import shutil
import signal
import tempfile
from pathlib import Path

import pytest

FOLDERS = {
    "HOME": "home",
    "XDG_CACHE_HOME": "home/.cache",
    "XDG_CONFIG_HOME": "home/.config",
    "XDG_DATA_HOME": "home/.local/share",
    "XDG_STATE_HOME": "home/.local/state",
    "MPLCONFIGDIR": "home/.config/matplotlib",  # its list of fonts takes seconds to make
    "ARAEL_CACHE_DIR": "models",
}
"""Environment variables that lead to a user's files, and what they name during tests."""


def private_environment(folder: Path) -> dict[str, str]:
    """Values of the variables, below `folder`; the folders are made, for the user alone."""
    values = {}
    for variable, name in FOLDERS.items():
        path = folder / name
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        values[variable] = str(path)
    if os.name == "nt":
        values |= {"USERPROFILE": values["HOME"], "LOCALAPPDATA": values["XDG_CACHE_HOME"]}
    return values


def pytest_configure(config: pytest.Config) -> None:
    if hasattr(config, "workerinput"):
        return  # a worker of xdist: it inherits the environment
    cache = getattr(config, "cache", None)
    if cache is None:  # -p no:cacheprovider
        folder = Path(tempfile.mkdtemp(prefix="arael-tests-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    else:
        folder = cache.mkdir("arael")
    os.environ.update(private_environment(folder))
    if config.option.markexpr == "not slow":
        # Half of what the C compiler takes. Together with the slow tests, kernels are optimised as
        # for users.
        os.environ.setdefault("CFLAGS", "-O0")
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        # A shell starts commands in the background so, and tests interrupt child processes.
        signal.signal(signal.SIGINT, signal.default_int_handler)
