"""What `Model.marginalise` does to a model, and what it refuses."""

from __future__ import annotations

import gc
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.explain import explain
from arael.diagnostics.records import AraelError
from arael.io import DataWarning

MODEL = """
struct Pose {
    param p: vec2
    param a: angle
    previous: ref Pose in root.poses?
    marks: list of Mark
    constraint turn when previous { (a - previous.a - 0.1) * 50 }
}
struct Mark { param q: vec2 }
struct Step {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    d: vec2
    constraint step { (b.p - a.p - a.a.rotation_matrix() * d) * 10 }
}
struct Sight {
    pose: ref Pose in root.poses
    mark: ref Mark in pose.marks
    d: vec2
    constraint sight { (mark.q - pose.p - d) * 5 }
}
struct Fix {
    pose: ref Pose in root.poses
    d: vec2
    constraint fix { (pose.p - d * root.scale) }
    constraint heading { pose.a * 3 }
}
struct Follower {
    param x: real
    leader: ref Pose in root.poses
    constraint follow { x - leader.a }
}
root Path {
    poses: deque of Pose
    steps: deque of Step
    sights: list of Sight
    fixes: list of Fix
    followers: list of Follower
    param scale: real = 1
    constraint unit { (scale - 1) * 10 }
}
"""


@pytest.fixture(scope="module")
def kind() -> Any:
    return arael.loads(MODEL, name="path", interpret=True)


def path_of(kind: Any, count: int = 6) -> Any:
    rng = np.random.default_rng(count)
    model = kind()
    for k in range(count):
        pose = model.poses.append(p=rng.normal([k, 0.1 * k], 0.1), a=0.1 * k)
        if k:
            pose.previous = model.poses[k - 1]
            model.steps.append(a=model.poses[k - 1], b=pose, d=[1, 0])
    model.fixes.append(pose=0, d=[0.1, 0.1])
    return model


def test_constraints_of_what_leaves_become_one_prior(kind: Any) -> None:
    model = path_of(kind)
    model.solve()
    before = model.covariance()
    stays = model.poses[2]
    expected = before.marginal(stays)
    prior = model.marginalise(model.poses[:2])
    assert prior.label == "prior"
    assert list(model.residuals.priors) == ["prior"]
    assert (len(model.poses), len(model.steps), len(model.fixes)) == (4, 3, 0)
    assert stays.previous is None
    assert {a.name_at(0) for a in prior.arguments} == {"poses[0].p", "poses[0].a", "scale"}
    assert model.covariance().marginal(stays) == pytest.approx(expected, rel=1e-8)


def test_the_prior_is_seen_by_tables_reports_and_residual_values(kind: Any) -> None:
    model = path_of(kind)
    prior = model.marginalise(model.poses[0])
    table = model.cost_table()
    assert table["prior"] == pytest.approx(prior.cost)
    assert table.instances["prior"] == len(prior.function.residual)
    assert model.residual_values("prior").raw.ravel() == pytest.approx(prior.residuals.ravel())
    assert model.report().statistics.cost == pytest.approx(model.cost())
    assert all(check.agrees for check in model.check_gradients())


def test_all_solvers_see_the_prior(kind: Any) -> None:
    found = []
    for solver in ("dense", "sparse", "schur"):
        model = path_of(kind)
        model.marginalise(model.poses[:2])
        model.solve(solver=solver)
        found.append(np.column_stack([model.poses.p.value, model.poses.a.value]))
    assert found[1] == pytest.approx(found[0], abs=1e-7)
    assert found[2] == pytest.approx(found[0], abs=1e-7)


@pytest.mark.slow
def test_a_step_of_a_window_has_constant_cost(kind: Any) -> None:
    model = path_of(kind, 8)
    sizes, counts = set(), set()
    for step in range(300):
        model.marginalise(model.poses[0])
        last = model.poses[-1]
        new = model.poses.append(p=np.add(last.p.value, [1, 0.1]), a=0.1, previous=last)
        model.steps.append(a=last, b=new, d=[1, 0])
        if step % 29 == 10:
            problem = model._problem()
            one = model.residuals.priors
            sizes.add(
                (
                    tuple((k, v.function.jacobian.shape) for k, v in one.items()),
                    problem.size,
                    problem.structure.pattern.value_count,
                    len(problem.layout.groups),
                    tuple(table.size for table in model._store.tables.values()),
                )
            )
        if step in (100, 299):
            gc.collect()
            counts.add(sum(str(type(o).__module__).startswith("arael.") for o in gc.get_objects()))
    assert len(sizes) == 1
    assert max(counts) - min(counts) < 100  # of 199 steps: less than one object a step


def test_priors_apart_stay_apart_and_those_within_are_merged(kind: Any) -> None:
    model = path_of(kind, 9)
    model.scale.fixed = True
    model.fixes.append(pose=8, d=[8, 1])
    model.marginalise(model.poses[0])
    model.marginalise(model.poses[-1])
    assert list(model.residuals.priors) == ["prior", "prior_2"]
    model.marginalise(model.poses[3])
    assert list(model.residuals.priors) == ["prior", "prior_2", "prior_3"]
    model.marginalise(model.poses[1:-1])
    (prior,) = model.residuals.priors.values()
    assert prior.function.jacobian.shape == (6, 6)


def test_nested_rows_leave_with_their_owner(kind: Any) -> None:
    model = path_of(kind, 3)
    model.poses[0].marks.append(q=[1, 1])
    mark = model.poses[1].marks.append(q=[1, 1])
    model.sights.append(pose=0, mark=0, d=[1, 1])
    model.sights.append(pose=1, mark=0, d=[1, 1])
    model.marginalise(model.poses[0])
    assert len(model.poses.marks) == 1
    assert mark.is_valid
    assert len(model.sights) == 1


