"""The errors of `tests.metrics.cases` by evo: prints the file that `test_figures.py` compares with.

python -m tests.metrics.evo_figures > tests/metrics/evo_figures.json
"""

from __future__ import annotations

import copy
import json
import warnings
from importlib import metadata
from typing import Any

from tests.metrics.cases import ALIGNMENTS, DELTAS, SEEDS, pair

PARTS = {
    "translation": "translation_part",
    "rotation": "rotation_part",
    "full": "full_transformation",
    "angle_deg": "rotation_angle_deg",
    "angle_rad": "rotation_angle_rad",
    "distance": "point_distance",
    "distance_ratio": "point_distance_error_ratio",
}
UNITS = {"frames": "frames", "m": "meters", "deg": "degrees", "rad": "radians"}


def theirs(trajectory: Any) -> Any:
    """A trajectory of evo."""
    from evo.core.trajectory import PoseTrajectory3D

    return PoseTrajectory3D(
        trajectory.positions.copy(), trajectory.quaternions.copy(), trajectory.times.copy()
    )


def associated(seed: int) -> tuple[Any, Any]:
    """The pair of a seed as evo associates it."""
    from evo.core.sync import associate_trajectories

    reference, estimate = pair(seed)
    found: tuple[Any, Any] = associate_trajectories(
        theirs(reference), theirs(estimate), max_diff=0.01, offset_2=0.001
    )
    return found


def aligned(reference: Any, estimate: Any, how: str) -> Any:
    """The estimate after an alignment by evo."""
    moved = copy.deepcopy(estimate)
    if how == "origin":
        moved.align_origin(reference)
    elif how != "none":
        moved.align(
            reference,
            correct_scale=how == "similarity",
            correct_only_scale=how == "scale",
            n=10 if how == "first 10" else -1,
        )
    return moved


def absolute(reference: Any, estimate: Any, part: str) -> dict[str, float]:
    """Statistics of evo's absolute pose error."""
    from evo.core.metrics import APE, PoseRelation

    metric = APE(PoseRelation[PARTS[part]])
    metric.process_data((reference, estimate))
    return {k: float(v) for k, v in metric.get_all_statistics().items()}


def relative(
    reference: Any, estimate: Any, part: str, delta: float, unit: str, **options: Any
) -> dict[str, float] | None:
    """Statistics of evo's relative pose error; None where it finds no pairs."""
    from evo.core.filters import FilterException
    from evo.core.metrics import RPE, PoseRelation, Unit

    metric = RPE(PoseRelation[PARTS[part]], delta, Unit[UNITS[unit]], 0.1, **options)
    try:
        metric.process_data((reference, estimate))
    except FilterException:
        return None
    return {k: float(v) for k, v in metric.get_all_statistics().items()}


def figures() -> dict[str, Any]:
    """RMSE, mean, median, standard deviation, extremes and sums of squares of all cases."""
    found: dict[str, Any] = {"evo": metadata.version("evo"), "ate": {}, "rpe": {}}
    for seed in SEEDS:
        reference, estimate = associated(seed)
        for how in ALIGNMENTS:
            moved = aligned(reference, estimate, how)
            for part in ("translation", "rotation", "full", "angle_deg"):
                found["ate"][f"{seed} {how} {part}"] = absolute(reference, moved, part)
        for delta, unit in DELTAS:
            for part in ("translation", "rotation", "full", "angle_deg", "distance_ratio"):
                key = f"{seed} {delta:g} {unit} {part}"
                found["rpe"][key] = relative(reference, estimate, part, delta, unit)
    return found


if __name__ == "__main__":
    with warnings.catch_warnings(action="ignore"):
        print(json.dumps(figures(), indent=0))
