"""Models compiled ahead of use, and what building arael itself needs."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
import tomllib
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import pytest

import arael.runtime
from arael import loading
from arael.compiled_model import InterpretedWarning
from arael.compiler import build, processor, ship
from arael.loading import standard_models

ROOT = Path(__file__).resolve().parents[2]
LINEAR = standard_models()["linear"]
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


def test_a_package_of_the_runtime_has_one_module() -> None:
    """Each module costs each build of arael most of a second before its first line."""
    folder = Path(arael.runtime.__file__).parent
    of = Counter(path.parent for path in folder.rglob("*.pyx"))
    assert sum(of.values()) <= 15
    assert all(path.with_suffix(".pyi").is_file() for path in folder.rglob("*.pyx"))


FLAGS = {
    "x86-64-v4": frozenset().union(*processor.LEVELS.values()),
    "x86-64-v3": frozenset(processor.LEVELS["x86-64-v3"]),
}


@pytest.mark.parametrize("best", FLAGS)
def test_a_build_is_for_this_machine_and_a_portable_one_for_all(
    best: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processor.platform, "system", lambda: "Linux")
    monkeypatch.setattr(processor.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(processor, "flags", lambda: FLAGS[best])
    monkeypatch.delenv("ARAEL_PORTABLE", raising=False)
    assert processor.built_targets() == [best]
    monkeypatch.setenv("ARAEL_PORTABLE", "1")
    assert processor.built_targets() == ["x86-64-v4", "x86-64-v3"]
    monkeypatch.delenv("ARAEL_PORTABLE")
    monkeypatch.setattr(processor, "flags", frozenset)
    assert processor.built_targets() == []


@pytest.mark.parametrize("portable", ["0", "1"])
def test_sketches_are_compiled_when_first_used_but_for_a_wheel(
    portable: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "models"
    source.mkdir()
    for name in ("linear", "sketch"):
        (source / f"{name}.arael").write_bytes(standard_models()[name].read_bytes())
    compiled: list[str] = []

    def noted(models: Iterable[Path], folder: Path, targets: Sequence[str]) -> None:
        compiled.extend(path.stem for path in models)
        assert targets == processor.built_targets()

    monkeypatch.setattr(ship, "ship", noted)
    monkeypatch.setenv("ARAEL_PORTABLE", portable)
    made = tmp_path / "made"
    made.mkdir()
    ship.main(str(source), str(made))
    assert compiled == (["linear", "sketch"] if portable == "1" else ["linear"])
    assert (made / "sketch.arael").is_file() == (portable == "0")  # else `ship` has copied it


def test_kernels_for_another_machine_are_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wheel that was built on a machine with more instructions than this one has."""
    shipped = tmp_path / "models" / "linear-x86-64-v4"
    shipped.mkdir(parents=True)
    (shipped / "manifest.json").write_text("not read on this machine")
    monkeypatch.setattr(loading, "__file__", str(tmp_path / "loading.py"))
    monkeypatch.setattr(loading, "standard_models", lambda: {"linear": LINEAR})
    monkeypatch.setattr(processor.platform, "system", lambda: "Linux")
    monkeypatch.setattr(processor.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(processor, "flags", lambda: FLAGS["x86-64-v3"])
    monkeypatch.setattr(build, "find_compiler", lambda: None)
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))  # others compile this model too
    with pytest.warns(InterpretedWarning, match="running on the expression machine"):
        found = loading.load_compiled("linear")
    assert (found.origin, found.kernels) == ("interpreted", None)
