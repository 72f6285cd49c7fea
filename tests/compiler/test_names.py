"""Any name that a file can have is the name of a model that can be compiled and solved."""

from __future__ import annotations

import keyword
import os
import sys
from pathlib import Path

import pytest

import arael
from arael.cli.main import run
from arael.compiler.kernels import module_name
from arael.loading import load_compiled

# A different formula each, as kernels are found by what they compute.
TEXT = "root R : f64 {{ param a: real; constraint c {{ a - {goal}.0 }} }}\n"

NAMES = [
    "my-model",
    "fit (copy)",
    "fit.v2",
    "größe ä π",
    "2d",
    "int",
    "class",
    'it\'s "quoted" $x;`y`',
    "m" * 240,
]
if sys.platform == "linux":
    NAMES.append(os.fsdecode(b"m\xe4"))  # a name in Latin-1


@pytest.mark.sweep(4)
@pytest.mark.parametrize("name", NAMES, ids=[ascii(name[:20]) for name in NAMES])
def test_model_of_that_name_compiles_and_solves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("CFLAGS", "-O0")
    goal = 2 + NAMES.index(name)
    path = tmp_path / f"{name}.arael"
    path.write_text(TEXT.format(goal=goal))
    for origin in ("compiled", "cache"):
        found = load_compiled(path, interpret=False)
        assert (found.origin, found.layout.name) == (origin, name)
    model = arael.load(path, interpret=False)(a=0.0)
    model.solve()
    assert model.a.value == pytest.approx(goal)


@pytest.mark.parametrize("name", [*NAMES, "", "-", "\udce4", "__init__", "a/b"])
def test_names_of_modules_are_plain(name: str) -> None:
    found = module_name(name, "0123456789")
    assert found.isidentifier() and found.isascii() and not keyword.iskeyword(found)
    assert found.endswith("_01234567")
    assert len(found) < 64


@pytest.mark.parametrize("stage", ["pyx", "c"])
def test_source_of_that_name_is_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], stage: str
) -> None:
    path = tmp_path / "my-model (1).v2.arael"
    path.write_text(TEXT.format(goal=2))
    assert run(["emit", str(path), "--stage", stage]) == 0
    assert "cost_0" in capsys.readouterr().out
