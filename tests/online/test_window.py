"""A window: `Model.marginalise` from the factor of `Model.update`, and updates with its priors.

The oracle of a marginalisation is that of a copy, which has no factor; that of an update the dense
normal equations of the model with its priors.
"""

from __future__ import annotations

import time
import tracemalloc
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.windows.tracked import TrackedSystem
from tests.online.test_update import assert_a_step, gauss_newton, product, robot
from tests.test_session_edits import EDITS, Edited, net

__all__ = ["net"]  # a fixture


def assert_same_prior(found: Any, expected: Any, what: str) -> None:
    """Both are the same function of the same parameters."""
    assert (found is None) == (expected is None), what
    if found is None:
        return
    one, other = found.function, expected.function
    assert [a.name_at(0) for a in found.arguments] == [a.name_at(0) for a in expected.arguments]
    for mine, wanted in zip(one.parts, other.parts, strict=True):
        np.testing.assert_allclose(mine.base, wanted.base, rtol=1e-12, err_msg=what)
    tight = {"rtol": 1e-8, "atol": 1e-8, "err_msg": what}
    np.testing.assert_allclose(one.information, other.information, **tight)
    np.testing.assert_allclose(
        one.jacobian.T @ one.residual, other.jacobian.T @ other.residual, **tight
    )
    assert one.constant == pytest.approx(other.constant, rel=1e-8, abs=1e-8), what
    assert one.undetermined == other.undetermined, what


def marginalise(edited: Edited, at: int, first_estimates: bool, what: str) -> None:
    """Drop a point of a model and of a copy without a factor; the priors are the same."""
    copy = edited.model.copy()
    expected = copy.marginalise(copy.points[at], first_estimates=first_estimates)
    gone = edited.points[at]
    row = edited.model.points[at]
    assert row == gone
    found = edited.model.marginalise(row, first_estimates=first_estimates)
    edited.points.pop(at)
    edited.links = [link for link in edited.links if gone not in link[1:]]
    assert_same_prior(found, expected, what)


def edit_and_slide(net: type, seed: int) -> None:
    """Random edits; rows leave with the prior of the whole problem, and updates are steps."""
    edited = Edited(net, 10, seed)
    edited.model.update()
    first_estimates = bool(seed % 2)
    done: list[str] = []
    # Rows that priors are on leave by marginalisation only; beside other residuals that were added
    # at run time priors are solved in full.
    chosen = sorted(EDITS.keys() - {"remove_point", "residual", "residual_data"})
    for _ in range(12):
        for _ in range(edited.rng.integers(1, 4)):
            done.append(str(edited.rng.choice(chosen)))
            EDITS[done[-1]](edited)
        what = f"seed {seed}: {done}"
        if len(edited.points) > 4 and edited.rng.random() < 0.6:
            done.append("marginalise")
            at = int(edited.rng.integers(len(edited.points)))
            marginalise(edited, at, first_estimates, what)
            edited.append_point()
        assert_a_step(edited, what)


@pytest.mark.parametrize("seed", range(6))
def test_rows_leave_after_any_edits(net: type, seed: int) -> None:
    edit_and_slide(net, seed)


@pytest.mark.slow
def test_more_edits(net: type, request: pytest.FixtureRequest, fuzz_seed: int) -> None:
    """As many sequences as `--fuzz-seconds` allows."""
    end = time.monotonic() + request.config.getoption("--fuzz-seconds")
    count = 0
    while time.monotonic() < end or not count:
        edit_and_slide(net, 1_000_000 * (fuzz_seed + 1) + count)
        count += 1
    print(f"{count} sequences")


