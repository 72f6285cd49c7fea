"""The solvers that the command line offers are those there are."""

from __future__ import annotations

import pytest

from arael.cli.options import SOLVERS
from arael.runtime.linear.auto import SOLVERS as KNOWN
from tests.cli.conftest import Arael
from tests.optional import solvers


def test_list_is_complete() -> None:
    assert set(SOLVERS) == {"auto", *KNOWN}


@pytest.mark.parametrize("solver", solvers(SOLVERS))
def test_solver_solves(arael: Arael, solver: str) -> None:
    done = arael("demo", "localization", "--poses", "8", "--solver", solver, "--json")
    assert done.code == 0, done.out
    if solver != "auto":
        assert done.json["plan"]["solver"] == solver
