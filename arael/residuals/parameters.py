"""Parameters of a runtime residual: reals and vectors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.residuals.messages import error, name_problem
from arael.residuals.plain_table import PlainTable
from arael.runtime.layout import Column, Param

Array = NDArray[Any]

KEYS = ("value", "low", "high", "fixed")


class Parameters(Mapping[str, Any]):
    """Values of parameters by name; an assignment sets the start of the next solve.

    Parameters
    ----------
    given : start values by name: a number, a list of numbers for a vector, or a dict with ``value``
        and any of ``low``, ``high`` (bounds, one number for all components) and ``fixed``
    label : name of the residual, for messages
    """

    def __init__(self, given: Mapping[str, Any], label: str) -> None:
        self._label = label
        self._columns: dict[str, Column] = {}
        self._values: dict[str, Array] = {}
        self._fixed: dict[str, bool] = {}
        self._values_version = self._flags_version = 0
        for name, spec in given.items():
            problem = name_problem(name)
            if problem:
                raise error("E0760", f"`{name}` cannot name a parameter: {problem}", label)
            self._declare(name, dict(spec) if isinstance(spec, Mapping) else {"value": spec})

    def _declare(self, name: str, spec: dict[str, Any]) -> None:
        where = f"{self._label}: {name}"
        for key in spec:
            if key not in KEYS:
                raise error(
                    "E0761", f"a parameter has no `{key}`", where, f"it has {', '.join(KEYS)}"
                )
        if "value" not in spec:
            raise error("E0761", "the parameter has no start value", where, "give it a `value`")
        value = self._numbers(name, spec["value"])
        n = value.size
        low, high = (self._bound(name, key, spec.get(key)) for key in ("low", "high"))
        if low is not None and high is not None and low > high:
            raise error("E0761", f"the bounds {low:g} .. {high:g} are empty", where)
        bounded = low is not None or high is not None
        self._columns[name] = Column(
            path=name,
            kind="real",
            shape=value.shape,
            role="param",
            type="real" if value.ndim == 0 else f"vec<{n}>",
            where=self._label,
            param=Param(
                "real" if value.ndim == 0 else "vec",
                n,
                n,
                (low,) * n if bounded else (),
                (high,) * n if bounded else (),
            ),
        )
        self._values[name] = value.reshape(1, *value.shape).copy()
        self._fixed[name] = bool(spec.get("fixed", False))

    def _numbers(self, name: str, value: Any) -> Array:
        where = f"{self._label}: {name}"
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise error(
                "E0761", f"expected a number or a list of numbers, found {value!r:.60}", where
            ) from None
        if array.ndim > 1 or not 1 <= array.size <= 64 or not np.isfinite(array).all():
            raise error("E0761", "a parameter is one finite number or a list of at most 64", where)
        return array

    def _bound(self, name: str, key: str, value: Any) -> float | None:
        if value is None:
            return None
        number = self._numbers(name, value)
        if number.ndim:
            raise error("E0761", f"`{key}` is one number", f"{self._label}: {name}")
        return float(number)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The parameters as columns of a table with one row."""
        return tuple(self._columns.values())

    def given(self) -> dict[str, dict[str, Any]]:
        """Current values, bounds and flags, in the form of the argument `given`."""
        arguments = {}
        for name, column in self._columns.items():
            param = column.param
            low = param.low[0] if param is not None and param.low else None
            high = param.high[0] if param is not None and param.high else None
            value = self._values[name][0].tolist()
            arguments[name] = {"value": value, "low": low, "high": high, "fixed": self._fixed[name]}
        return arguments

    def fix(self, *names: str) -> None:
        """Fix parameters in all later solves."""
        self._flag(names, True)

    def free(self, *names: str) -> None:
        """Free fixed parameters."""
        self._flag(names, False)

    def is_fixed(self, name: str) -> bool:
        """Whether the parameter is fixed."""
        return self._fixed[self._known(name)]

    def _flag(self, names: tuple[str, ...], value: bool) -> None:
        for name in names:
            self._fixed[self._known(name)] = value
        self._flags_version += 1

    def _known(self, name: str) -> str:
        if name not in self._columns:
            raise error(
                "E0760",
                f"it has no parameter `{name}`",
                self._label,
                f"it has {', '.join(self._columns) or 'none'}",
            )
        return name

    def __getitem__(self, name: str) -> Any:
        if name not in self._values:
            raise KeyError(name)
        value = self._values[name][0]
        return value.item() if value.ndim == 0 else value.copy()

    def __setitem__(self, name: str, value: Any) -> None:
        column = self._columns[self._known(name)]
        array = self._numbers(name, value)
        if array.shape != column.shape:
            raise error(
                "E0761",
                f"expected {column.type}, found shape {array.shape}",
                f"{self._label}: {name}",
            )
        self._values[name][0] = array
        self._values_version += 1

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<parameters {dict(self)}>"


class ParameterTable(PlainTable):
    """Parameters in the form of the solver: a table with one row."""

    structure_version = 0
    data_version = None

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    @property
    def values_version(self) -> int:
        """Counts assignments."""
        return self._parameters._values_version

    @property
    def flags_version(self) -> int:
        """Counts `fix` and `free`."""
        return self._parameters._flags_version

    def written(self) -> None:
        """Called when a solve has written values."""
        self._parameters._values_version += 1

    def column(self, path: str) -> Array:
        """Live values (1, *shape)."""
        return self._parameters._values[path]

    def free(self, path: str) -> Array:
        """Whether the parameter is free (1,)."""
        return np.array([not self._parameters.is_fixed(path)])

    def target_rows(self, path: str) -> Array:
        """There are no refs."""
        raise KeyError(path)

    def row_name(self, row: int) -> str:
        """Return an empty name: parameters have names of their own."""
        return ""

    def row_names(self, rows: Array) -> list[str]:
        """Return empty names."""
        return [""] * len(rows)


def parameter_table(label: str) -> str:
    """Path of the table of a residual's parameters."""
    return f"residuals/{label}"
