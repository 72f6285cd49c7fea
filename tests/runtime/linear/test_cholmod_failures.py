"""What scikit-sparse raises ends a solve; that a matrix is not positive definite does not."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import pytest

import arael
from arael.runtime.linear.auto import make_solver
from tests.runtime.linear.block_matrices import chain, positive


class NotPositiveDefiniteError(Exception):
    """That of scikit-sparse."""


class Stub:
    """The interface of scikit-sparse 0.5, which raises what it is made to raise."""

    raises: ClassVar[dict[str, list[BaseException]]] = {}

    def __init__(self, matrix: Any, **options: Any) -> None:
        self.order = np.arange(matrix.shape[0])

    def get_perm(self) -> np.ndarray:
        return self.order

    def factorize(self, matrix: Any, **options: Any) -> None:
        full = matrix.toarray()
        self.matrix = full + np.tril(full, -1).T
        self.do("factorize")

    def solve(self, b: np.ndarray) -> np.ndarray:
        self.do("solve")
        return np.linalg.solve(self.matrix, b)

    def do(self, what: str) -> None:
        if self.raises.get(what):
            error = self.raises[what].pop(0)
            if error is not None:
                raise error


@pytest.fixture
def raises(monkeypatch: pytest.MonkeyPatch) -> dict[str, list[Any]]:
    """What the stub raises in each of its calls to come."""
    module = ModuleType("sksparse.cholmod")
    module.CholeskyFactor = Stub  # type: ignore[attr-defined]
    module.CholmodNotPositiveDefiniteError = NotPositiveDefiniteError  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", module)
    monkeypatch.setattr(Stub, "raises", {})
    return Stub.raises


@pytest.fixture
def line(tmp_path: Path) -> Any:
    path = tmp_path / "line.arael"
    path.write_text(
        "struct Point {\n    param x: real\n    constraint near { [x * x - 2, x - 3] }\n}\n"
        "root Line {\n    points: list of Point\n}\n",
        encoding="utf-8",
    )
    model = arael.load(path, interpret=True)()
    model.points.extend(x=[1.0, 2.0, 3.0])
    return model


@pytest.mark.parametrize("what", ["factorize", "solve"])
@pytest.mark.parametrize("failure", [RuntimeError("out of order"), MemoryError("too large")])
def test_an_exception_ends_the_solve_and_names_the_solver(
    raises: dict[str, list[Any]], line: Any, what: str, failure: Exception
) -> None:
    raises[what] = [None, failure]
    before = line.points.x.value.copy()
    with pytest.raises(type(failure), match=str(failure)) as caught:
        line.solve(solver="cholmod")
    assert "linear solver 'cholmod'" in caught.value.__notes__[0]
    assert np.array_equal(line.points.x.value, before)
    assert line.solve(solver="cholmod").status == "converged"


@pytest.mark.parametrize("what", ["factorize", "solve"])
def test_ctrl_c_within_it_ends_the_solve_with_the_best_state(
    raises: dict[str, list[Any]], line: Any, what: str
) -> None:
    raises[what] = [None, KeyboardInterrupt()]
    start = line.cost()
    result = line.solve(solver="cholmod")
    assert result.status == "aborted"
    assert result.end_cost < start
    assert line.cost() == result.end_cost


def test_a_matrix_that_is_not_positive_definite_is_a_rejection(
    raises: dict[str, list[Any]], line: Any
) -> None:
    raises["factorize"] = [NotPositiveDefiniteError("column 1")]
    result = line.solve(solver="cholmod")
    assert result.status == "converged"
    assert result.history["factored"].tolist()[:2] == [0, 1]
    assert result.history["pivot"][0] == 1


def test_from_python_it_raises_too(raises: dict[str, list[Any]]) -> None:
    pattern = chain(4, 2)
    solver = make_solver("cholmod", pattern)
    raises["factorize"] = [RuntimeError("first"), None, RuntimeError("third")]
    raises["solve"] = [RuntimeError("second"), None]
    values, diagonal = positive(pattern, 0)
    with pytest.raises(RuntimeError, match="first"):
        solver.factorise(values, diagonal)
    assert solver.factorise(values, diagonal) == 0
    with pytest.raises(RuntimeError, match="second"):
        solver.solved(np.ones(8))
    assert np.isfinite(solver.solved(np.ones(8))).all()
    with pytest.raises(RuntimeError, match="third"):
        solver.step(values, diagonal, np.ones(8))
