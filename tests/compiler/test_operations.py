"""Operations that shipped models take: bounds that a change of the symbolic core must keep."""

from __future__ import annotations

import pytest

from arael.compiler.compilation import compile_text
from arael.loading import standard_models
from arael.syntax.files import read_source
from tests.symbolic.programs import between_factor, jacobian_program

# For residuals, derivatives, J'J and J'r, signs not counted: what an engine without SymPy took, and
# for pose graphs, of priors and landmarks, what these took when they were added.
MOST = {
    "bundle_adjustment": {
        "Observation.reprojection": 429,
    },
    "linear": {
        "LinearModel.data": 17,
    },
    "localization": {
        "Pose.drift": 20,
        "Pose.tilt": 7,
        "PosePair.odometry": 834,
        "PointFrine.bearing": 262,
    },
    "plane_slam": {
        "Observation.plane": 238,
        "PosePair.odometry": 616,
        "Anchor.prior": 173,
    },
    "pose_graph_2d": {
        "Edge.between": 167,
        "Anchor.prior": 80,
        "Observation.observed": 67,
        "Bearing.sighted": 46,
        "LandmarkAnchor.prior": 23,
    },
    "pose_graph_3d": {
        "Edge.between": 1318,
        "Anchor.prior": 810,
        "Observation.observed": 243,
        "LandmarkAnchor.prior": 63,
    },
    "slam": {
        "Pose.gps": 96,
        "Pose.drift": 20,
        "Pose.tilt": 7,
        "PointLandmark.drift": 10,
        "PosePair.odometry": 834,
        "PointFrine.bearing": 262,
    },
}


@pytest.mark.sweep(4)
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("name", MOST)
def test_no_constraint_takes_more_operations(name: str, precision: str) -> None:
    made = compile_text(read_source(standard_models()[name]), precision=precision)
    found = {
        k.group.label: sum(op not in ("input", "const", "neg") for op in k.linearise.ops)
        for k in made.program.kernels
    }
    assert found.keys() == MOST[name].keys()
    assert {label: n for label, n in found.items() if n > MOST[name][label]} == {}


def test_the_between_factor_of_poses() -> None:
    graph, outputs, seeds = between_factor()
    tape = jacobian_program(graph, outputs, seeds)
    assert sum(op not in ("input", "const", "neg") for op in tape.ops) <= 421
