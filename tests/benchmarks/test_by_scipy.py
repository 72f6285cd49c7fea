"""Examples beside SciPy: both programs are counted and end at one cost."""

from __future__ import annotations

import importlib
from functools import partial
from types import ModuleType

import pytest

import arael
from benchmarks.by_scipy import EXAMPLES, __main__


def module_of(name: str) -> ModuleType:
    return importlib.import_module(f"benchmarks.by_scipy.{name}")


@pytest.mark.parametrize("name", __main__.NAMES)
def test_each_belongs_to_an_example(name: str) -> None:
    module = module_of(name)
    assert (EXAMPLES / module.MODEL).is_file()
    assert (EXAMPLES / name / f"{name}.py").is_file()
    assert 10 < __main__.lines_of_model(module) < 60
    assert 10 < __main__.lines_of_program(module) < 60


def test_a_row_of_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))
    monkeypatch.setattr(__main__, "least", lambda work, runs: (work(), 0.001)[1])
    cells = [cell.strip() for cell in __main__.measured("hand_eye").strip("| ").split("|")]
    assert cells[0] == "hand_eye"
    assert float(cells[-2]) == pytest.approx(float(cells[-1]), rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("name", __main__.NAMES)
def test_compiled_models_end_where_scipy_does(name: str) -> None:
    module = module_of(name)
    given = module.data()
    assert module.by_arael(given) == pytest.approx(module.by_scipy(given), rel=1e-5)
