"""The invariants of a scatter plan: they hold for every problem, and each can fail."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import arael
from arael.io import json_reader
from arael.runtime.assembly import firsts
from arael.runtime.assembly import shares as sharing
from arael.runtime.assembly.invariants import BrokenPlan
from arael.runtime.assembly.scatter_plan import Execution, ScatterPlan, Shares
from arael.runtime.assembly.structure import structure_of
from tests.compiler import random_models
from tests.fuzz import filling

STANDARD = (
    "bundle_adjustment",
    "linear",
    "localization",
    "plane_slam",
    "pose_graph_2d",
    "pose_graph_3d",
    "slam",
)

NET = """
struct Point {
    param pos: vec2
    param scale: real
    on: bool = true
    constraint keep when on { (pos - pos.value) * scale }
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    w: real = 1
    constraint near { [norm2(a.pos - b.pos) - root.size, a.scale * b.scale] }
    constraint apart when w > 0 { [a.scale - 1, b.scale - 2] }
}
root Net {
    param size: real
    points: list of Point
    links: list of Link
}
"""


@pytest.fixture(scope="module")
def net(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("models") / "net.arael"
    path.write_text(NET, encoding="utf-8")
    return arael.load(path, interpret=True)


@contextmanager
def split_finely() -> Iterator[None]:
    """Split whatever has two blocks of lanes, and find first writers in small problems."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sharing, "GRAIN", 100.0)
        patch.setattr(sharing, "_SHORT", 1)
        patch.setattr(sharing, "_ROOM", 1e6)
        patch.setattr(sharing, "_CACHED", 0)
        patch.setattr(firsts, "_NEAR", 0)
        yield


@pytest.fixture
def finely() -> Iterator[None]:
    with split_finely():
        yield


def plan_of(model: Any) -> ScatterPlan:
    return structure_of(model._store).plan


def execution_of(plan: ScatterPlan, width: int, alone: bool = False) -> Execution:
    """All groups on lanes of this width; `alone`: threads may not run every other group."""
    count = len(plan.groups)
    concurrent = tuple(not alone or k % 2 == 0 for k in range(count))
    return Execution((width,) * count, concurrent, (True,) * count)


def filled(net: Any, seed: int, points: int, links: int) -> Any:
    rng = np.random.default_rng(seed)
    model = net(size=1.0)
    model.points.extend(pos=rng.normal(size=(points, 2)), scale=1.0, on=rng.random(points) < 0.7)
    for a, b in rng.integers(0, points, (links, 2)):  # a == b among them
        link = {"a": model.points[int(a)], "b": model.points[int(b)]}
        model.links.append(**link, w=float(rng.normal()))
    for k in np.flatnonzero(rng.random(points) < 0.2):
        model.points[int(k)].pos.fixed = True
        model.points[int(k)].scale.fixed = bool(rng.random() < 0.7)
    model.size.fixed = bool(rng.random() < 0.5)
    return model


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    seed=st.integers(0, 2**31),
    points=st.integers(1, 12),
    links=st.integers(0, 60),
    width=st.sampled_from([1, 4, 8]),
    alone=st.booleans(),
)
def test_invariants_hold_for_random_data(
    net: Any, finely: None, seed: int, points: int, links: int, width: int, alone: bool
) -> None:
    plan = plan_of(filled(net, seed, points, links))
    plan.shares_for(execution_of(plan, width, alone))
    plan.check()


