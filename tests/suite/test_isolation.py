"""Tests, and the processes that they start, leave the user's own files alone."""

from __future__ import annotations

import os
import pwd
import subprocess
import sys
from pathlib import Path

import pytest

from arael.compiler.cache import directory
from tests.isolation import FOLDERS

ROOT = Path(__file__).parents[2]

PRINTS = """
import arael.compiler.cache, platformdirs, pathlib
print(arael.compiler.cache.directory())
print(platformdirs.user_cache_path("arael"), platformdirs.user_config_path("arael"))
print(platformdirs.user_data_path("arael"), pathlib.Path.home())
"""


def users_home() -> Path:
    """Home of the user by the system's records, which no environment variable changes."""
    return Path(pwd.getpwuid(os.getuid()).pw_dir)


def test_no_folder_of_the_user_is_in_the_environment() -> None:
    for variable in FOLDERS:
        assert Path(os.environ[variable]) != users_home()
        assert Path(os.environ[variable]).is_dir()
    assert Path.home() == Path(os.environ["HOME"])
    assert directory() == Path(os.environ["ARAEL_CACHE_DIR"])


def test_child_processes_inherit_the_folders() -> None:
    done = subprocess.run(
        [sys.executable, "-c", PRINTS], capture_output=True, text=True, check=True
    )
    private = str(Path(os.environ["HOME"]).parent)
    assert all(path.startswith(private) for path in done.stdout.split())


SOLVES = """
import subprocess, sys
from pathlib import Path
from arael.cli.main import run

def test_solves(tmp_path):
    model, data = tmp_path / "one.arael", tmp_path / "one.json"
    model.write_text("root One { param a: real = 0\\n    constraint c { a - 1 } }\\n")
    data.write_text("{}")
    assert run(["solve", str(model), str(data)]) == 0
    command = [sys.executable, "-m", "arael", "calc"]
    assert subprocess.run(command, input="1 + 1\\n", text=True).returncode == 0
"""


@pytest.mark.sweep(2)
@pytest.mark.parametrize("option", ["cacheprovider", "nothing"])
def test_a_run_leaves_the_users_home_as_it_is(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    """With pytest's cache and without it."""
    home = pytester.path / "user"
    home.mkdir()
    for variable in FOLDERS:
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("CC", "no-such-compiler")  # the expression machine does
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    pytester.makeconftest('pytest_plugins = ["tests.isolation"]')
    pytester.makepyfile(SOLVES)
    result = pytester.runpytest_subprocess("-p", "no:xdist", "-p", f"no:{option}")
    result.assert_outcomes(passed=1)
    assert list(home.iterdir()) == []
    models = pytester.path / ".pytest_cache" / "d" / "arael" / "models"
    assert models.is_dir() == (option == "nothing")
