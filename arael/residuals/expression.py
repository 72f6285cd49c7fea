"""Formulas given as text: residuals, and expressions that residuals name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.check.walk import subtrees
from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.face.collection import Collection
from arael.face.ref import Ref, Refs
from arael.residuals.dotted import dotted_problem
from arael.residuals.messages import error, label_problem, name_problem
from arael.residuals.parameters import Parameters
from arael.syntax import tree
from arael.syntax.parser import parse_expression, parse_loss, parse_rule

Array = NDArray[Any]

MAX_TEXT = 20_000
"""Maximum characters of one formula."""


class Owner(Protocol):
    """The residuals of a model, to which an expression was added."""

    def compile(self, *residuals: RuntimeResidual | str) -> None:
        """Compile residuals to kernels."""

    def is_compiled(self, residual: RuntimeResidual | str) -> bool:
        """Whether a residual runs on a compiled kernel."""

    def _changed(self, expression: Expression) -> None:
        """Rederive all users of `expression`, whose text has changed; all or nothing."""

    def _data_changed(self, expression: Expression, reshaped: bool) -> None:
        """Take over changed data of `expression`, with other columns or shapes if `reshaped`."""

    def _cost_of(self, label: str) -> float:
        """Cost of a residual at the current values."""

    def _residuals_of(self, label: str) -> Array:
        """Residuals of all rows, (n, k)."""


class Expression:
    """A formula with the values of its names. See `runtime_residual` for the parameters.

    Attributes
    ----------
    label : its name
    parameters : its own parameters
    entities : rows of the model that it names
    """

    _name_rule = staticmethod(label_problem)

    def __init__(
        self,
        text: str,
        label: str,
        parameters: Mapping[str, Any] | None = None,
        data: Mapping[str, Any] | None = None,
        entities: Mapping[str, Any] | None = None,
    ) -> None:
        problem = self._name_rule(label)
        if problem:
            raise error("E0760", f"{label!r:.60} cannot be a label: {problem}", "label")
        for what, given in (("parameters", parameters), ("data", data), ("entities", entities)):
            if given is not None and not isinstance(given, Mapping):
                raise error(
                    "E0760",
                    f"{what} are given by name, found {type(given).__name__}",
                    label,
                    f'write `{what}={{"name": ...}}`',
                )
        self.label = label
        self._owner: Owner | None = None
        self._text, self._tree = text, parsed(text, label)
        self.parameters = Parameters(parameters or {}, label)
        self._data = {name: numbers(name, v, label) for name, v in (data or {}).items()}
        self.entities = {name: handles(name, v, label) for name, v in (entities or {}).items()}
        taken: dict[str, str] = {}
        for what, names in (
            ("parameter", self.parameters),
            ("data column", self._data),
            ("entity", self.entities),
        ):
            for name in names:
                problem = name_problem(name)
                if not problem and name in taken:
                    problem = f"there is a {taken[name]} of that name"
                if problem:
                    raise error("E0760", f"`{name}` cannot name a {what}: {problem}", label)
                taken[name] = what

    @property
    def text(self) -> str:
        """The formula; an assignment takes effect at once, or raises and changes nothing."""
        return self._text

    @text.setter
    def text(self, text: str) -> None:
        before = self._text, self._tree
        self._text, self._tree = text, parsed(text, self.label)
        try:
            if self._owner is not None:
                self._owner._changed(self)
        except AraelError:
            self._text, self._tree = before
            raise

    @property
    def data(self) -> Mapping[str, Array]:
        """Data columns by name; `set_data` changes them."""
        return dict(self._data)

    def set_data(self, **columns: Any) -> None:
        """Replace data columns; rederives only if a scalar becomes a vector.

        Raises
        ------
        AraelError
            E0762: no such column, or no numbers.
        """
        found = {}
        for name, value in columns.items():
            if name not in self._data:
                raise error(
                    "E0762",
                    f"there is no data column `{name}`",
                    self.label,
                    f"it has {', '.join(self._data) or 'none'}",
                )
            found[name] = numbers(name, value, self.label)
        before = dict(self._data)
        reshaped = any(before[n].shape[1:] != found[n].shape[1:] for n in found)
        self._data.update(found)
        if self._owner is not None:
            try:
                self._owner._data_changed(self, reshaped)
            except AraelError:
                self._data = before
                self._owner._data_changed(self, False)
                raise

    @property
    def span(self) -> Span:
        """The whole text."""
        return self._tree.span

    def __repr__(self) -> str:
        return f"<{self.label}: {self._text}>"


class RuntimeResidual(Expression):
    """A residual equation known only at run time; made by `arael.runtime_residual`."""

    def __init__(
        self,
        text: str,
        label: str,
        parameters: Mapping[str, Any] | None = None,
        data: Mapping[str, Any] | None = None,
        entities: Mapping[str, Any] | None = None,
        loss: str | None = None,
        when: str | None = None,
    ) -> None:
        super().__init__(text, label, parameters, data, entities)
        self._loss, self._loss_tree = loss, parsed_loss(loss, label)
        self._when, self._when_tree = when, parsed_guard(when, label)

    @property
    def loss(self) -> str | None:
        """The loss, or None; an assignment takes effect at once, or raises and changes nothing.

        ``"cauchy(2)"``, ``"huber(k)"``, any other loss of a model file, or
        ``"|s| log(1 + s)"``; its scale may be a data column.
        """
        return self._loss

    @loss.setter
    def loss(self, loss: str | None) -> None:
        before = self._loss, self._loss_tree
        self._loss, self._loss_tree = loss, parsed_loss(loss, self.label)
        try:
            if self._owner is not None:
                self._owner._changed(self)
        except AraelError:
            self._loss, self._loss_tree = before
            raise

    @property
    def when(self) -> str | None:
        """The guard, or None; an assignment takes effect at once, or raises and changes nothing.

        A condition over data, as after `when` in a model file: ``"p.gps"``, ``"weight > 0"``. Rows
        for which it is false cost nothing and contribute nothing.
        """
        return self._when

    @when.setter
    def when(self, when: str | None) -> None:
        before = self._when, self._when_tree
        self._when, self._when_tree = when, parsed_guard(when, self.label)
        try:
            if self._owner is not None:
                self._owner._changed(self)
        except AraelError:
            self._when, self._when_tree = before
            raise

    def compile(self) -> None:
        """Use a compiled kernel; see `Residuals.compile`."""
        if self._owner is None:
            raise error("E0763", f"residual `{self.label}` is not in a model", self.label)
        self._owner.compile(self)

    @property
    def compiled(self) -> bool:
        """Whether it runs on a compiled kernel."""
        return self._owner is not None and self._owner.is_compiled(self)

    @property
    def cost(self) -> float:
        """Sum of its squared residuals at the current values."""
        if self._owner is None:
            raise error("E0763", f"residual `{self.label}` is not in a model", self.label)
        return self._owner._cost_of(self.label)

    @property
    def residuals(self) -> Array:
        """Its residuals at the current values, (rows, scalars)."""
        if self._owner is None:
            raise error("E0763", f"residual `{self.label}` is not in a model", self.label)
        return self._owner._residuals_of(self.label)


def measured_part(residual: RuntimeResidual) -> str:
    """The formula without factors and divisors that are numbers and data columns alone."""

    def is_data(node: tree.Expr) -> bool:
        return all(
            isinstance(part, tree.Number | tree.Binary | tree.Unary)
            or (isinstance(part, tree.Name) and part.id in residual._data)
            for part in subtrees(node)
        )

    node = residual._tree
    while isinstance(node, tree.Binary) and node.op in ("*", "/", ".*", "./"):
        if is_data(node.right):
            node = node.left
        elif node.op in ("*", ".*") and is_data(node.left):
            node = node.right
        else:
            break
    return node.span.text


def require_residual(value: object) -> None:
    """Raise E0760 unless `value` is a residual."""
    if isinstance(value, RuntimeResidual):
        return
    what = "a function" if callable(value) else f"`{value!r:.60}`"
    raise error(
        "E0760",
        f"expected a formula as text or an `arael.runtime_residual`, found {what}",
        "residuals.add",
        'write the formula as text: `add("norm(p.pos) - d", entities={"p": ...}, '
        'data={"d": ...})`; Python functions are bound with `functions(text, bind=...)`',
    )


class Definition(Expression):
    """A named expression that formulas of the same model may read; made by `Residuals.define`."""

    _name_rule = staticmethod(dotted_problem)


def parsed(text: str, label: str) -> tree.Expr:
    """Read one formula, or a comparison that is to hold.

    Raises
    ------
    AraelError
        With every syntax error; E0104 for one that is too long.
    """
    return parse_rule(_source(text, label))


def parsed_loss(text: str | None, label: str) -> tree.Expr | None:
    """Read one loss; raises as `parsed` does."""
    return None if text is None else parse_loss(_source(text, f"loss of {label}"))


def parsed_guard(text: str | None, label: str) -> tree.Expr | None:
    """Read one guard; raises as `parsed` does."""
    return None if text is None else parse_expression(_source(text, f"guard of {label}"))


def _source(text: str, name: str) -> Source:
    if not isinstance(text, str):
        raise error("E0760", f"a formula is text, found {type(text).__name__}", name)
    source = Source(name, text)
    if len(text) > MAX_TEXT:
        raise AraelError(
            Diagnostic(
                "E0104",
                f"the formula has {len(text)} characters",
                Span(source, 0, 0),
                help=(f"at most {MAX_TEXT} are read",),
            )
        )
    return source


def numbers(name: str, value: Any, label: str) -> Array:
    """Data as f64: () one number for all rows, (n,) a number per row, (n, k) a vector per row."""
    where = f"{label}: {name}"
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise error("E0762", f"expected numbers, found {value!r:.60}", where) from None
    if array.ndim > 2 or (array.ndim == 2 and not 1 <= array.shape[1] <= 64):
        raise error(
            "E0762",
            f"expected one number, or a number or a vector of at most 64 per row, "
            f"found shape {array.shape}",
            where,
        )
    return array


def handles(name: str, value: Any, label: str) -> Refs:
    """Rows of the model as refs; one for all rows of the residual, or one per row."""
    if isinstance(value, Ref):
        return Refs(value._table, np.array([value._handle], dtype=np.int64))
    if isinstance(value, Collection):
        return value.refs
    if isinstance(value, Refs):
        return value
    raise error(
        "E0762",
        f"expected a row or rows of the model, found {type(value).__name__}",
        f"{label}: {name}",
        "pass the result of `append`, `model.poses[3]`, or a whole collection `model.poses`",
    )