@pytest.mark.parametrize("fine", [False, True])
@pytest.mark.parametrize("name", STANDARD)
def test_invariants_hold_for_standard_models(
    name: str, fine: bool, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    if fine:
        request.getfixturevalue("finely")
    monkeypatch.setattr(filling, "ROWS", 6)
    model: Any = arael.load(name)
    instance = model()
    data = json.dumps(filling.scene(model.layout, random.Random(7))).encode()
    json_reader.read(instance._store, data, "scene.json")
    plan = plan_of(instance)
    for width in (1, 8):
        shares = plan.shares_for(execution_of(plan, width))
        assert shares.count > 1 or not fine or name == "linear"
    plan.check()


@settings(max_examples=2, deadline=None, suppress_health_check=list(HealthCheck))
@given(drawn=random_models.models(constraints=2))
def test_invariants_hold_for_random_models(
    finely: None, drawn: random_models.RandomModel, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("random") / "random.arael"
    path.write_text(drawn.text)
    model = arael.load(path, interpret=True)()
    random_models.fill(model, drawn.seed)
    plan = plan_of(model)
    plan.shares_for(execution_of(plan, 8))
    plan.check()


def test_active_instances_are_those_whose_guards_hold(net: Any) -> None:
    model = filled(net, 3, 9, 30)
    plan = plan_of(model)
    labels = [group.label for group in plan.groups]
    keep, apart = labels.index("Point.keep"), labels.index("Link.apart")
    on, w = model._store.tables["points"].column("on"), model._store.tables["links"].column("w")
    np.testing.assert_array_equal(plan.active[keep], np.flatnonzero(on))
    np.testing.assert_array_equal(plan.active[apart], np.flatnonzero(w > 0))
    assert 0 < len(plan.active[apart]) < len(w)


def test_a_plan_is_computed_once_for_each_execution(net: Any) -> None:
    plan = plan_of(filled(net, 3, 9, 30))
    one = execution_of(plan, 4)
    assert plan.shares_for(one) is plan.shares_for(Execution(*one))
    assert plan.shares_for(execution_of(plan, 8)) is not plan.shares_for(one)
    assert len(plan.shares) == 2


def test_arrays_of_a_plan_cannot_be_written(net: Any) -> None:
    plan = plan_of(filled(net, 3, 9, 30))
    shares = plan.shares_for(execution_of(plan, 4))
    for array in (
        plan.active[0],
        plan.pattern.value_start,
        plan.placements[0].block_at,
        plan.diagonal_at,
        shares.placed[0].block_at,
        shares.cleared,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


# Each case damages one array of a valid plan.


def changed(array: np.ndarray, *index: Any, by: int | None = None, to: int | None = None) -> Any:
    found = array.copy()
    found[index] = found[index] + by if to is None else to
    found.setflags(write=False)
    return found


def frozen(array: Any) -> Any:
    found = np.ascontiguousarray(array)
    found.setflags(write=False)
    return found


def with_pattern(plan: ScatterPlan, **arrays: Any) -> ScatterPlan:
    return replace(plan, pattern=replace(plan.pattern, **arrays))


def with_placement(plan: ScatterPlan, g: int, **arrays: Any) -> ScatterPlan:
    placements = list(plan.placements)
    placements[g] = replace(placements[g], **arrays)
    return replace(plan, placements=tuple(placements))


def with_shares(plan: ScatterPlan, **fields: Any) -> ScatterPlan:
    (execution,) = plan._shares
    return replace(plan, _shares={execution: replace(plan.shares[0], **fields)})


def with_lanes(plan: ScatterPlan, g: int, **arrays: Any) -> ScatterPlan:
    placed = list(plan.shares[0].placed)
    placed[g] = placed[g]._replace(**arrays)
    return with_shares(plan, placed=tuple(placed))


def near(plan: ScatterPlan) -> int:
    return [group.label for group in plan.groups].index("Link.near")


def first_pair(plan: ScatterPlan) -> tuple[int, int, int]:
    """Group, block of lanes and pair of a first writer."""
    g = near(plan)
    block, pair = np.argwhere(plan.shares[0].placed[g].first)[0]
    return g, int(block), int(pair)


def later_pair(plan: ScatterPlan) -> tuple[int, int, int]:
    """Group, block of lanes and pair of lanes that add to blocks that others have written."""
    g = near(plan)
    lanes = plan.shares[0].placed[g]
    nowhere = plan.shares[0].nowhere
    writes = (~np.isin(lanes.block_at, nowhere)).all(axis=2) & (lanes.first == 0)
    block, pair = np.argwhere(writes)[-1]
    return g, int(block), int(pair)


DAMAGE: dict[str, tuple[str, Callable[[ScatterPlan], ScatterPlan]]] = {
    "a pair twice": (
        "triangle",
        lambda p: with_pattern(p, rows=changed(p.pattern.rows, 2, to=int(p.pattern.rows[1]))),
    ),
    "a block above the diagonal": (
        "triangle",
        lambda p: with_pattern(p, rows=changed(p.pattern.rows, -1, to=0)),
    ),
    "blocks that overlap": (
        "tiles",
        lambda p: with_pattern(p, value_start=changed(p.pattern.value_start, 3, by=-1)),
    ),
    "an inactive instance": (
        "active",
        lambda p: replace(p, active=(frozen(p.active[0][:-1]), *p.active[1:])),
    ),
    "an instance twice": (
        "active",
        lambda p: replace(p, active=(changed(p.active[0], 1, by=-1), *p.active[1:])),
    ),
    "another scalar of a block": (
        "gradient",
        lambda p: with_placement(
            p, near(p), gradient_at=changed(p.placements[near(p)].gradient_at, 0, 1, by=1)
        ),
    ),
    "a scalar behind the gradient": (
        "gradient",
        lambda p: with_placement(
            p, near(p), gradient_at=changed(p.placements[near(p)].gradient_at, 0, 1, to=10**6)
        ),
    ),
    "the block of another pair": (
        "blocks",
        lambda p: with_placement(
            p, near(p), block_at=changed(p.placements[near(p)].block_at, 0, 0, to=0)
        ),
    ),
    "a block transposed": (
        "blocks",
        lambda p: with_placement(
            p,
            near(p),
            turn=frozen(np.where(p.placements[near(p)].turn == 1, 0, p.placements[near(p)].turn)),
        ),
    ),
    "an instance in no share": (
        "partition",
        lambda p: with_shares(p, bounds=tuple(changed(b, -1, by=-1) for b in p.shares[0].bounds)),
    ),
    "shares that overlap": (
        "partition",
        lambda p: with_shares(
            p,
            bounds=tuple(
                changed(b, 1, by=int(b[-1])) if len(b) > 2 else b for b in p.shares[0].bounds
            ),
        ),
    ),
    "a lane elsewhere": (
        "offsets",
        lambda p: with_lanes(
            p,
            near(p),
            gradient_at=changed(p.shares[0].placed[near(p)].gradient_at, 0, 0, 0, by=1),
        ),
    ),
    "a copy added to another scalar": (
        "offsets",
        lambda p: with_shares(p, gradient_sums=frozen(p.shares[0].gradient_sums[:-1])),
    ),
    "copies that overlap": (
        "copies",
        lambda p: with_shares(
            p,
            gradient_sums=changed(
                p.shares[0].gradient_sums, 1, 1, to=int(p.shares[0].gradient_sums[0, 1])
            ),
        ),
    ),
    "one trash for two shares": (
        "copies",
        lambda p: with_shares(
            p, nowhere=changed(p.shares[0].nowhere, 0, to=int(p.shares[0].nowhere[1]))
        ),
    ),
    "a first writer after another": (
        "firsts",
        lambda p: with_lanes(
            p,
            near(p),
            first=changed(p.shares[0].placed[near(p)].first, *later_pair(p)[1:], to=1),
        ),
    ),
    "a range that is not zeroed": (
        "cleared",
        lambda p: with_shares(p, cleared=changed(p.shares[0].cleared, 0, 0, by=1)),
    ),
    "a range zeroed twice": (
        "cleared",
        lambda p: with_shares(p, cleared_ends=changed(p.shares[0].cleared_ends, 1, to=10**6)),
    ),
    "a first writer that adds": (
        "cleared",
        lambda p: with_lanes(
            p,
            near(p),
            first=changed(p.shares[0].placed[near(p)].first, *first_pair(p)[1:], to=0),
        ),
    ),
    "a run of two rows": (
        "runs",
        lambda p: with_lanes(p, 0, run=frozen(np.ones_like(p.shares[0].placed[0].run))),
    ),
    "an array that can be written": (
        "read-only",
        lambda p: with_shares(p, cleared=p.shares[0].cleared.copy()),
    ),
}


@pytest.fixture(scope="module")
def valid(net: Any) -> ScatterPlan:
    plan = plan_of(filled(net, 11, 12, 60))
    with split_finely():
        shares: Shares = plan.shares_for(execution_of(plan, 2))
    assert shares.count > 1
    assert len(shares.gradient_sums) > 1
    plan.check()
    return plan


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_plan_is_found(damage: str, valid: ScatterPlan) -> None:
    invariant, change = DAMAGE[damage]
    with pytest.raises(BrokenPlan) as found:
        change(valid).check()
    assert found.value.invariant == invariant


def test_two_shares_that_write_to_the_same_block_are_found(valid: ScatterPlan) -> None:
    """All targets are right, but the copies of the second share are not used."""
    shares = valid.shares[0]
    placed = list(shares.placed)
    for g, lanes in enumerate(placed):
        target = np.arange(shares.value_extent)
        for to, begin, count in shares.value_sums.tolist():
            target[begin : begin + count] = np.arange(to, to + count)
        placed[g] = lanes._replace(block_at=frozen(target[lanes.block_at]))
    with pytest.raises(BrokenPlan) as found:
        with_shares(valid, placed=tuple(placed)).check()
    assert found.value.invariant == "separate"
