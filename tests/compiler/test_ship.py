"""Models compiled ahead of use, and what building arael itself needs."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

import arael.runtime
from arael.compiler import build, ship
from arael.loading import standard_models

ROOT = Path(__file__).resolve().parents[2]
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")


def needs_compiler() -> None:
    if build.find_compiler() is None:
        pytest.skip("needs a C compiler: apt install gcc python3-dev")


def test_cython_runs_once_for_all_targets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs_compiler()
    runs: list[Path] = []
    whole = build.cython_to_c

    def counted(pyx: Path) -> Path:
        runs.append(pyx)
        return whole(pyx)

    monkeypatch.setattr(build, "cython_to_c", counted)
    targets = ["baseline", "native"]
    made = ship.ship([standard_models()["linear"]], tmp_path, targets)
    assert [folder.name for folder in made] == [f"linear-{target}" for target in targets]
    assert len(runs) == 1
    for folder in made:
        (module,) = folder.glob(f"*{SUFFIX}")
        assert (folder / f"{module.name.partition('.')[0]}.pyx").is_file()
    assert not list(tmp_path.rglob("*.c"))


def test_a_wrong_model_ends_the_build_with_its_messages(tmp_path: Path) -> None:
    (tmp_path / "wrong.arael").write_text("root Wrong { param a: reel = 0 }\n", encoding="utf-8")
    command = [sys.executable, "-m", "arael.compiler.ship", str(tmp_path), str(tmp_path / "made")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 1
    assert "`real`" in done.stderr and "wrong.arael:1" in done.stderr
    assert "Traceback" not in done.stderr


IMPORTED = """\
import json, sys
from pathlib import Path
from arael.compiler import build, ship
build.compile_c = lambda c_file, target: c_file.with_suffix(".so").touch()  # takes longest
ship.ship([Path(sys.argv[1])], Path(sys.argv[2]))
from arael.syntax import tables
tables.generate(tables.grammar_text())  # where the grammar was edited
import setuptools, Cython.Build
files = [str(getattr(module, "__file__", "")) for module in sys.modules.values()]
found = {Path(f.partition("site-packages/")[2]).parts[:1] for f in files}
print(json.dumps(sorted(first[0].lower() for first in found if first)))
"""
# Belong to setuptools or to SymPy, or are imported by others where they happen to be there.
BROUGHT = {"_distutils_hack", "mpmath", "packaging", "typing_extensions.py", "cython.py"}


@pytest.mark.slow
def test_the_build_system_has_what_a_build_imports(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORTED, str(standard_models()["linear"]), str(tmp_path / "made")],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env={"PATH": "", "HOME": str(tmp_path)},
    )
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    required = {re.split(r"[<>=]", r)[0] for r in project["build-system"]["requires"]}
    # What an editable installation puts before the package is no requirement.
    imported = {name for name in json.loads(done.stdout) if not name.startswith("__editable_")}
    assert {"lark", "cython"} <= imported  # else nothing was looked at
    assert imported - BROUGHT == required


def test_one_module_holds_the_code_of_memoryviews() -> None:
    folder = Path(arael.runtime.__file__).parent
    modules = sorted(folder.rglob(f"*{SUFFIX}"))
    holding = [m.name.partition(".")[0] for m in modules if b"View.MemoryView" in m.read_bytes()]
    assert len(modules) > 10
    assert holding == ["_cyutility"]
