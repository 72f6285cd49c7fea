"""Tasks of a developer: `nox -l` lists them, `nox -s fast` runs one, CONTRIBUTING.md explains.

Every session installs what it needs into an environment of its own below `.nox/`; `-R` uses it
again without installing, `--no-venv --no-install` uses the interpreter that runs nox.
"""

from __future__ import annotations

import sys
from pathlib import Path

import nox

nox.needs_version = ">=2024.10"
nox.options.default_venv_backend = "venv"
nox.options.reuse_existing_virtualenvs = True
nox.options.sessions = ["lint", "fast"]

PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
FAST = [
    "tests/syntax",
    "tests/check",
    "tests/diagnostics",
    "tests/manifolds",
    "tests/symbolic",
    "tests/sym",
    "tests/io",
    "tests/geometry",
]
"""Folders of tests that compile no kernels."""


def _install(session: nox.Session, *more: str) -> None:
    """Install arael for development, with other packages."""
    session.install("-e", ".[dev]", *more)


@nox.session
def setup(session: nox.Session) -> None:
    """Make `.venv` with arael, the tools and the hooks of git, for daily work."""
    python = Path(".venv", "Scripts" if sys.platform == "win32" else "bin", "python")
    session.run("python", "-m", "venv", ".venv")
    session.run(str(python), "-m", "pip", "install", "-q", "-e", ".[dev]", external=True)
    session.run(str(python), "-m", "pip", "install", "-q", "pre-commit", external=True)
    session.run(str(python), "-m", "pre_commit", "install", external=True)


@nox.session
def fast(session: nox.Session) -> None:
    """Tests of the language and of files, without compiled kernels; or those that are named."""
    _install(session)
    session.run("python", "-m", "pytest", *(session.posargs or FAST))


@nox.session
def tests(session: nox.Session) -> None:
    """The default suite: what the README's test command runs."""
    _install(session)
    session.run("python", "-m", "pytest", *session.posargs)


@nox.session(python=PYTHONS)
def versions(session: nox.Session) -> None:
    """The default suite on each supported Python that is installed."""
    _install(session)
    session.run("python", "-m", "pytest", *session.posargs)


@nox.session
def full(session: nox.Session) -> None:
    """Everything: slow tests, all optional parts, no skip permitted (needs SuiteSparse)."""
    drawings = ("ezdxf>=1.4", "build123d>=0.9")
    files = ("pyarrow>=14", "h5py>=3.10", *drawings)
    _install(session, "scikit-sparse<0.5", "numba", *files, "evo", "jax", "torch")
    session.run("python", "-m", "pytest", "-m", "", "--no-skips", *session.posargs)


@nox.session
def fuzz(session: nox.Session) -> None:
    """Tests that generate inputs, from a new seed, a minute each; or with options of pytest."""
    _install(session)
    options = session.posargs or ["--fuzz-seed", "random", "--fuzz-seconds", "60"]
    session.run("python", "-m", "pytest", "-m", "slow", "tests/fuzz", *options)


@nox.session
def lint(session: nox.Session) -> None:
    """Style, types and format, without a change to a file."""
    _install(session)
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")
    found = session.run("git", "ls-files", "*.pyx", "*.pxd", "*.pxi", external=True, silent=True)
    session.run("cython-lint", *str(found).split())


@nox.session
def format(session: nox.Session) -> None:
    """Format the Python files, and correct what ruff can."""
    session.install("ruff>=0.8")
    session.run("ruff", "check", "--fix", ".")
    session.run("ruff", "format", ".")


@nox.session
def docs(session: nox.Session) -> None:
    """The documentation as a site in `build/site`; each warning is an error."""
    _install(session)
    session.run("mkdocs", "build", "--strict", *session.posargs)


@nox.session
def sanitize(session: nox.Session) -> None:
    """Compiled code under the sanitizers: `-- short`, `-- thread`, or tests (Linux, gcc)."""
    _install(session)
    session.run(".ci/sanitize", *(session.posargs or ["short"]), external=True)


@nox.session
def golden(session: nox.Session) -> None:
    """Write golden files and expected texts anew; read `git diff` afterwards."""
    _install(session)
    session.run("python", "-m", "pytest", "--update", *session.posargs, success_codes=[0, 1])
    session.run("git", "diff", "--stat", external=True)


@nox.session
def benchmarks(session: nox.Session) -> None:
    """Measurements: `-- slam --quick`, for example; see benchmarks/README.md."""
    _install(session)
    session.run("python", "-m", "benchmarks", *session.posargs)
