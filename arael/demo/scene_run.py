"""Solves a synthetic scene and compares it with the truth; shared by two demos."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import rotation_matrix
from arael.plot.sparsity import hessian_pattern
from arael.runtime.layout import Layout
from arael.scenes import Scene, SceneConfig, columns, fill, make_scene

Array = NDArray[np.float64]

DENSE_LIMIT = 12_000
"""Uncertainties come from the dense Hessian; with more parameters they are omitted."""

ModelName = Literal["slam", "localization"]


@dataclass(frozen=True)
class SolveOptions:
    """Solve options of a demo.

    Attributes
    ----------
    model : name or file of the model; None: the standard one
    solver : linear solver, as `Model.solve` takes it
    precision : ``"f32"``, ``"f64"`` or None for the declaration of the model
    threads : 0 for all
    verbose : trace every step on stderr
    """

    model: str | None = None
    solver: str = "auto"
    precision: Literal["f32", "f64"] | None = None
    threads: int = 1
    verbose: bool = True


@dataclass(frozen=True)
class SceneRun:
    """A scene, the solved model instance, and the result of the solve."""

    scene: Scene
    instance: Any
    layout: Layout
    result: Any

    @cached_property
    def poses(self) -> Array:
        """Solved positions (n, 3) [m]."""
        return np.array(self.instance.poses.pos.value, dtype=np.float64)

    @cached_property
    def rotations(self) -> Array:
        """Solved attitudes (n, 3, 3), body to world."""
        return rotation_matrix(np.array(self.instance.poses.ea.value, dtype=np.float64))

    @cached_property
    def hessian(self) -> Array:
        """Gauss-Newton Hessian (p, p) at the solution, dense."""
        return np.asarray(self.instance.hessian(), dtype=np.float64)

    @property
    def parameters(self) -> int:
        """Number of scalars solved for."""
        return sum(
            entity.tangent * len(self.instance[entity.table]) for entity in self.layout.entities
        )

    @cached_property
    def bearing_costs(self) -> Array:
        """Robust cost (observations, 2) of every bearing residual at the solution."""
        mine = self.jacobian.label_of == self.jacobian.labels.index("PointFrine.bearing")
        costs: Array = self.jacobian.residuals[mine].reshape(-1, 2) ** 2
        return costs

    @cached_property
    def jacobian(self) -> Any:
        """Jacobian at the solution."""
        return self.instance.jacobian()

    @cached_property
    def pattern(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of the entries of the Hessian."""
        return hessian_pattern(self.jacobian)


def solve_scene(name: ModelName, config: SceneConfig, options: SolveOptions) -> SceneRun:
    """Generate the scene of `config`, solve it with `name`, or the model of `options`."""
    scene = make_scene(config)
    model: Any = arael.load(options.model or name, precision=options.precision)
    instance = model()
    fill(instance, model.layout, columns(scene, name))
    settings = arael.LmConfig(verbose=options.verbose, num_threads=options.threads)
    result = instance.solve(config=settings, solver=options.solver)
    return SceneRun(scene, instance, model.layout, result)
