"""A solve as a function of data, with its derivative by implicit differentiation."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.solution import Solution

Floats = NDArray[np.float64]


class SolveLayer:
    """The solved values of a formula as a function of columns of data.

    Each call solves a copy of the model from its present values, so that it depends on nothing
    but its arguments. The last few solves are kept for the derivatives that follow them.

    Parameters
    ----------
    model : an instance with all its data; it stays as it is
    data : paths of columns (``"points.y"``), which the arguments replace
    of : a formula over the model, ``"[v, k]"``, or several
    exact : whether derivatives have all terms (True), or those of Gauss-Newton
    kept : number of solves that are kept
    **settings : of `arael.Model.solve`

    Raises
    ------
    AraelError
        E0828, E1060: no such column. Later, what a solve raises.
    """

    def __init__(
        self,
        model: Any,
        data: str | Iterable[str],
        of: str | Iterable[str],
        *,
        exact: bool = True,
        kept: int = 128,
        **settings: Any,
    ) -> None:
        self._model = model.copy()
        self.data = _texts(data, "data", "paths of columns")
        formulas = _texts(of, "of", "a formula, or several")
        self.of = formulas[0] if len(formulas) == 1 else f"[{', '.join(formulas)}]"
        self._exact, self._settings, self._kept = bool(exact), settings, kept
        self._columns = [self._column(path) for path in self.data]
        self.shapes = [self._shape(*one) for one in self._columns]
        self._solved: OrderedDict[bytes, tuple[Floats, Solution]] = OrderedDict()
        self.size = len(Solution(self._model).values(self.of))

    def values(self, arrays: Sequence[Any]) -> Floats:
        """(size,) the formula at the solution for these data."""
        return self._at(arrays)[0]

    def pullback(self, arrays: Sequence[Any], weights: Any) -> list[Floats]:
        """Derivatives of ``weights @ values`` by each of the arrays.

        Parameters
        ----------
        weights : (size,)
        """
        _, solution = self._at(arrays)
        quantity = solution.weighted(self.of, np.asarray(weights, dtype=np.float64).ravel())
        found = solution.sensitivities().of(quantity, self.data, self._exact)
        return [found[path].reshape(s) for path, s in zip(self.data, self.shapes, strict=True)]

    def batch(self, arrays: Sequence[Any]) -> tuple[tuple[int, ...], list[list[Floats]]]:
        """Axes in front that all arrays share, and the arguments of each solve."""
        front = {
            np.shape(one)[: np.ndim(one) - len(shape)]
            for one, shape in zip(arrays, self.shapes, strict=True)
        }
        if len(front) != 1:
            raise self._misshapen([np.shape(one) for one in arrays])
        axes: tuple[int, ...] = front.pop()
        flat = [
            np.asarray(one, dtype=np.float64).reshape(-1, *shape)
            for one, shape in zip(arrays, self.shapes, strict=True)
        ]
        return axes, [[one[k] for one in flat] for k in range(len(flat[0]))]

    def _at(self, arrays: Sequence[Any]) -> tuple[Floats, Solution]:
        given = [np.array(one, dtype=np.float64, order="C") for one in arrays]
        if [one.shape for one in given] != self.shapes:
            raise self._misshapen([one.shape for one in given])
        key = b"".join(one.tobytes() for one in given)
        if key not in self._solved:
            model = self._model.copy()
            for (table, column), value in zip(self._columns, given, strict=True):
                rows: Any = slice(None) if table else 0
                path = f"{table}.{column}" if table else column
                model._store.tables[table].set_values(column, rows, value, path)
            result = model.solve(**self._settings)
            solution = Solution(model, result.frozen)
            self._solved[key] = solution.values(self.of), solution
            if len(self._solved) > self._kept:
                self._solved.popitem(last=False)
        self._solved.move_to_end(key)
        return self._solved[key]

    def _column(self, path: str) -> tuple[str, str]:
        layout = self._model._compiled.layout
        columns = {
            f"{table.path}.{column.path}" if table.path else column.path: (table.path, column.path)
            for table in layout.tables
            for column in table.columns
            if column.role == "data" and column.kind == "real"
        }
        if path not in columns:
            near = closest(path, list(columns))
            help_ = f"did you mean `{near[0]}`?" if near else f"there are {', '.join(columns)}"
            raise AraelError(
                Diagnostic(
                    "E1060",
                    f"there is no data column `{path:.60}` of real numbers",
                    origin="layer",
                    help=(help_,),
                )
            )
        return columns[path]

    def _shape(self, table: str, column: str) -> tuple[int, ...]:
        found: tuple[int, ...] = np.shape(self._model._store.tables[table].column(column))
        return found if table else found[1:]

    def _misshapen(self, found: list[tuple[int, ...]]) -> AraelError:
        expected = ", ".join(
            f"{path} {shape}" for path, shape in zip(self.data, self.shapes, strict=True)
        )
        return AraelError(
            Diagnostic(
                "E1060",
                f"the data have shapes {', '.join(map(str, found))}",
                origin="layer",
                help=(f"expected {expected}, with the same axes of a batch in front of all",),
            )
        )


def _texts(given: str | Iterable[str], name: str, expected: str) -> list[str]:
    if isinstance(given, str):
        return [given]
    found = list(given) if isinstance(given, Iterable) else []
    if not found or not all(isinstance(one, str) for one in found):
        raise wrong_argument("layer", name, expected, given)
    return found
