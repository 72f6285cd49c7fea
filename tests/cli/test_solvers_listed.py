"""The solvers that the command line offers are those there are."""

from __future__ import annotations

import pytest

from arael.cli.options import SOLVERS, STRATEGIES
from arael.config import LmConfig
from arael.diagnostics.records import AraelError
from arael.runtime.linear.auto import SOLVERS as KNOWN
from tests.cli.conftest import Arael
from tests.optional import solvers


def test_list_is_complete() -> None:
    assert set(SOLVERS) == {"auto", *KNOWN}


def test_strategies_are_those_of_the_settings() -> None:
    for strategy in STRATEGIES:
        LmConfig.of(strategy=strategy)
    with pytest.raises(AraelError, match=", ".join(f'"{name}"' for name in STRATEGIES)):
        LmConfig.of(strategy="other")


@pytest.mark.parametrize("solver", solvers(SOLVERS))
def test_solver_solves(arael: Arael, solver: str) -> None:
    done = arael("demo", "localization", "--poses", "8", "--solver", solver, "--json")
    assert done.code == 0, done.out
    if solver != "auto":
        assert done.json["plan"]["solver"] == solver
