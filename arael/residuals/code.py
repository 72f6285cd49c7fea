"""Residuals evaluated by a function of the caller, as `Model.add_residuals` adds them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.residuals import code_arguments
from arael.residuals.code_arguments import Argument
from arael.residuals.code_native import NativeCode, native_code
from arael.residuals.messages import error, label_problem

Array = NDArray[Any]
Floats = NDArray[np.float64]
Coordinates = Literal["tangent", "ambient"]

LARGEST = 4096
"""Most entries of the Jacobian of one instance."""


class CodeOwner(Protocol):
    """The residuals of a model."""

    def _cost_of(self, label: str) -> float:
        """Cost of a residual at the current values."""

    def _residuals_of(self, label: str) -> Array:
        """Residuals of all instances, (n, size)."""


class CodeResidual:
    """Residuals by own code, for all instances at once. See `Model.add_residuals`.

    Attributes
    ----------
    label : its name in cost tables, reports and messages
    function, jacobian : what is called
    size : residuals of an instance
    coordinates : of the Jacobians
    loss : text of the robust loss, or None
    kind : ``"cost"``; ``"equal"`` or ``"at_least"`` for what is zero, or not negative, at a
        solution
    derivatives : ``"given"`` or ``"differences"``; ``"unknown"`` before the first evaluation
    """

    def __init__(
        self,
        model: Any,
        function: Any,
        parameters: Any,
        size: int,
        data: Mapping[str, Any] | None,
        jacobian: Callable[..., Any] | bool | None,
        coordinates: str,
        loss: str | None,
        label: str,
        kind: str = "cost",
    ) -> None:
        problem = label_problem(label)
        if problem:
            raise error("E0770", f"{label!r:.60} cannot be a name: {problem}", "add_residuals")
        self.label = label
        self.native: NativeCode | None = native_code(function, label)
        if self.native is None and not callable(function):
            raise error(
                "E0770",
                f"expected a function, found {type(function).__name__}",
                label,
                "give a function of the parameters' values that returns residuals",
            )
        if jacobian is not None and not isinstance(jacobian, bool) and not callable(jacobian):
            raise error(
                "E0770", f"`jacobian` is a function, found {type(jacobian).__name__}", label
            )
        if isinstance(jacobian, bool) and jacobian and self.native is None:
            raise error(
                "E0770",
                "`jacobian=True` is for C functions",
                label,
                "return `(residuals, jacobians)`, or give a second function as `jacobian`",
            )
        if self.native is not None and callable(jacobian):
            raise error("E0770", "a C function writes its Jacobians itself", label)
        if isinstance(size, bool) or not isinstance(size, int | np.integer) or size < 1:
            raise error("E0770", f"`size` is a whole number above 0, found {size!r:.40}", label)
        if coordinates not in ("tangent", "ambient"):
            raise error(
                "E0770",
                f"`coordinates` is 'tangent' or 'ambient', found {coordinates!r:.40}",
                label,
            )
        if loss is not None and not isinstance(loss, str):
            raise error("E0770", f"a loss is text, found {type(loss).__name__}", label)
        if kind not in ("cost", "equal", "at_least"):
            raise error(
                "E0770", f"`kind` is 'cost', 'equal' or 'at_least', found {kind!r:.40}", label
            )
        if kind != "cost" and loss is not None:
            raise error("E0770", "what must hold takes no loss", label, "leave `loss` out")
        self.kind = kind
        self.function, self.jacobian = function, jacobian
        self.size, self.coordinates, self.loss = int(size), coordinates, loss
        self.arguments: tuple[Argument, ...] = code_arguments.arguments(model, parameters, label)
        if not self.arguments:
            raise error(
                "E0770",
                "the residuals have no parameters",
                label,
                "name what they depend on: `parameters=[model.poses.pos]`",
            )
        self._data = code_arguments.columns(data, label)
        self.count = code_arguments.count(self.arguments, self._data, label)
        self.derivatives = "unknown"
        self._owner: CodeOwner | None = None

    @property
    def keys(self) -> list[tuple[str, str, int]]:
        """Table, column and handle of the first row of each parameter; -1 for one of the root."""
        return [
            (a.table, a.column, -1 if a.refs is None else int(a.refs._handles[0]))
            for a in self.arguments
        ]

    @property
    def data(self) -> Mapping[str, Array]:
        """Data columns by name; `set_data` changes them."""
        return dict(self._data)

    def set_data(self, **given: Any) -> None:
        """Replace data columns by others of as many rows.

        May be called by a function that `Model.before_linearisation` calls.

        Raises
        ------
        AraelError
            E0770: no such column, no numbers, or another number of rows. Nothing is changed then.
        """
        found = dict(self._data)
        for name, value in given.items():
            if name not in self._data:
                raise error(
                    "E0770",
                    f"there is no data column `{name}`",
                    self.label,
                    f"it has {', '.join(self._data) or 'none'}",
                )
            found[name] = code_arguments.column(name, value, self.label)
        if code_arguments.count(self.arguments, found, self.label) != self.count:
            raise error(
                "E0770",
                f"the data has another number of rows than the {self.count} instances",
                self.label,
                "remove the residuals, and add them again",
            )
        self._data = found

    @property
    def cost(self) -> float:
        """Sum of its squared residuals at the current values."""
        return self._required()._cost_of(self.label)

    @property
    def residuals(self) -> Array:
        """Its residuals at the current values, after the loss, (n, size)."""
        return self._required()._residuals_of(self.label)

    def _required(self) -> CodeOwner:
        if self._owner is None:
            raise error("E0763", f"residual `{self.label}` is not in a model", self.label)
        return self._owner

    def __repr__(self) -> str:
        names = ", ".join(one.name for one in self.arguments)
        return f"<{self.label}: {self.count} x {self.size} residuals by own code of {names}>"


class CodeUpdate:
    """A function that is called before each linearisation. See `Model.before_linearisation`."""

    def __init__(self, model: Any, function: Any, parameters: Any, label: str) -> None:
        problem = label_problem(label)
        if problem:
            raise error(
                "E0770", f"{label!r:.60} cannot be a name: {problem}", "before_linearisation"
            )
        if not callable(function):
            raise error("E0770", f"expected a function, found {type(function).__name__}", label)
        self.label, self.function = label, function
        self.arguments = code_arguments.arguments(model, parameters, label)

    def __repr__(self) -> str:
        return f"<{self.label}: called before each linearisation>"


def named(function: Any, name: str | None, residuals: Any) -> str:
    """The name that was given, that of the function, or a free one."""
    if name is not None:
        return name
    own = getattr(function, "__name__", "")
    found: str = own if not label_problem(own) else residuals._free_label()
    return found
