"""The Rust framework as its published crate, by the project under `rust`.

Its residuals are those of the models, its solver is its default (`solve_sparse`: elimination of
landmarks or points, narrow bands, or block supernodal Cholesky, as it decides), its code is
compiled for this processor.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

from benchmarks.peers import endings, native
from benchmarks.peers.runner import AbsentError, request, show

PROJECT = native.HERE / "rust"
SUITES = ("slam", "localization", "pose_graph", "bundle", "plane")


def program() -> Path:
    """Build the project where that is not yet done."""
    return built(PROJECT, "rust", "peer")


def built(project: Path, name: str, binary: str) -> Path:
    """The program of a Rust project, built where that is not yet done."""
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo")) / "bin" / "cargo"
    cargo = shutil.which("cargo") or (str(home) if home.exists() else None)
    if cargo is None:
        raise AbsentError("cargo is not installed")
    target = native.BUILD / name
    native.build(
        [cargo, "build", "--release", "--locked", "--manifest-path", str(project / "Cargo.toml")],
        native.BUILD / f"{name}.log",
        CARGO_TARGET_DIR=str(target),
        RUSTFLAGS="-C target-cpu=native",
    )
    return target / "release" / binary


def version() -> str:
    """Version of the crate that is locked."""
    return f"Rust framework {locked(PROJECT, 'arael')}".strip()


def locked(project: Path, crate: str) -> str:
    """Version of a crate in a project's lock file."""
    lock = (project / "Cargo.lock").read_text(encoding="utf-8")
    found = re.search(rf'name = "{crate}"\nversion = "([^"]+)"', lock)
    return found.group(1) if found else ""


def ways() -> dict[str, str]:
    """Ways to the end, with the settings of each."""
    return {name: f"LmConfig::{name}" for name in ("conservative", "ill_conditioned")}


def main() -> None:
    """Do what the command line asks for."""
    to_the_end = sys.argv[1] == endings.WORD
    suite = sys.argv[2 if to_the_end else 1]
    try:
        if suite not in SUITES:
            raise AbsentError(f"no {suite} in the Rust project")
        if to_the_end:
            native.run_to_the_end(program(), ways(), version())
        else:
            native.run(program(), request(), version())
    except AbsentError as reason:
        show({"absent": str(reason)})


if __name__ == "__main__":
    main()
