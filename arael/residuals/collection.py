"""The runtime residuals of a model instance."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from arael.check.report import Reporter
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import user_frames
from arael.diagnostics.records import Findings
from arael.residuals.augmented_model import AugmentedModel
from arael.residuals.code import CodeResidual, CodeUpdate
from arael.residuals.code_arguments import PlacedArgument
from arael.residuals.code_group import CodeGroup, group_of, placed_of
from arael.residuals.compilation import compile_all
from arael.residuals.constants import VariedGroups, varied_groups
from arael.residuals.copying import State, restore, state_of
from arael.residuals.derivation import Derived, derive
from arael.residuals.expression import (
    Array,
    Definition,
    Expression,
    RuntimeResidual,
    measured_part,
    require_residual,
)
from arael.residuals.messages import error
from arael.residuals.resolution import reader_for
from arael.residuals.scope import ResidualNames
from arael.runtime.problem import Problem

P = ParamSpec("P")
T = TypeVar("T")


def _alone(
    method: Callable[Concatenate[Residuals, P], T],
) -> Callable[Concatenate[Residuals, P], T]:
    """Lock the model against preparing a problem in another thread while residuals change."""

    @wraps(method)
    def locked(self: Residuals, /, *args: P.args, **kwargs: P.kwargs) -> T:
        __tracebackhide__ = True
        with user_frames, self._model._store.use.lock:
            return method(self, *args, **kwargs)

    return locked


class Residuals(ResidualNames, Mapping[str, RuntimeResidual]):
    """Residual equations added to one model instance, by label; ``model.residuals``.

    Every solve, cost, gradient, Jacobian and covariance of the model includes them like its
    compiled constraints.
    """

    def __init__(self, model: Any) -> None:
        super().__init__(model)
        self._posed: AugmentedModel | None = None

    # --- adding and removing -------------------------------------------------------------------

    @_alone
    def add(
        self,
        residual: RuntimeResidual | str,
        *,
        label: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        data: Mapping[str, Any] | None = None,
        entities: Mapping[str, Any] | None = None,
        loss: str | None = None,
        when: str | None = None,
    ) -> RuntimeResidual:
        """Add a residual, or the text of one with the arguments of `runtime_residual`.

        Raises
        ------
        AraelError
            E01xx-E06xx: all mistakes of the text with their places; E0760-E0765: invalid arguments.
            The model is then unchanged.
        """
        if isinstance(residual, str):
            residual = RuntimeResidual(
                residual,
                self._free_label() if label is None else label,
                parameters,
                data,
                entities,
                loss,
                when,
            )
        else:
            require_residual(residual)
            if any(
                argument is not None for argument in (label, parameters, data, entities, loss, when)
            ):
                raise error(
                    "E0763",
                    "only with a text, parameters and data can be given here",
                    residual.label,
                )
        if residual._owner is not None:
            raise error("E0763", f"residual `{residual.label}` is in a model already", "residuals")
        self._check_free(residual.label, "label")
        for name in residual.parameters:
            self._check_free(name, "parameter", residual.label)
        self._derived[residual.label] = self._derive(residual)
        self._named.update(dict.fromkeys(residual.parameters, residual))
        residual._owner = self
        self._posed = None
        return residual

    @_alone
    def add_code(self, code: CodeResidual, checked: bool = False) -> CodeResidual:
        """Add residuals by own code; see `Model.add_residuals`.

        Parameters
        ----------
        checked : the parameters are known to be solved for, and there is no loss
        """
        self._check_free(code.label, "label")
        if not checked:
            self._code_groups[code.label] = self._group_of(code)
        self._codes[code.label] = code
        code._owner = self
        self._posed = None
        return code

    @_alone
    def add_update(self, update: CodeUpdate) -> CodeUpdate:
        """Call a function before each linearisation; see `Model.before_linearisation`."""
        self._check_free(update.label, "label")
        placed = placed_of(update.arguments, self.schema.states, update.label)
        self._updates[update.label] = update, placed
        self._posed = None
        return update

    @property
    def code(self) -> Mapping[str, CodeResidual]:
        """Residuals by own code, by name."""
        return dict(self._codes)

    @property
    def priors(self) -> Mapping[str, CodeResidual]:
        """Those of them that `Model.marginalise` added, by name."""
        return {k: v for k, v in self.code.items() if getattr(v.function, "is_prior", False)}

    @property
    def updates(self) -> Mapping[str, CodeUpdate]:
        """Functions that are called before each linearisation, by name."""
        return {label: update for label, (update, _) in self._updates.items()}

    def state(self) -> State:
        """Everything as plain data, from which `restore` makes the residuals of a copy."""
        return state_of(self)

    def restore(self, state: State) -> None:
        """Add everything of `state` to the empty collection of a copy, whose rows are there."""
        restore(self, state)

    @_alone
    def _add_all(self, definitions: list[Definition], residuals: list[RuntimeResidual]) -> None:
        """Add what was valid together; texts may use names of others that follow."""
        for definition in definitions:
            definition._owner = self
            self._definitions[definition.label] = definition
        for residual in residuals:
            residual._owner = self
            self._named.update(dict.fromkeys(residual.parameters, residual))
        for residual in residuals:
            self._derived[residual.label] = self._derive(residual)
        self._posed = None

    @_alone
    def remove(self, which: Expression | CodeResidual | CodeUpdate | str) -> None:
        """Remove a residual, a named expression, or a function called before linearisations.

        Raises
        ------
        AraelError
            E0763: it is not in the model, or others use its parameters or its value.
        """
        if not isinstance(which, Expression | str):
            raise wrong_argument("remove", "which", "a residual, an expression or a label", which)
        label = which if isinstance(which, str) else which.label
        if self._remove_code(label, which):
            return
        expression = self._expression(label)
        if isinstance(which, Expression) and which is not expression:
            raise error("E0763", f"this `{label}` is not in the model", "residuals")
        users = [d.residual.label for d in self._users(label)]
        users += [d.label for d in self._definitions.values() if label in self._reads(d)]
        if users:
            raise error(
                "E0763",
                f"`{label}` is used by {', '.join(f'`{u}`' for u in users)}",
                "residuals",
                "remove these first",
            )
        expression._owner = None
        self._derived.pop(label, None)
        self._definitions.pop(label, None)
        for name in expression.parameters:
            del self._named[name]
        self._posed = None

    def _remove_code(self, label: str, which: object) -> bool:
        """Remove what has a function; False if there is nothing of that name."""
        holder = self._codes.get(label) or self.updates.get(label)
        if holder is None or not (isinstance(which, str) or which is holder):
            return False
        self._codes.pop(label, None)
        self._code_groups.pop(label, None)
        self._updates.pop(label, None)
        if isinstance(holder, CodeResidual):
            holder._owner = None
        self._posed = None
        return True

    @_alone
    def clear(self) -> None:
        """Remove everything."""
        for code in self._codes.values():
            code._owner = None
        self._codes.clear()
        self._code_groups.clear()
        self._updates.clear()
        for derived in (*self._derived.values(),):
            derived.residual._owner = None
        for definition in self._definitions.values():
            definition._owner = None
        self._derived.clear()
        self._definitions.clear()
        self._named.clear()
        self._posed = None

    @_alone
    def define(
        self,
        name: str,
        text: str,
        *,
        data: Mapping[str, Any] | None = None,
        entities: Mapping[str, Any] | None = None,
    ) -> Definition:
        """Define a named expression that residuals and other expressions may use.

        Its text and data can be changed later, which affects all its users. A name may contain
        dots, ``L0.length``, if the part before them is not another name.

        Raises
        ------
        AraelError
            E01xx-E06xx: all mistakes of the text with their places; E0760: the name is taken or
            ambiguous; E0762: invalid data or entities; E0764: it would depend on itself.
        """
        definition = Definition(text, name, None, data, entities)
        self._check_free(name, "name")
        self._check_clear(name)
        self._definitions[name] = definition
        try:
            self._reads(definition)
        except Exception:
            del self._definitions[name]
            raise
        definition._owner = self
        return definition

    def functions(self, text: str, bind: Mapping[str, Any] | None = None) -> None:
        """Declare further functions and constants for the formulas: ``fn`` and ``const`` items.

        Functions and constants of the model are always available. Those declared here may be
        redeclared; existing formulas keep the definitions they were read with.

        Parameters
        ----------
        bind : bindings of each ``extern fn`` of the text by name, as in `arael.load`

        Raises
        ------
        AraelError
            With their mistakes; E0206 for a name that the model declares; E0820-E0822 for invalid
            bindings. They are then unchanged.
        """
        if not isinstance(text, str):
            raise wrong_argument("functions", "text", "`fn` and `const` items as text", text)
        self._functions = self._functions.extended(text, {} if bind is None else bind)
        self._posed = None

    def compile(self, *residuals: RuntimeResidual | str) -> None:
        """Compile residuals to kernels, like constraints of a model file; all by default.

        Compilation takes a second or two and is worthwhile for residuals with many rows and
        constant text. Data and parameters may change; after a new text, loss or a change of a used
        expression a residual is evaluated by the expression machine again. Compiled residuals are
        stored in the cache of models.

        Raises
        ------
        AraelError
            E0763 there is no such residual; E0801-E0803 there is no working C compiler. The
            residuals are then unchanged.
        """
        for residual in residuals:
            if not isinstance(residual, str):
                require_residual(residual)
        chosen = [
            residual if isinstance(residual, str) else residual.label for residual in residuals
        ] or list(self)
        for label in chosen:
            if label not in self._derived:
                raise self._unknown(label)
        compile_all([self._derived[label] for label in chosen], self._functions.layout)
        self._posed = None

    def is_compiled(self, residual: RuntimeResidual | str) -> bool:
        """Whether a residual runs on a compiled kernel."""
        if not isinstance(residual, str):
            require_residual(residual)
        label = residual if isinstance(residual, str) else residual.label
        if label not in self._derived:
            raise self._unknown(label)
        return self._derived[label].compiled is not None

    # --- looking --------------------------------------------------------------------------------

    @property
    def definitions(self) -> Mapping[str, Definition]:
        """Named expressions by name."""
        return dict(self._definitions)

    @property
    def parameters(self) -> dict[str, Any]:
        """Values of the parameters of all runtime residuals by name."""
        return {name: v for residual in self.values() for name, v in residual.parameters.items()}

    def value(self, name: str) -> float | Array:
        """The value of a named expression at the current values.

        Returns
        -------
        A float, or (k,) for a vector. If data or entities have n rows, n other than 1, one value
        for each: (n,) numbers, (n, k) vectors.

        Raises
        ------
        AraelError
            E0763: no expression has that name; E0765: it reads a removed row or an absent optional;
            E0762: its columns differ in length.
        """
        if not isinstance(name, str):
            raise wrong_argument("value", "name", "the name of an expression", name)
        definition = self._definitions.get(name)
        if definition is None:
            raise self._unknown(name)
        probe = RuntimeResidual(definition._text, "value")
        probe.label, probe._data = name, definition._data
        probe.entities = definition.entities
        derived = self._derive(probe, constant_too=True)
        posed = self._pose([derived])
        values = self._rows_of(posed, len(posed.layout.groups) - 1)
        if values.shape[1] == 1:
            values = values[:, 0]
        if len(values) != 1:
            return values
        return float(values[0]) if values.ndim == 1 else values[0]

    def probed(self, text: str, frozen: frozenset[str] = frozenset()) -> tuple[Problem, int]:
        """A problem with a formula as its last group, and the number of that group.

        Raises
        ------
        AraelError
            E01xx-E06xx: all mistakes of the text with their places.
        """
        derived = self._derive(RuntimeResidual(text, "value"), constant_too=True)
        posed = self._pose([derived])
        return self._problem_of(posed, frozen), len(posed.layout.groups) - 1

    @property
    def constant_names(self) -> list[str]:
        """Names of the constants of the model, and of those declared by `functions`."""
        return list(self._functions.declared.declarations.consts)

    def varied(self, problem: Problem, name: str) -> VariedGroups | None:
        """The groups of a problem of the model that read a constant, with it as an input.

        Raises
        ------
        AraelError
            As `varied_groups`.
        """
        return varied_groups(self._model._compiled, self._functions.declared, problem, name)

    def unweighted(self, label: str) -> tuple[Array, Array]:
        """Residuals (rows, m) of one without its loss: without factors of data alone, and with.

        Raises
        ------
        AraelError
            E0763: there is no such residual.
        """
        if isinstance(label, str) and label in self._codes:
            return self._before_loss(label)
        if not isinstance(label, str) or label not in self._derived:
            raise self._unknown(label)
        residual = self._derived[label].residual
        before_loss = []
        for text in (measured_part(residual), residual.text):
            probe = RuntimeResidual(text, "value", when=residual.when)
            probe.label, probe._data = label, residual._data
            probe.entities = residual.entities
            derived = self._derive(probe, constant_too=True)
            posed = self._pose([derived])
            before_loss.append(self._rows_of(posed, len(posed.layout.groups) - 1))
        return before_loss[0], before_loss[1]

    def _before_loss(self, label: str) -> tuple[Array, Array]:
        """Residuals of own code as the function returns them, twice."""
        problem = self._model._problem()
        assert problem.hooks is not None
        values = problem.hooks.columns_at(self._number(label), problem.states, False)
        return values, values.copy()

    def __getitem__(self, label: str) -> RuntimeResidual:
        if not isinstance(label, str) or label not in self._derived:
            raise KeyError(label)
        return self._derived[label].residual

    def __iter__(self) -> Iterator[str]:
        return iter(self._derived)

    def __len__(self) -> int:
        return len(self._derived)

    def __repr__(self) -> str:
        shown = (*self._definitions.values(), *self.values(), *self.code.values())
        lines = [repr(residual) for residual in (*shown, *self.updates.values())]
        return "\n".join(["<runtime residuals>", *(f"  {line}" for line in lines)])

    # --- deriving ---------------------------------------------------------------------------------

    def _owners(self) -> list[Expression]:
        owners: dict[Expression, None] = dict.fromkeys(self._named.values())
        if self._adding is not None and len(self._adding.parameters):
            owners[self._adding] = None
        return list(owners)

    def _derive(self, residual: RuntimeResidual, constant_too: bool = False) -> Derived:
        self._adding = residual
        try:
            return derive(
                residual,
                self,
                self._owners(),
                self._functions.declared,
                self._functions.layout.natives,
                constant_too,
            )
        finally:
            self._adding = None

    def _users(self, label: str) -> list[Derived]:
        """Residuals other than `label` that read it."""
        return [
            derived
            for derived in self._derived.values()
            if derived.residual.label != label and label in derived.reads.needs
        ]

    def _reads(self, definition: Definition) -> Iterable[str]:
        """Labels that a named expression reads; raises its errors."""
        findings = Findings()
        report = Reporter(findings)
        declared_ = self._functions.declared
        reader = reader_for(
            definition, "rows", self, declared_.declarations, report, declared_.constants.named
        )
        reader.value(definition._tree)
        report.stop()
        return reader.reads.needs

    @_alone
    def _changed(self, expression: Expression) -> None:
        """Rederive all users of `expression`, whose text has changed; all or nothing."""
        if isinstance(expression, Definition):
            self._reads(expression)
        derived = self._derived.get(expression.label)
        affected = [*([derived] if derived is not None else []), *self._users(expression.label)]
        fresh = {one.residual.label: self._derive(one.residual) for one in affected}
        self._derived.update(fresh)
        self._posed = None

    @_alone
    def _data_changed(self, expression: Expression, reshaped: bool) -> None:
        if reshaped:
            self._changed(expression)
        for one in (self._derived.get(expression.label), *self._users(expression.label)):
            if one is not None:
                size = one.rows.size
                one.rows.refresh()
                if one.rows.size != size and self._posed is not None:
                    self._posed.rows_version += 1

    # --- solving ----------------------------------------------------------------------------------

    @_alone
    def posed(self) -> AugmentedModel:
        """The model with its residuals, in the form of the solver."""
        if self._posed is None:
            self._posed = self._pose(
                list(self._derived.values()),
                [self._group_of(code) for code in self._codes.values()],
                list(self._updates.values()),
            )
        self._posed.check()
        return self._posed

    def _group_of(self, code: CodeResidual) -> CodeGroup:
        found = self._code_groups.get(code.label)
        if found is None or found.code is not code:
            found = group_of(code, self, self.schema.states, self._functions.declared)
            self._code_groups[code.label] = found
        return found

    def _pose(
        self,
        derived: list[Derived],
        codes: Sequence[CodeGroup] = (),
        updates: Sequence[tuple[CodeUpdate, tuple[PlacedArgument, ...]]] = (),
    ) -> AugmentedModel:
        return AugmentedModel(
            self._functions.layout,
            self._model._store,
            self._owners(),
            derived,
            self._functions.bindings,
            codes,
            updates,
        )

    def _number(self, label: str) -> int:
        return len(self.schema.layout.groups) + [*self._derived, *self._codes].index(label)

    def _cost_of(self, label: str) -> float:
        return float(self._model._problem().evaluation.group_cost(self._number(label)))

    def _residuals_of(self, label: str) -> Array:
        return self._rows_of(self.posed(), self._number(label))

    def _rows_of(self, posed: AugmentedModel, number: int) -> Array:
        values: Array = self._problem_of(posed).evaluation.group_rows(number)[0]
        return values

    def _problem_of(self, posed: AugmentedModel, frozen: frozenset[str] = frozenset()) -> Problem:
        posed.check()
        compiled = self._model._compiled
        return Problem(
            posed.layout,
            posed,
            compiled.kernels,
            frozen=frozen,
            programs=posed.programs,
            bindings={**compiled.bindings, **posed.bindings},
        )
