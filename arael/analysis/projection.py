"""Uncertainty of projection: where in a picture a calibrated camera can be trusted.

For each pixel of a grid and each view the point of the target is sought that is seen there. How the
pixel of that point changes with all parameters, its pose in the view included, is averaged over the
views: what all views share is the camera. The covariance of the parameters then gives that of the
pixel (D. Kogan, mrcal, "Projection uncertainty", 2020). The pose of the target alone, which could
compensate an error of the camera, has no part in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.jacobian import jacobian
from arael.analysis.normal import NormalEquations
from arael.analysis.variations import Experiments
from arael.analysis.weakness import MANY
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.failures import refuse_required
from arael.runtime.system import row_name

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_VIEWS = 12
"""Most views that are averaged."""
_ACROSS = 24
"""Cells of the grid along the wider side."""
_FOUND = 1e-3
"""Largest residual, in sigmas, of a point that was found for a pixel."""
_ROUNDS = 15
"""Gauss-Newton steps in the search of a point."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Uncertainty over the picture of one camera.

    Attributes
    ----------
    camera : its row, ``cameras[0]``, or the root
    x, y : (nx,), (ny,) coordinates of the grid
    sigma : (ny, nx) standard deviation of a projection in the direction of the largest; NaN where
        no view has a point that is seen there
    seen : (n, 2) measured pixels
    noise : standard deviation of a measured pixel that the model assumes
    """

    camera: str
    x: Floats
    y: Floats
    sigma: Floats
    seen: Floats
    noise: float

    def at(self, x: float, y: float) -> float:
        """Standard deviation at the nearest cell of the grid."""
        row, column = np.argmin(np.abs(self.y - y)), np.argmin(np.abs(self.x - x))
        return float(self.sigma[row, column])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; None where nothing is known."""
        cells = [[None if np.isnan(v) else float(v) for v in row] for row in self.sigma]
        return {"camera": self.camera, "x": self.x.tolist(), "y": self.y.tolist(), "sigma": cells}


def projection_uncertainty(
    model: Any, size: tuple[float, float] | None = None
) -> tuple[Projection, ...]:
    """Uncertainty over the picture of each camera; see `arael.Model.projection_uncertainty`."""
    problem = model._problem()
    refuse_required(problem.layout, "projection uncertainty", "ask `covariance()` of the cameras")
    equations = NormalEquations(problem, hold_bounds=True)
    kept = np.isin(problem.free, equations.free)
    experiments = Experiments(model, kept)
    found = _Pictures(experiments)
    # A root of C: the variance of a row j of the Jacobian is |j C^(1/2)|^2.
    values, vectors = np.linalg.eigh(equations.covariance()[0])
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return tuple(found.of(camera, size, root) for camera in found.cameras)


