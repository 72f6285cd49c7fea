"""What uncertain data, constants and fixed parameters do to a solution ("consider" covariance).

The covariance of a solution counts the errors of the residuals alone and takes all else as exact.
Where data d has errors of its own with standard deviations s, independent of these,

    C = (J'J)^-1 + K diag(s^2) K',    K = dx/dd

with K by the implicit function theorem (B. Tapley, B. Schutz and G. Born, "Statistical orbit
determination", 2004, section 6.3: consider covariance analysis).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.sensitivities import Quantity, Sensitivities
from arael.diagnostics.arguments import as_numbers
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet

Floats = NDArray[np.float64]

MOST_SCALARS = 300
"""Most scalars that are taken if none are named: one solve and one sweep over the data each."""


class Propagation(Displayed):
    """Covariance of scalars of a solution with the errors of uncertain data.

    Attributes
    ----------
    names : (k,) of the scalars
    measured : (k, k) covariance by the errors of the residuals alone
    by : per path of uncertain data, what its errors add, (k, k)
    hessian : ``"Gauss-Newton"`` or ``"exact"``, of the derivatives by the data
    """

    def __init__(
        self, names: tuple[str, ...], measured: Floats, by: Mapping[str, Floats], hessian: str
    ) -> None:
        self.names, self.measured, self.by, self.hessian = names, measured, dict(by), hessian

    @property
    def covariance(self) -> Floats:
        """(k, k) with all errors."""
        found: Floats = np.sum([self.measured, *self.by.values()], axis=0)
        return found

    def sigma(self) -> Floats:
        """(k,) standard deviations with all errors."""
        return np.sqrt(self.covariance.diagonal())

    def _rows(self) -> list[tuple[str, ...]]:
        parts = [self.covariance, self.measured, *self.by.values()]
        columns = np.sqrt([part.diagonal() for part in parts])
        return [
            (name, *(f"{value:.3g}" for value in column))
            for name, column in zip(self.names, columns.T, strict=True)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "names": list(self.names),
            "hessian": self.hessian,
            "sigma": self.sigma().tolist(),
            "measured": np.sqrt(self.measured.diagonal()).tolist(),
            "by": {k: np.sqrt(one.diagonal()).tolist() for k, one in self.by.items()},
        }

    def _sheet(self) -> Sheet:
        head = ("parameter", "standard error", "residuals", *self.by)
        title = f"standard errors with uncertain data ({self.hessian} Hessian)"
        return Sheet(title, head, self._rows())

    def __repr__(self) -> str:
        return f"<Propagation to {len(self.names)} scalars of {', '.join(self.by) or 'nothing'}>"

    def __str__(self) -> str:
        sheet = self._sheet()
        table = [tuple(sheet.head), *self._rows()]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = [
            "  " + "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])])
            for row in table
        ]
        return "\n".join([sheet.title, *lines])


def propagate(
    sensitivities: Sensitivities,
    quantity: Quantity,
    uncertain: Mapping[str, Any],
    exact: bool,
) -> Propagation:
    """Covariance of a quantity with uncertain data; see `arael.Result.propagate`."""
    measured = quantity.by_parameters @ sensitivities.system.solved(quantity.by_parameters.T)
    hessian = "exact" if exact else "Gauss-Newton"
    if not uncertain:
        return Propagation(quantity.names, measured, {}, hessian)
    found = sensitivities.of(quantity, list(uncertain), exact)
    by = {}
    for path, given in uncertain.items():
        if path not in found:
            raise _wrong(f"`{path}` has several columns", "name each of them")
        values = found[path] if not quantity.single else found[path][None]
        sigma = as_numbers(given, "propagate", f"uncertain[{path!r}]")
        if not (np.isfinite(sigma) & (sigma >= 0)).all():
            raise _wrong(f"a standard deviation of `{path}` is negative or not finite", "")
        try:
            spread = np.broadcast_to(sigma, values.shape[1:])
        except ValueError:
            raise _wrong(
                f"the standard deviations of `{path}` have shape {sigma.shape}",
                f"give one number, or an array of shape {values.shape[1:]}",
            ) from None
        scaled = (values * spread).reshape(len(values), -1)
        by[path] = scaled @ scaled.T
    return Propagation(quantity.names, measured, by, hessian)


def all_scalars(sensitivities: Sensitivities) -> Quantity:
    """All scalars that were solved for, if they are not too many."""
    system = sensitivities.system
    if len(system.free) > MOST_SCALARS:
        raise _wrong(
            f"{len(system.free)} scalars were solved for: name those of interest",
            'for example `of="cam.f"`, or several: `of=["cam.f", "poses[3]"]`',
        )
    names = system.names
    unit = np.zeros((len(system.free), sensitivities.problem.size))
    unit[np.arange(len(system.free)), system.free] = 1
    return Quantity("", tuple(names[k] for k in system.free), unit)


def _wrong(message: str, advice: str) -> AraelError:
    help = (advice,) if advice else ()
    return AraelError(Diagnostic("E1060", message, origin="propagate", help=help))
