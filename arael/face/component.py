"""One component of a vector or of Euler angles: ``pose.pos.z``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from arael.face.valued import Valued
from arael.runtime.store.messages import UnknownFieldError, describe, error, problem, shorten

if TYPE_CHECKING:
    from arael.face.parameter import Parameter


class Component(Valued):
    """Value, flags and bounds of one component, of one row (``pose.pos.z``) or of many.

    In arithmetic, NumPy functions, comparisons and formatting it stands for its value.

    Attributes
    ----------
    value : a number, or (N,); assignable like all others
    low, high : bounds, infinite where open; None sets no bound. For vectors only
    fixed : whether the data fixes it
    optimize : whether it is solved for, unless it is fixed
    """

    __slots__ = ("_index", "_parameter")

    def __init__(self, parameter: Parameter, index: int) -> None:
        self._parameter = parameter
        self._index = index

    @property
    def value(self) -> Any:
        """The value: a number, or (N,) as a live view."""
        part = self._parameter.value[..., self._index]
        return part if part.ndim else part.item()

    @value.setter
    def value(self, value: Any) -> None:
        self._parameter.value = self._with(self._parameter.value, value)

    @property
    def low(self) -> Any:
        """Lower bound: a number, or (N,) as a live view."""
        return self._read("low")

    @low.setter
    def low(self, value: Any) -> None:
        given = -np.inf if value is None else value
        self._parameter.low = self._with(self._parameter.low, given, ".low")

    @property
    def high(self) -> Any:
        """Upper bound: a number, or (N,) as a live view."""
        return self._read("high")

    @high.setter
    def high(self, value: Any) -> None:
        given = np.inf if value is None else value
        self._parameter.high = self._with(self._parameter.high, given, ".high")

    @property
    def fixed(self) -> Any:
        """Whether the data fixes it: bool, or (N,)."""
        return self._flag(self._parameter.fixed)

    @fixed.setter
    def fixed(self, value: Any) -> None:
        self._parameter.fixed = self._with(self._flags(self._parameter.fixed), value, ".fixed")

    @property
    def optimize(self) -> Any:
        """Whether it is solved for: bool, or (N,)."""
        return self._flag(self._parameter.optimize)

    @optimize.setter
    def optimize(self, value: Any) -> None:
        self._parameter.optimize = self._with(
            self._flags(self._parameter.optimize), value, ".optimize"
        )

    def _read(self, end: str) -> Any:
        part = getattr(self._parameter, end)[..., self._index]
        return part if part.ndim else part.item()

    def _with(self, whole: Any, value: Any, what: str = "") -> Any:
        """The values of all components with those of this one set; checked by the parameter."""
        found = np.array(whole)
        given, origin = np.asarray(value), f"{self._name}{what}"
        flags = found.dtype == np.bool_
        if given.dtype.kind not in ("b" if flags else "iuf"):
            wanted = "true or false" if flags else "numbers"
            raise error("E0703", f"expected {wanted}, found {describe(value)}", origin)
        if given.shape not in ((), found.shape[:-1]):
            rows = f", or {len(found)} of them" if found.ndim > 1 else ""
            raise error("E0704", f"expected one value{rows}, found shape {given.shape}", origin)
        found[..., self._index] = given
        return found

    @property
    def _name(self) -> str:
        return f"{self._parameter._name}.{'xyz'[self._index]}"

    def _flags(self, flags: Any) -> Any:
        """Flags with an axis of components."""
        array, shape = np.asarray(flags), np.shape(self._parameter.value)
        return np.array(np.broadcast_to(array if array.shape == shape else array[..., None], shape))

    def _flag(self, flags: Any) -> Any:
        part = self._flags(flags)[..., self._index]
        return part if part.ndim else bool(part)

    def __repr__(self) -> str:
        text = np.array2string(np.asarray(self.value), precision=6, threshold=12, edgeitems=2)
        return f"<{self._name}: {text}>"


def component(parameter: Parameter, name: str) -> Component:
    """The component of a parameter with that name.

    Raises
    ------
    UnknownFieldError
        E0703: only vectors of two or three numbers and Euler angles have named components.
    """
    param = parameter._column.param
    names = () if param is None else param.components
    if name in names:
        return Component(parameter, names.index(name))
    help = ""
    if param is not None and param.kind == "vec":
        help = "index the array: `v.low[4] = 0`, `v.value[4]`"
    message = f"the parameter has no component `{shorten(name)}`"
    raise UnknownFieldError(
        problem("E0703", message, parameter._name, parameter._column, help=help)
    )
