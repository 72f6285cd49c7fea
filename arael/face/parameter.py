"""Python interface of a parameter of one row or of many."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.face.forms import Forms
from arael.face.valued import Valued
from arael.runtime.layout import Column
from arael.runtime.store import Table
from arael.runtime.store.bounds import (
    COMPONENTS_FIXED,
    has_components,
    of_model,
    require_bounded,
    split_fixed,
)
from arael.runtime.store.columns import Rows
from arael.runtime.store.messages import error

if TYPE_CHECKING:
    from arael.face.component import Component

Array = NDArray[Any]


def taken(array: Array, rows: Rows) -> Any:
    """Rows of a column: a live view if they are contiguous, else a read-only copy."""
    part = array[rows]
    if isinstance(rows, np.ndarray):
        part.flags.writeable = False
    return part


class Parameter(Valued, Forms):
    """Value and flags of a parameter: of one row (``poses[3].pos``) or of many (``poses.pos``).

    In arithmetic, NumPy functions, comparisons, indexing and formatting it stands for its value:
    ``2 * m.a``, ``np.exp(m.a)``, ``float(m.a)``, ``poses.pos[:, 0]``, ``f"{m.a:.3f}"``.
    """

    __slots__ = ("_path", "_rows", "_table", "_whole")

    def __init__(
        self, table: Table, path: str, rows: Callable[[], Rows], whole: bool = False
    ) -> None:
        self._table = table
        self._path = path
        self._rows = rows
        self._whole = whole

    @property
    def _name(self) -> str:
        rows = self._rows()
        if isinstance(rows, int):
            return self._table.name_of(rows, self._path)
        return f"{self._table.label}.{self._path}"

    @property
    def _column(self) -> Column:
        return self._table.data[self._path]

    @property
    def value(self) -> Any:
        """The value: (N, ...) or (...) as a live view; a number for one scalar.

        Euler angles as roll, pitch, yaw [rad]; rotations as unit quaternions (w, x, y, z);
        directions as unit vectors; transforms as translation, quaternion and scale. Valid until
        rows are added or removed. Writes into the view are not checked; assignments are.
        """
        rows, values = self._rows(), self._table.buffers.view(self._path)
        if isinstance(rows, int):
            return values[rows] if values.ndim > 1 else values.item(rows)
        return taken(values, rows)

    @value.setter
    def value(self, value: Any) -> None:
        self._table.set_values(self._path, self._rows(), value, self._name)

    @property
    def fixed(self) -> Any:
        """Whether the data fixes the parameter in every solve: bool, or (N,) bools.

        A vector or Euler angles of k numbers also take one bool for each of them, (k,) for a row
        and (N, k) or (1, k) for many, and return them where only some are fixed. Files have them.
        """
        whole = self._flag(self._table.fixed(self._path))
        some = self._table.fixed_components(self._path)
        if some is None or not some[self._rows()].any():
            return whole
        part = np.logical_or(some[self._rows()], np.asarray(whole)[..., None])
        part.flags.writeable = False
        return part

    @fixed.setter
    def fixed(self, value: Any) -> None:
        rows = self._rows()
        one = isinstance(rows, int)
        try:
            array = np.asarray(value)
        except ValueError:  # rows of different lengths
            raise wrong_argument(
                f"{self._path}.fixed", "fixed", "a bool, or one for each row or component", value
            ) from None
        if has_components(self._column) and array.ndim == (1 if one else 2):
            self._check_components(array, rows, "fixed")
            whole, some = split_fixed(array)
            self._table.writable(f"{self._path}.{COMPONENTS_FIXED}")[rows] = some
            self._table.fixed(self._path)[rows] = whole
            return
        self._set_flag("fixed", value)
        held = self._table.fixed_components(self._path)
        if held is not None:
            held[rows] = False

    @property
    def low(self) -> Any:
        """Lower bound of a real or vector parameter: of this row, or by row.

        A number for one scalar, else an array of the shape of the value: a live view, whose
        writes a solve checks. Assign a number, an array, or None for no bound (-inf); one number
        or one row is for all. ``del m.k.low`` restores the bound of the model.

        Raises
        ------
        AraelError
            When set: E0703 a parameter that has no bounds, E0704 a wrong shape, E0705 NaN.
        """
        return self._bound("low")

    @low.setter
    def low(self, value: Any) -> None:
        self._table.set_bounds(self._path, "low", self._rows(), value, f"{self._name}.low")

    @low.deleter
    def low(self) -> None:
        self._table.reset_bounds(self._path, "low", self._rows())

    @property
    def high(self) -> Any:
        """Upper bound, as `low`; None is inf."""
        return self._bound("high")

    @high.setter
    def high(self, value: Any) -> None:
        self._table.set_bounds(self._path, "high", self._rows(), value, f"{self._name}.high")

    @high.deleter
    def high(self) -> None:
        self._table.reset_bounds(self._path, "high", self._rows())

    def _bound(self, end: str) -> Any:
        require_bounded(self._column, f"{self._name}.{end}")
        rows = self._rows()
        if isinstance(rows, int) and not self._column.shape:
            own = self._table.bound(self._path, end)
            return float(of_model(self._column, end) if own is None else own[rows])
        return taken(self._table.writable(f"{self._path}.{end}"), rows)

    @property
    def x(self) -> Component:
        """First component of a vector or of Euler angles: its value, flags and bounds."""
        return _component(self, "x")

    @x.setter
    def x(self, value: Any) -> None:
        _component(self, "x").value = value

    @property
    def y(self) -> Component:
        """Second component."""
        return _component(self, "y")

    @y.setter
    def y(self, value: Any) -> None:
        _component(self, "y").value = value

    @property
    def z(self) -> Component:
        """Third component."""
        return _component(self, "z")

    @z.setter
    def z(self, value: Any) -> None:
        _component(self, "z").value = value

    @property
    def optimize(self) -> Any:
        """Whether the parameter is solved for, unless it is fixed: bool, or (N,) bools.

        A vector or Euler angles of k numbers also take one bool for each of them, (k,) for a row
        and (N, k) or (1, k) for many, and give them back unless all are true.

        Setting it for a whole collection also applies to rows appended later.
        """
        whole = self._flag(self._table.optimize(self._path))
        held = self._table.component_flags(self._path)
        if held is None or held[self._rows()].all():
            return whole
        part = np.logical_and(held[self._rows()], np.asarray(whole)[..., None])
        part.flags.writeable = False
        return part

    @optimize.setter
    def optimize(self, value: Any) -> None:
        array, rows = _flags(value, f"{self._name}.optimize"), self._rows()
        one = isinstance(rows, int)
        if has_components(self._column) and array.ndim == (1 if one else 2):
            self._set_components(array, rows)
            return
        self._set_flag("optimize", value)
        held = self._table.component_flags(self._path)
        if held is not None:  # one bool is for all components
            held[rows] = True
            if self._whole and array.shape == ():
                self._table.components_new[self._path] = (True,) * held.shape[1]

    def _check_components(self, array: Array, rows: Rows, name: str) -> None:
        """Raise E0703 for anything but a bool for each component of each row."""
        one = isinstance(rows, int)
        count = 1 if one else len(np.arange(self._table.size)[rows])
        param = self._column.param
        assert param is not None
        shapes = [(param.tangent,)] if one else [(count, param.tangent), (1, param.tangent)]
        if array.dtype != np.bool_ or array.shape not in shapes:
            raise error(
                "E0703",
                f"expected true or false for each of {param.tangent} components, "
                f"found shape {array.shape} of {array.dtype}",
                f"{self._name}.{name}",
                self._column,
            )

    def _set_components(self, array: Array, rows: Rows) -> None:
        self._check_components(array, rows, "optimize")
        flags = self._table.add_component_flags(self._path)
        flags[rows] = array
        self._table.optimize(self._path)[rows] = True
        if self._whole and len(array) == 1:
            self._table.components_new[self._path] = tuple(bool(x) for x in array[0])
            self._table.optimize_new[f"{self._path}.optimize"] = True

    @property
    def optimize_translation(self) -> Any:
        """Whether the translation of a transform is solved for, if the transform is."""
        return self._part_flag("optimize_translation")

    @optimize_translation.setter
    def optimize_translation(self, value: Any) -> None:
        self._set_flag("optimize_translation", value)

    @property
    def optimize_rotation(self) -> Any:
        """Whether the rotation of a transform is solved for, if the transform is."""
        return self._part_flag("optimize_rotation")

    @optimize_rotation.setter
    def optimize_rotation(self, value: Any) -> None:
        self._set_flag("optimize_rotation", value)

    @property
    def optimize_scale(self) -> Any:
        """Whether the scale of a similarity is solved for, if the similarity is."""
        return self._part_flag("optimize_scale")

    @optimize_scale.setter
    def optimize_scale(self, value: Any) -> None:
        self._set_flag("optimize_scale", value)

    def _part_flag(self, name: str) -> Any:
        self._need_flag(name)
        return self._flag(self._table.column_of_flags(self._path, name))

    def _need_flag(self, name: str) -> None:
        if name != "fixed" and f"{self._path}.{name}" not in self._table.optimize_new:
            part = name.removeprefix("optimize_")
            raise error("E0703", f"the parameter has no {part}", self._name, self._column)

    def _flag(self, flags: Array) -> Any:
        part = taken(flags, self._rows())
        return part if isinstance(part, np.ndarray) else bool(part)

    def _set_flag(self, name: str, value: Any) -> None:
        self._need_flag(name)
        array = _flags(value, f"{self._name}.{name}")
        flags, rows = self._table.column_of_flags(self._path, name), self._rows()
        if array.dtype != np.bool_ or array.shape not in ((), np.shape(flags[rows])):
            raise error("E0703", "expected true or false for each row", f"{self._name}.{name}")
        flags[rows] = array
        if self._whole and name != "fixed" and array.shape == ():
            self._table.optimize_new[f"{self._path}.{name}"] = bool(array)

    def __repr__(self) -> str:
        flags = "".join(
            f", {text}"
            for text, is_so in (
                ("fixed", np.all(self.fixed)),
                ("not optimised", not np.any(self.optimize)),
            )
            if is_so and np.size(self.value)
        )
        text = np.array2string(np.asarray(self.value), precision=6, threshold=12, edgeitems=2)
        return f"<{self._name}: {text}{flags}>"


def _flags(value: Any, name: str) -> Array:
    try:
        return np.asarray(value)
    except ValueError:
        raise error("E0703", "expected true or false for each row", name) from None


def _component(parameter: Parameter, name: str) -> Component:
    # imported here: start-up time
    from arael.face.component import component

    return component(parameter, name)
