"""Sorting instances by the lead of their constraint and accumulating its blocks is not seen."""

from pathlib import Path

import numpy as np
import pytest

from arael.compiler.lead import leading
from arael.loading import load
from arael.model import Model
from arael.runtime.layout import Slot, Step, Use
from arael.runtime.problem import Problem
from tests.compiler.test_kernels import check_against_oracle, problems

TEXT = """
struct Pose { param p: vec3; param ea: euler }
struct Point { param p: vec2 }
struct Seen {
    pose:  ref Pose in root.poses
    point: ref Point in root.points
    z:     vec2
    constraint seen {
        let r = pose.ea.rotation_matrix() * [point.p.x, point.p.y, 1] + pose.p
        [r.x / (3 + r.z ^ 2) - z.x * root.scale, r.y / (3 + r.z ^ 2) - z.y, pose.ea.y * point.p.x]
    }
    constraint near when pose.p.x > point.p.x { sin(pose.p - [point.p.x, point.p.y, z.x]) }
}
struct Between {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    constraint between { [a.ea.rotation_matrix() * (b.p - a.p), b.ea - a.ea .* a.p] }
}
root World : PRECISION {
    points: list of Point
    poses:  list of Pose
    seen:   list of Seen
    edges:  list of Between
    param scale: real
}
"""


def world(path: Path, precision: str, observations: int, poses: int = 4) -> Model:
    """Observations in no order, some of them of fixed poses and points."""
    file = path / "world.arael"
    file.write_text(TEXT.replace("PRECISION", precision))
    model = load(file)()
    rng = np.random.default_rng(11)
    model.scale = 0.7
    model.poses.extend(p=rng.normal(size=(poses, 3)), ea=0.3 * rng.normal(size=(poses, 3)))
    model.points.extend(p=rng.normal(size=(9, 2)))
    model.poses[0].p.fixed = True
    model.poses[0].ea.fixed = True
    model.poses[1].p.fixed = True
    model.points[3].p.fixed = True
    model.seen.extend(
        pose=rng.integers(poses, size=observations),
        point=rng.integers(9, size=observations),
        z=rng.normal(size=(observations, 2)),
    )
    ends = rng.integers(poses, size=(21, 2))
    model.edges.extend(a=ends[:, 0], b=ends[:, 1])
    return model


def group(problem: Problem, label: str) -> int:
    """Number of a group."""
    return [g.label for g in problem.layout.groups].index(label)


@pytest.mark.sweep(slow=("0-f32-5e-05", "203-f32-5e-05", "5-f32-5e-05"))
@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-12), ("f32", 5e-5)])
@pytest.mark.parametrize("observations", [0, 5, 203])
def test_sorted_kernels_agree_with_the_interpreter(
    tmp_path: Path, precision: str, tolerance: float, observations: int
) -> None:
    check_against_oracle(world(tmp_path, precision, observations), tolerance)


def test_instances_are_sorted_by_the_pose_and_found_under_their_own_numbers(
    tmp_path: Path,
) -> None:
    compiled, interpreted = problems(world(tmp_path, "f64", 203))
    number = group(compiled, "Seen.seen")
    placement = compiled.structure.placements[number]
    rows, blocks = placement.rows, placement.block_at[:, 1]
    (plan,) = (s for s in compiled.structure.plan.shares if s.orders[number] is not None)
    order = plan.orders[number]
    assert compiled.layout.groups[number].lead == (0, 2)
    assert (np.diff(rows[order, 0]) >= 0).all()
    # Within a pose, first the first writers of a block, then the others, both in their order.
    for pose in range(4):
        seen = order[rows[order, 0] == pose]
        solved = blocks[seen] != compiled.structure.pattern.value_count
        met = np.array([blocks[k] in blocks[:k] for k in seen]) & solved
        assert met.any() == (pose != 0)  # which is fixed
        assert (np.diff(met.astype(int)) >= 0).all()
        assert all((np.diff(seen[met == later]) > 0).all() for later in (False, True))
    near = group(compiled, "Seen.near")
    compiled.cost()
    interpreted.cost()
    acting = compiled.evaluation.acting(near)
    np.testing.assert_array_equal(acting, interpreted.evaluation.acting(near))
    assert 20 < acting.sum() < 180


def test_lead_is_what_instances_share() -> None:
    own, ref, other = (
        Slot((), "obs"),
        Slot((Step("ref", "a"),), "a"),
        Slot((Step("ref", "b"),), "b"),
    )
    root = Slot((Step("root"),), "")
    slots = (own, ref, other, root)
    tables, tangents = ("a", "b", "obs", ""), (3, 6, 9, 2)

    def lead(*uses: tuple[int, int]) -> tuple[int, ...]:
        return leading([Use(*use) for use in uses], slots, tables, tangents)

    assert lead((1, 0), (2, 1)) == (1,)  # the larger
    assert lead((0, 2), (1, 0)) == (1,)  # not what is an instance's own
    assert lead((1, 0), (2, 0)) == ()  # the two ends of an edge
    assert lead((3, 3), (1, 0)) == (1, 0)  # the root along with it
    assert lead((3, 3)) == (0,)