class _Pictures:
    """The measured pixels of a model, by camera and view."""

    def __init__(self, experiments: Experiments) -> None:
        self.experiments = experiments
        store, layout = experiments.store, experiments.layout
        place = next(iter(experiments.pixels()), None)
        if place is None:
            raise _refused("no measured pixels: a column of two numbers that no derivative reads")
        self.table, pixel = place
        own = layout.table(self.table)
        self.pixel = own.column(pixel)
        point = next(
            (
                c
                for c in experiments.varied(self.table)
                if c.shape in ((2,), (3,)) and c.path != pixel
            ),
            None,
        )
        if point is None:
            raise _refused(f"`{self.table}` has no point of the target that could be moved")
        self.point = point
        rows = store.tables[self.table]
        self.view = np.zeros(rows.size, dtype=np.int64)
        self._camera = np.zeros(rows.size, dtype=np.int64)
        self._cameras = ""
        most = 0
        moving = {entity.table for entity in layout.entities}
        refs = [c for c in own.columns if c.role == "ref" and c.target is not None]
        for column in refs:
            assert column.target is not None
            path = column.target.table
            count = store.tables[path].size
            if path not in moving:
                continue
            target = np.asarray(rows.target_rows(column.path))
            if count > most:
                most, self.view = count, target
        for column in refs:
            assert column.target is not None
            path, target = column.target.table, np.asarray(rows.target_rows(column.path))
            few = store.tables[path].size <= MANY and not np.array_equal(target, self.view)
            if path in moving and few and not self._cameras:
                self._cameras, self._camera = path, target
        self.cameras = np.unique(self._camera).tolist()

    def of(self, camera: int, size: tuple[float, float] | None, root: Floats) -> Projection:
        """Uncertainty over the picture of one camera."""
        store = self.experiments.store
        mine = np.flatnonzero(self._camera == camera)
        pixel = np.asarray(store.tables[self.table].column(self.pixel.path))[mine]
        low, high = pixel.min(axis=0), pixel.max(axis=0)
        whole = np.maximum(low + high, high) if size is None else np.asarray(size, dtype=float)
        cells = np.maximum(2, np.round(_ACROSS * whole / whole.max())).astype(int)
        x, y = ((np.arange(n) + 0.5) * w / n for n, w in zip(cells, whole, strict=True))
        grid = np.array([(a, b) for b in y for a in x])
        views = np.unique(self.view[mine])
        views = views[np.linspace(0, len(views) - 1, min(len(views), _VIEWS)).astype(int)]
        sources, wanted = [], []
        for view in views:
            own = mine[self.view[mine] == view]
            there = np.asarray(store.tables[self.table].column(self.pixel.path))[own]
            nearest = np.linalg.norm(grid[:, None] - there[None], axis=2).argmin(axis=1)
            sources.append(own[nearest])
            wanted.append(grid)
        slopes, found, noise = self._predictions(np.concatenate(sources), np.concatenate(wanted))
        slopes = slopes.reshape(len(views), len(grid), 2, -1)
        found = found.reshape(len(views), len(grid), 1, 1)
        count = found.sum(axis=0)
        mean = np.where(found, slopes, 0.0).sum(axis=0) / np.maximum(count, 1)
        spread = mean @ root
        values = np.linalg.eigvalsh(spread @ np.swapaxes(spread, 1, 2))[:, -1]
        sigma = np.where(count[:, 0, 0] > 0, np.sqrt(np.maximum(values, 0.0)), np.nan)
        name = row_name(store, self._cameras, camera) if self._cameras else ""
        return Projection(
            name or self.experiments.layout.name,
            x,
            y,
            sigma.reshape(len(y), len(x)),
            pixel,
            noise,
        )

    def _predictions(
        self, sources: Ints, pixels: Floats
    ) -> tuple[Floats, NDArray[np.bool_], float]:
        """Derivatives of predictions of given pixels.

        Parameters
        ----------
        sources : (n,) rows whose view and camera are taken
        pixels : (n, 2) what shall be predicted, by another point of the target

        Returns
        -------
        (n, 2, k) derivatives by the kept scalars; (n,) whether there is such a point; the
        standard deviation of a measured pixel.
        """
        base = self.experiments
        trial = Experiments(base.model, base.kept)
        self._take_rows(trial, sources, pixels)
        groups = list(trial.layout.readers[self.table, self.pixel.path])
        trial.correct(groups, [(self.table, self.point.path)], _ROUNDS)
        problem = trial.model._problem()
        rows = jacobian(problem)
        at, residuals = trial.residuals(groups)
        # The derivatives of residuals by the measured pixel: what whitens them, negative.
        live = trial.store.tables[self.table].column(self.pixel.path)
        weights = np.zeros((len(sources), residuals.shape[1], 2))
        for k in range(2):
            live[:, k] += 1.0
            weights[at, :, k] = residuals - trial.residuals(groups)[1]
            live[:, k] -= 1.0
        good = np.zeros(len(sources), dtype=bool)
        good[at] = np.abs(residuals).max(axis=1) < _FOUND
        slopes = np.zeros((len(sources), 2, np.count_nonzero(base.kept)))
        found = np.zeros(len(sources), dtype=bool)
        ends = np.cumsum([0, *(len(active) for active in problem.structure.active)])
        noise: list[float] = []
        first = 0
        for number in groups:
            columns = slice(first, first + trial.layout.groups[number].residuals)
            first = columns.stop
            if trial.layout.groups[number].residuals != 2:
                continue
            mine = (rows.constraint >= ends[number]) & (rows.constraint < ends[number + 1])
            instance = rows.constraint[mine][::2] - ends[number]
            row = problem.structure.active[number][instance]
            own = rows.matrix[np.flatnonzero(mine)][:, np.flatnonzero(base.kept)].toarray()
            own = own.reshape(len(row), 2, slopes.shape[2])
            weight = weights[row, columns]
            usable = good[row] & np.isfinite(own).all(axis=(1, 2))
            area = np.abs(np.linalg.det(weight))
            usable &= area > 0
            noise += (1 / np.sqrt(area[usable])).tolist()
            slopes[row[usable]] = np.linalg.solve(weight[usable], own[usable])
            found[row[usable]] = True
        return slopes, found, float(np.median(noise)) if noise else math.nan

    def _take_rows(self, trial: Experiments, sources: Ints, pixels: Floats) -> None:
        """Replace the rows of the collection by copies of some, with other pixels."""
        own, layout = trial.store.tables[self.table], trial.layout.table(self.table)
        columns: dict[str, Any] = {}
        for column in layout.columns:
            if column.role == "ref":
                columns[column.path] = np.asarray(own.target_rows(column.path))[sources]
            elif column.role == "data":
                columns[column.path] = np.asarray(own.column(column.path))[sources].copy()
        columns[self.pixel.path] = pixels
        parents = np.asarray(own.parent_rows())[sources] if layout.parent else None
        own.clear()
        own.extend(len(sources), parents, **columns)


def _refused(message: str) -> AraelError:
    advice = "the picture is for models with a column such as `pixel: vec2 [px]`"
    return AraelError(Diagnostic("E0791", message, origin="projection", help=(advice,)))
