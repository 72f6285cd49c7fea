"""Evaluation of residuals by own code: calls of the function, and checks of what it returns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.residuals.code import CodeResidual, CodeUpdate
from arael.residuals.code_arguments import PlacedArgument
from arael.runtime.failures import FunctionError
from arael.runtime.machine.programs import evaluate
from arael.runtime.store.access import Ints

Floats = NDArray[np.float64]
Triplets = tuple[Ints, Ints, Ints, Ints, Ints, Floats]

STEP = float(np.cbrt(np.finfo(np.float64).eps))
"""Step of central differences, relative to a value of magnitude above 1."""

# Instances that are called one by one to find the one that a function fails for.
_SEARCHED = 10_000


class CodeHook:
    """Calls the function of a residual; an `arael.runtime.evaluation.hooks.Hook`.

    The last result is kept: a step that was tried and accepted is not evaluated again.
    """

    def __init__(self, code: CodeResidual, placed: Sequence[PlacedArgument]) -> None:
        self.code, self.placed = code, placed
        ambient = code.coordinates == "ambient"
        self.widths = [place.stored if ambient else place.tangent for place in placed]
        self.restart()

    def restart(self) -> None:
        """Take the present data, and forget the last result."""
        self._data = self.code.data
        self._forget()

    def note(self) -> str:
        """Mention differences in reports and in the log."""
        if self.code.derivatives != "differences":
            return ""
        return f"derivatives of `{self.code.label}` are central differences"

    def _forget(self) -> None:
        self._at: list[Floats] | None = None
        self._residuals: Floats | None = None
        self._entries: Floats | None = None
        self._curvature: Triplets | None = None

    def curvature(self) -> Triplets | None:
        """Triplets of the Hessian that the function returned last."""
        return self._curvature

    def columns(self, states: Sequence[Floats], rows: Ints, derivatives: bool) -> Floats:
        """Residuals (n, size), with derivatives and the Jacobian (n, size, width) behind them."""
        if self._at is None or not all(map(np.array_equal, self._at, states)):
            self._forget()
            self._at = list(states)
        n = len(rows)
        try:
            if self._residuals is None:
                self._take(states, rows, derivatives)
            if derivatives and self._entries is None:
                self._take_derivatives(states, rows)
        except BaseException:
            self._forget()
            raise
        assert self._residuals is not None
        if not derivatives:
            return self._residuals
        assert self._entries is not None
        return np.concatenate((self._residuals, self._entries.reshape(n, -1)), axis=1)

    # --- results of the function ---------------------------------------------------------------

    def _take(self, states: Sequence[Floats], rows: Ints, derivatives: bool) -> None:
        """Call the function and keep what it returns."""
        result = self._called(self.code.function, states, rows, derivatives)
        parts = result if isinstance(result, tuple) else (result,)
        if not 1 <= len(parts) <= 3:
            raise self._wrong(
                f"returned a tuple of {len(parts)}",
                "return residuals, `(residuals, jacobians)`, or these with triplets of the Hessian",
            )
        n = len(rows)
        self._residuals = self._array(parts[0], (n, self.code.size), "residuals")
        if len(parts) > 1 and parts[1] is not None:
            self._keep_entries(parts[1], rows)
        if len(parts) > 2 and parts[2] is not None:
            self._curvature = self._triplets(parts[2], n)

    def _take_derivatives(self, states: Sequence[Floats], rows: Ints) -> None:
        code = self.code
        if code.native is not None and code.jacobian is not False:
            self._take(states, rows, True)
        elif callable(code.jacobian):
            self._keep_entries(self._called(code.jacobian, states, rows, True), rows)
        else:
            if code.coordinates == "ambient":
                raise self._wrong(
                    "returned no Jacobians, which `coordinates='ambient'` announces",
                    "return `(residuals, jacobians)`, or leave out `coordinates`: differences are "
                    "taken in tangent coordinates",
                )
            self._note("differences")
            self._entries = self._differences(states, rows)

    def _keep_entries(self, jacobians: Any, rows: Ints) -> None:
        """Check Jacobians, one for each parameter, and keep them side by side."""
        n, size = len(rows), self.code.size
        single = len(self.placed) == 1
        parts = [jacobians] if single and not isinstance(jacobians, tuple | list) else jacobians
        if (
            single
            and isinstance(jacobians, list)
            and jacobians
            and not hasattr(jacobians[0], "shape")
        ):
            parts = [jacobians]
        if not isinstance(parts, tuple | list) or len(parts) != len(self.placed):
            returned = f"{len(parts)}" if isinstance(parts, tuple | list) else type(parts).__name__
            raise self._wrong(
                f"returned {returned} as Jacobians of {len(self.placed)} parameters",
                "return a list with one array for each parameter, in their order",
            )
        arrays = [
            self._array(part, (n, size, width), f"Jacobian by `{place.argument.name}`")
            for part, place, width in zip(parts, self.placed, self.widths, strict=True)
        ]
        assert self._residuals is not None
        sound = np.isfinite(self._residuals).all(axis=1)
        for array, place in zip(arrays, self.placed, strict=True):
            bad = ~np.isfinite(array).all(axis=(1, 2)) & sound
            if bad.any():
                raise self._not_finite(array, place, int(np.argmax(bad)), int(rows[np.argmax(bad)]))
        self._note("given")
        self._entries = np.concatenate(arrays, axis=2)

    def _array(self, result: Any, shape: tuple[int, ...], what: str) -> Floats:
        """A result as f64 of the shape that is expected; axes of length 1 may be left out."""
        if hasattr(result, "detach"):  # PyTorch
            result = result.detach().cpu()
        try:
            array = np.asarray(result)
        except (TypeError, ValueError):
            array = np.asarray(None)
        expected = " x ".join(map(str, shape))
        if array.dtype.kind not in "fiu":
            kind = type(result).__name__ if array.dtype.kind == "O" else str(array.dtype)
            raise self._wrong(
                f"returned {kind} as {what}", f"expected real numbers of shape {expected}"
            )
        if [k for k in array.shape if k != 1] != [k for k in shape if k != 1]:
            raise self._wrong(
                f"returned {what} of shape {' x '.join(map(str, array.shape)) or '()'}",
                f"expected {expected}: instances, residuals"
                + (", coordinates" if len(shape) == 3 else ""),
            )
        return np.array(array, dtype=np.float64).reshape(shape)

    def _triplets(self, result: Any, n: int) -> Triplets | None:
        """Second-order terms: (instance, row, column, value), or (n, k, k) symmetric matrices."""
        tangents = np.concatenate([np.arange(p.tangent) + p.tangent_start for p in self.placed])
        uses = np.concatenate([np.full(p.tangent, p.use) for p in self.placed])
        k = len(tangents)
        if isinstance(result, tuple):
            if len(result) != 4:
                raise self._wrong(
                    f"returned {len(result)} arrays as triplets of the Hessian",
                    "expected instance, row, column and value, each (m,)",
                )
            instance, row, column = (
                self._numbers(part, f"{what} of the Hessian")
                for part, what in zip(result, ("instances", "rows", "columns"), strict=False)
            )
            m = len(instance)
            value = self._array(result[3], (np.size(result[3]),), "values of the Hessian").reshape(
                -1
            )
            lengths = {m, len(row), len(column), len(value)}
            if len(lengths) != 1:
                raise self._wrong(
                    f"returned triplets of the Hessian of lengths {sorted(lengths)}",
                    "expected as many instances, rows, columns and values",
                )
            for what, part, end in (
                ("instance", instance, n),
                ("row", row, k),
                ("column", column, k),
            ):
                outside = (part < 0) | (part >= end)
                if outside.any():
                    raise self._wrong(
                        f"returned triplets of the Hessian with {what} {part[outside][0]}",
                        f"expected 0 .. {end - 1}",
                    )
        else:
            dense = self._array(result, (n, k, k), "Hessian")
            low, high = np.tril_indices(k)
            instance = np.repeat(np.arange(n), len(low))
            row, column = np.tile(low, n), np.tile(high, n)
            value = dense[:, low, high].reshape(-1)
        if not np.isfinite(value).all():
            at = int(instance[np.argmin(np.isfinite(value))])
            raise self._wrong(f"returned a Hessian that is not finite for {self._instance(at)}", "")
        return instance, uses[row], tangents[row], uses[column], tangents[column], value

    def _numbers(self, result: Any, what: str) -> Ints:
        """Whole numbers (m,)."""
        try:
            numbers = np.asarray(result)
        except (TypeError, ValueError):
            numbers = np.asarray(None)
        if numbers.dtype.kind not in "iu" and numbers.size:
            raise self._wrong(f"returned {numbers.dtype} as {what}", "expected whole numbers, (m,)")
        return numbers.astype(np.int64).reshape(-1)

    # --- derivatives by differences --------------------------------------------------------------

    def _differences(self, states: Sequence[Floats], rows: Ints) -> Floats:
        """(n, size, width) central differences along the tangent scalars of the parameters."""
        parts = []
        for place in self.placed:
            state = states[place.use]
            additive = place.kind in ("real", "vec", "euler")
            for k in range(place.tangent):
                step = np.full(len(rows), STEP)
                if additive:
                    step *= np.maximum(1.0, np.abs(state[:, place.stored_start + k]))
                both = []
                for sign in (1.0, -1.0):
                    delta = np.zeros((len(rows), place.entity.tangent))
                    delta[:, place.tangent_start + k] = sign * step
                    moved = evaluate(place.entity.refresh, [*state.T, *delta.T])
                    there = list(states)
                    there[place.use] = np.stack(
                        [
                            np.broadcast_to(coordinate, len(rows))
                            for coordinate in moved[: state.shape[1]]
                        ],
                        axis=1,
                    )
                    residuals = self._called(self.code.function, there, rows, False)
                    residuals = residuals[0] if isinstance(residuals, tuple) else residuals
                    both.append(self._array(residuals, (len(rows), self.code.size), "residuals"))
                parts.append((both[0] - both[1]) / (2 * step[:, None]))
        return np.stack(parts, axis=2)

    # --- calls -----------------------------------------------------------------------------

    def _called(
        self, function: Any, states: Sequence[Floats], rows: Ints, derivatives: bool
    ) -> Any:
        code = self.code
        values = [self._values(place, states) for place in self.placed]
        data = {
            name: x if x.ndim == 0 or len(x) == len(rows) else np.repeat(x, len(rows), axis=0)
            for name, x in self._data.items()
        }
        if code.native is not None and function is code.function:
            return self._native(values, data, len(rows), derivatives)
        try:
            return function(*values, **data)
        except Exception as failure:
            raise self._failed(function, failure, values, data) from _without_us(failure)

    def _values(self, place: PlacedArgument, states: Sequence[Floats]) -> Floats:
        state = states[place.use]
        part = state[:, place.stored_start : place.stored_start + place.stored]
        return np.array(part.reshape(len(state), *place.argument.shape))

    def _native(self, values: list[Floats], data: dict[str, Any], n: int, derivatives: bool) -> Any:
        native = self.code.native
        assert native is not None
        wide = [
            np.ascontiguousarray(np.broadcast_to(x, (n,)) if x.ndim == 0 else x, dtype=np.float64)
            for x in data.values()
        ]
        wanted = derivatives and self.code.jacobian is not False
        result, residuals, jacobians = native(
            values, wide, self.code.size, self.widths if wanted else None
        )
        if result:
            at = self._instance(result - 1) if 0 < result <= n else "an unknown instance"
            raise FunctionError(
                Diagnostic(
                    "E0771",
                    f"the C function of `{self.code.label}` returned {result}: it failed for {at}",
                    origin=self.code.label,
                )
            )
        return (residuals, jacobians) if wanted else residuals

    def _failed(
        self, function: Callable[..., Any], failure: Exception, values: Any, data: Any
    ) -> FunctionError:
        """What the function raised, with the first instance for which it does."""
        at = _first_failing(function, failure, values, data)
        where = "" if at is None else f" for {self._instance(at)}"
        return FunctionError(
            Diagnostic(
                "E0771",
                f"the function of `{self.code.label}` raised {_shown(failure)}{where}",
                origin=self.code.label,
                notes=() if at is not None else ("not for a single instance of them",),
            )
        )

    def _instance(self, at: int) -> str:
        names = ", ".join(f"`{argument.name_at(at)}`" for argument in self.code.arguments)
        return f"instance {at} ({names})"

    def _not_finite(self, array: Floats, place: PlacedArgument, at: int, row: int) -> FunctionError:
        bad = np.argwhere(~np.isfinite(array[at]))[0]
        value = array[at][tuple(bad)]
        name = f"{place.argument.name_at(row)}"
        return FunctionError(
            Diagnostic(
                "E0772",
                f"the Jacobian of `{self.code.label}` is {value:g} for {self._instance(row)}: "
                f"residual {bad[0]} by coordinate {bad[1]} of `{name}`",
                origin=self.code.label,
                help=("the residuals are finite there: check the derivative",),
            )
        )

    def _wrong(self, message: str, help_: str) -> FunctionError:
        return FunctionError(
            Diagnostic(
                "E0772",
                f"the function of `{self.code.label}` {message}",
                origin=self.code.label,
                help=(help_,) if help_ else (),
            )
        )

    def _note(self, derivatives: str) -> None:
        """Remember where derivatives come from."""
        self.code.derivatives = derivatives


class UpdateHook:
    """Calls a function before each linearisation; an `arael.runtime.evaluation.hooks.Update`."""

    def __init__(self, update: CodeUpdate, placed: Sequence[tuple[int, PlacedArgument]]) -> None:
        self.update, self.placed = update, placed

    def __call__(self, rows_of: Callable[[int], Floats]) -> None:
        """Call the function with the values of its parameters at the accepted state."""
        values = []
        for entity, place in self.placed:
            states = rows_of(entity)
            refs = place.argument.refs
            rows = np.zeros(1, np.int64) if refs is None else refs.rows
            part = states[rows, place.stored_start : place.stored_start + place.stored]
            values.append(part.reshape(len(rows), *place.argument.shape))
        try:
            self.update.function(*values)
        except Exception as failure:
            raise FunctionError(
                Diagnostic(
                    "E0771",
                    f"`{self.update.label}`, called before a linearisation, raised "
                    f"{_shown(failure)}",
                    origin=self.update.label,
                )
            ) from _without_us(failure)


def _first_failing(
    function: Callable[..., Any], failure: Exception, values: Any, data: Any
) -> int | None:
    """The first instance for which the function raises the same; None if that is not one alone."""
    n = len(values[0])
    for at in range(min(n, _SEARCHED)):
        instance = slice(at, at + 1)
        try:
            function(
                *(x[instance] for x in values),
                **{k: x[instance] if x.ndim else x for k, x in data.items()},
            )
        except Exception as error:
            if type(error) is not type(failure):
                return None
            # Fails for the first alone, and for the next as well: it fails for all.
            if at == 0 and n > 1 and _raises(function, values, data, slice(1, 2)):
                return None
            return at
    return None


def _raises(function: Callable[..., Any], values: Any, data: Any, instance: slice) -> bool:
    try:
        function(
            *(x[instance] for x in values),
            **{k: x[instance] if x.ndim else x for k, x in data.items()},
        )
    except Exception:
        return True
    return False


def _shown(failure: Exception) -> str:
    text = " ".join(str(failure).split())
    return f"{type(failure).__name__}: {text:.200}" if text else type(failure).__name__


def _without_us(failure: Exception) -> Exception:
    """The exception with the frames of the caller's function alone."""
    trace = failure.__traceback__
    return failure.with_traceback(trace.tb_next if trace is not None else None)
