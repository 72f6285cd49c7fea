"""Options and profiles of the whole test suite.

Each helper that needs hooks of pytest is a plugin module of its own: `tests.isolation` keeps the
tests away from the user's files, `tests.no_skips` forbids skips, `tests.sweeps` shortens sweeps.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

pytest_plugins = ["pytester", "tests.isolation", "tests.no_skips", "tests.sweeps"]

settings.register_profile(
    "arael",
    derandomize=True,
    deadline=None,
    max_examples=100,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "drawn", settings.get_profile("arael"), derandomize=False, print_blob=True
)
settings.register_profile("quick", settings.get_profile("arael"), max_examples=30)
settings.load_profile("arael")

DEFAULT_SEED = 0


def _seed(text: str) -> int:
    """Return the seed that `--fuzz-seed` asks for."""
    return random.SystemRandom().randrange(1, 2**31) if text == "random" else int(text)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update",
        action="store_true",
        help="write what comes out now into golden files and the ```text blocks of Markdown cases",
    )
    parser.addoption(
        "--fuzz-seed",
        type=_seed,
        default=DEFAULT_SEED,
        metavar="N",
        help="seed of generated inputs, those of hypothesis included; `random` draws one and "
        "prints it (default: %(default)s, and the fixed inputs of hypothesis)",
    )
    parser.addoption(
        "--fuzz-seconds",
        type=float,
        default=5.0,
        metavar="S",
        help="time that one fuzz test may take (default: %(default)s)",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    if config.getoption("--update"):
        # Several tests share a golden file: one process writes it.
        config.option.numprocesses = 0


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    if config.option.markexpr == "not slow" and config.option.hypothesis_profile is None:
        config.option.hypothesis_profile = "quick"
    # xdist hands the options, after this hook, to its workers: all draw from the same seed.
    seed = config.getoption("--fuzz-seed")
    if seed != DEFAULT_SEED and config.option.hypothesis_profile is None:
        config.option.hypothesis_profile = "drawn"
        if config.option.hypothesis_seed is None:
            config.option.hypothesis_seed = str(seed)


def _seed_line(config: pytest.Config) -> str:
    seed = config.getoption("--fuzz-seed")
    seconds = config.getoption("--fuzz-seconds")
    return f"fuzz seed {seed}: repeat with --fuzz-seed {seed} --fuzz-seconds {seconds:g}"


@pytest.hookimpl(trylast=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    # At once, for runs that are killed; `-q` hides the header of `pytest_report_header`.
    terminal = session.config.pluginmanager.get_plugin("terminalreporter")
    if terminal is not None and session.config.getoption("--fuzz-seed") != DEFAULT_SEED:
        terminal.write_line(_seed_line(session.config))


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    if config.getoption("--fuzz-seed") != DEFAULT_SEED:
        terminalreporter.write_line(_seed_line(config))


@pytest.fixture
def update(request: pytest.FixtureRequest) -> bool:
    """Whether expected outputs are to be rewritten."""
    return bool(request.config.getoption("--update"))


@pytest.fixture
def fuzz_seed(request: pytest.FixtureRequest) -> int:
    """Seed of a test that generates its inputs: fixed, unless `--fuzz-seed` changes it."""
    return int(request.config.getoption("--fuzz-seed"))


@pytest.fixture
def fuzz_budget(request: pytest.FixtureRequest) -> float:
    """Seconds after which a fuzz test ends its loop: `--fuzz-seconds`."""
    return float(request.config.getoption("--fuzz-seconds"))


@pytest.fixture
def fuzz_failures(request: pytest.FixtureRequest) -> Path:
    """Folder, kept after the run, into which a fuzz test writes an input that fails."""
    folder = request.config.rootpath / ".fuzz-failures"
    folder.mkdir(exist_ok=True)
    return folder
