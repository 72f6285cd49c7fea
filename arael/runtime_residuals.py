"""`runtime_residual` and `runtime_model`: residual equations known only at run time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from arael.compiled_model import CompiledModel
from arael.copying import State, restore, state_of
from arael.model import Model
from arael.residuals.expression import RuntimeResidual
from arael.runtime.layout import LAYOUT_VERSION, Layout, Table


def runtime_residual(
    text: str,
    *,
    label: str = "residual",
    parameters: Mapping[str, Any] | None = None,
    data: Mapping[str, Any] | None = None,
    entities: Mapping[str, Any] | None = None,
    loss: str | None = None,
    when: str | None = None,
) -> RuntimeResidual:
    """A residual equation from text, to be added to a model with ``model.residuals.add``.

    Parameters
    ----------
    text : a formula in arael's language: a scalar, a vector or a list of both, to be minimised; or
        what must hold: ``"norm(p - q) == 1"``, ``"0 <= a <= 2"`` (docs/constraints.md).
        Names are those given here, parameters and expressions of other runtime residuals of the
        model, and fields of the model's root (``poses[3].pos.x``).
    label : its name in cost tables, Jacobians and messages
    parameters : its own parameters, by name: a start value, a list for a vector, or a dict of
        ``value`` and any of ``low``, ``high``, ``fixed``
    data : columns by name: one number, an array (n,) or (n, k). The residual is evaluated once for
        each of the n rows.
    entities : rows of the model by name: the result of ``append``, ``model.poses[3]``, or many rows
        (``model.poses``), one for each row of the residual
    loss : robust loss of the residuals of a row together, as after `loss` in a model file:
        ``"cauchy(2)"``, ``"huber(2)"``, ``"tukey(4)"``, ...,
        or ``"|s| 2 * (sqrt(1 + s) - 1)"``. Its scale may be one of `data`.
    when : a condition over data, as after `when` in a model file (``"p.gps"``, ``"weight > 0"``);
        the residual is evaluated for the rows where it is true

    Raises
    ------
    AraelError
        E01xx: syntax errors of the text with their places; E0760-E0762: names or values
        that do not fit.

    Examples
    --------
    >>> import arael
    >>> fit = arael.runtime_residual(
    ...     "a * exp(-b * x) - y",
    ...     parameters={"a": 1, "b": 0.1},
    ...     data={"x": [0, 1, 2], "y": [2, 1, 0.5]},
    ... )
    >>> model = arael.runtime_model(fit)
    >>> model.solve().status
    'converged'
    >>> round(fit.parameters["a"], 4)
    2.0
    """
    return RuntimeResidual(text, label, parameters, data, entities, loss, when)


def runtime_model(
    *residuals: RuntimeResidual, precision: Literal["f64", "f32"] = "f64", name: str = "runtime"
) -> Model:
    """A model of runtime residuals only, for example a fit described by a configuration file.

    Returns
    -------
    A model instance; more can be added to its ``residuals``.
    """
    root = Table("", "Runtime", "root", "", "", name, ())
    layout = Layout(LAYOUT_VERSION, name, "Runtime", precision, name, (root,), (), (), ())
    model = RuntimeModel(CompiledModel(layout, None, None, "runtime", {}))
    for residual in residuals:
        model.residuals.add(residual)
    return model


class RuntimeModel(Model):
    """A model of runtime residuals only."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._compiled.layout, state_of(self))


def _unpickled(layout: Layout, state: State) -> RuntimeModel:
    model = RuntimeModel(CompiledModel(layout, None, None, "runtime", {}))
    restore(model, state)
    return model