def test_a_free_chain_leaves_no_prior(kind: Any) -> None:
    model = path_of(kind, 3)
    model.poses.previous = None
    model._store.tables["fixes"].clear()
    assert model.marginalise(model.poses[0]) is None
    assert model.residuals.priors == {}
    assert len(model.steps) == 1


def test_a_copy_and_a_pickle_keep_the_prior(kind: Any) -> None:
    model = path_of(kind)
    model.marginalise(model.poses[:2])
    for other in (model.copy(), pickle.loads(pickle.dumps(model))):
        assert other.cost() == model.cost()
        other.marginalise(other.poses[0])
        assert list(other.residuals.priors) == ["prior"]
    assert len(model.poses) == 4


def test_json_keeps_the_prior(kind: Any, tmp_path: Path) -> None:
    model = path_of(kind)
    for pose in (3, 2, 3):
        model.poses[pose].marks.append(q=[1, 1])
        model.sights.append(pose=pose, mark=len(model.poses[pose].marks) - 1, d=[1, 1])
    model.marginalise([model.poses[3], *model.poses[:2]])
    model.poses[0].p.value = model.poses[0].p.value + 0.3
    model.write(tmp_path / "m.json")
    other = kind()
    other.read(tmp_path / "m.json")
    assert other.cost() == pytest.approx(model.cost(), rel=1e-14)
    assert other.hessian() == pytest.approx(model.hessian(), rel=1e-12)
    other.write(tmp_path / "n.json")
    assert (tmp_path / "n.json").read_bytes() == (tmp_path / "m.json").read_bytes()
    # Data without priors replaces them.
    path_of(kind).write(tmp_path / "plain.json")
    other.read(tmp_path / "plain.json")
    assert other.residuals.priors == {}


def test_other_formats_warn(kind: Any, tmp_path: Path) -> None:
    model = path_of(kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.write(tmp_path / "m.npz")
    model.marginalise(model.poses[0])
    with pytest.warns(DataWarning, match="no place for priors"):
        model.write(tmp_path / "m.npz")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ('[{"name": "prior"}]', "not a list of priors"),
        ("3", "not a list of priors"),
        ('[{"name": "a b", "parameters": []}]', "cannot be a name"),
        (
            '[{"name": "p", "parameters": [{"collection": "poses", "row": 0, "parameter": "z"}]}]',
            "`poses.z`, which is no parameter",
        ),
        (
            '[{"name": "p", "parameters": [{"collection": "poses", "row": 7, "parameter": "a"}]}]',
            "row 7 of `poses`: out of range",
        ),
        (
            '[{"name": "p", "residual": [1], "jacobian": [[1, 2]], "parameters": '
            '[{"collection": "poses", "row": 0, "parameter": "a", "at": [0]}]}]',
            "not an array of 1 x 1 finite numbers",
        ),
    ],
)
def test_priors_of_a_file_that_do_not_fit(
    kind: Any, tmp_path: Path, wrong: str, message: str
) -> None:
    model = path_of(kind, 2)
    model.write(tmp_path / "m.json")
    text = (tmp_path / "m.json").read_text()
    (tmp_path / "m.json").write_text(text.rstrip().removesuffix("}") + f', "$priors": {wrong}}}')
    with pytest.raises(AraelError, match="E0783") as caught:
        model.read(tmp_path / "m.json")
    assert message in str(caught.value)
    assert len(model.poses) == 2


def test_what_is_no_row_is_refused(kind: Any) -> None:
    model, other = path_of(kind, 3), path_of(kind, 3)
    for wrong in (0, "poses", [0], model.poses.p, {"a": 1}):
        with pytest.raises(AraelError, match=r"E0780.*expected rows"):
            model.marginalise(wrong)
    with pytest.raises(AraelError, match=r"E0780.*another model"):
        model.marginalise(other.poses[0])
    with pytest.raises(AraelError, match=r"E0780.*cannot be a name"):
        model.marginalise(model.poses[0], name="a b")
    ref = model.poses[0]
    model.marginalise(ref)
    with pytest.raises(AraelError, match="E0709"):
        model.marginalise(ref)


def test_references_from_what_stays_are_refused(kind: Any) -> None:
    model = path_of(kind, 3)
    model.followers.append(x=0, leader=0)
    with pytest.raises(AraelError, match=r"E0781.*followers\[0\].leader.*poses\[0\]"):
        model.marginalise(model.poses[0])
    assert len(model.poses) == 3
    model.marginalise([model.poses[0], model.followers[0]])
    assert (len(model.poses), len(model.followers)) == (2, 0)


def test_residuals_added_at_run_time_are_refused(kind: Any) -> None:
    model = path_of(kind, 3)
    model.add_residuals(lambda a: a, [model.poses.a], name="own")
    with pytest.raises(AraelError, match=r"E0781.*`own`, added at run time"):
        model.marginalise(model.poses[0])
    model.residuals.remove("own")
    model.before_linearisation(lambda a: None, [model.poses[0].a], name="seen")
    with pytest.raises(AraelError, match=r"E0781.*`seen`"):
        model.marginalise(model.poses[0])


def test_both_spellings(kind: Any) -> None:
    model = path_of(kind, 3)
    assert model.marginalize(model.poses[0]).label == "prior"


def test_a_fixed_neighbour_is_known(kind: Any) -> None:
    model = path_of(kind, 3)
    model.poses[1].p.fixed = True
    prior = model.marginalise(model.poses[0])
    assert "p" not in {a.column for a in prior.arguments}


def test_pages_explain_the_errors() -> None:
    for code in ("E0780", "E0781", "E0782", "E0783"):
        assert explain(code).startswith(f"# {code}: ")