@pytest.mark.parametrize("name", ["pose_graph_2d", "pose_graph_3d"])
def test_a_window_of_poses_and_landmarks(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every prior is made from the factor, and is that of the whole problem."""
    made = []
    linearise = TrackedSystem.linearise
    monkeypatch.setattr(
        TrackedSystem, "linearise", lambda self, bases: made.append(1) or linearise(self, bases)
    )
    model, steps = robot(name, 4, 16, back=4)
    for k in steps:
        expected, normal = gauss_newton(model)
        result = model.update(tolerance=0)
        if not result.full:
            np.testing.assert_allclose(model.poses.t.value, expected.poses.t.value, atol=1e-8)
            np.testing.assert_allclose(product(model), normal, rtol=1e-8, atol=1e-8)
        if k >= 6 and k % 2 == 0:
            copy = model.copy()
            found = model.marginalise(model.poses[:2])
            assert_same_prior(found, copy.marginalise(copy.poses[:2]), str(k))
    assert made


GUARDED = """
struct Node { param x: vec2 }
struct Link {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    d: vec2
    constraint link { b.x - a.x - d }
    constraint far when b.x.x > a.x.x + 1 { 0.3 * exp(0.1 * (b.x.x - a.x.x)) - 0.5 }
}
struct Fix { n: ref Node in root.nodes
    constraint fix { n.x - [root.shift, 0] } }
root Net { nodes: list of Node
    links: list of Link
    fixes: list of Fix
    param shift: real
    constraint zero { shift - 0.1 } }
"""


def test_guards_that_read_parameters_and_the_root() -> None:
    model = arael.loads(GUARDED, name="guarded", interpret=True)(shift=0.0)
    model.nodes.extend(6, x=np.column_stack([1.2 * np.arange(6), np.zeros(6)]))
    for k in range(5):
        model.links.append(a=model.nodes[k], b=model.nodes[k + 1], d=[0.8 + 0.1 * k, 0.0])
    model.fixes.append(n=model.nodes[0])
    model.update()
    for _ in range(3):
        copy = model.copy()
        found = model.marginalise(model.nodes[0])
        assert_same_prior(found, copy.marginalise(copy.nodes[0]), "")
        expected, normal = gauss_newton(model)
        assert not model.update(tolerance=0).full
        np.testing.assert_allclose(model.nodes.x.value, expected.nodes.x.value, atol=1e-9)
        np.testing.assert_allclose(product(model), normal, atol=1e-9)


def test_a_prior_that_is_removed_or_read_by_hand(net: type) -> None:
    """Priors are compared as all else is."""
    edited = Edited(net, 8, 5)
    edited.model.update()
    marginalise(edited, 0, True, "first")
    marginalise(edited, 3, True, "second")
    assert len(edited.model.residuals.priors) == 2
    assert_a_step(edited, "two priors")
    edited.model.residuals.remove("prior")
    assert_a_step(edited, "one prior")
    read = edited.model.copy()
    assert not read.update().full
    gone = edited.model.residuals.priors["prior_2"].arguments[0].refs
    for link in [link for link in edited.links if gone[0] in link[1:]]:
        edited.model.links.remove(link[0])
        edited.links.remove(link)
    edited.points.remove(gone[0])
    edited.model.points.remove(gone[0])
    for act in (edited.model.update, edited.model.solve):
        with pytest.raises(AraelError) as raised:
            act()
        assert raised.value.diagnostics[0].code == "E0765"


def drive(model: Any, poses: int) -> None:
    """A robot that drives straight on in a window of 10 poses, with edges over one and three."""
    rng = np.random.default_rng(2)
    for k in range(poses):
        pose = model.poses.append(t=model.poses[-1].t.value + np.array([1, 0]), th=0.0)
        for back in (1, 3)[: min(2, len(model.poses) // 2)]:
            edge = {"t": [back, 0] + 0.02 * rng.normal(size=2), "th": 0.005 * rng.normal()}
            u = np.diag([50.0, 50.0, 200.0])
            model.edges.append(a=model.poses[-1 - back], b=pose, u=u, **edge)
        assert not model.update().full, k
        if len(model.poses) > 10:
            model.marginalise(model.poses[0])


def test_a_window_is_near_the_optimum_and_does_not_grow() -> None:
    window = arael.load("pose_graph_2d")()
    first = window.poses.append(t=[0, 0], th=0)
    window.anchors.append(pose=first, t=[0, 0], th=0, u=np.diag([100.0, 100.0, 1000.0]))
    drive(window, 60)
    tree = window.session.online.engine.tree
    sizes = tree.live_terms, tree.live_variables
    tracemalloc.start()
    drive(window, 20)
    before = tracemalloc.get_traced_memory()[0]
    drive(window, 40)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert (tree.live_terms, tree.live_variables) == sizes
    assert grown < 20_000
    window.update()
    copy = window.copy()
    best = copy.solve(rel_precision=1e-12, abs_precision=0.0).end_cost
    assert window.cost() == pytest.approx(best, rel=1e-5, abs=1e-9)
    expected = copy.covariance().marginal(copy.poses[-1])
    np.testing.assert_allclose(window.marginal(window.poses[-1]), expected, rtol=1e-3, atol=1e-3)


def test_priors_beside_other_residuals_are_solved_in_full(net: type) -> None:
    edited = Edited(net, 8, 6)
    edited.model.update()
    marginalise(edited, 0, True, "")
    edited.residual()
    result = edited.model.update()
    assert result.full
    assert result.reason == "there are priors beside other residuals that were added at run time"
