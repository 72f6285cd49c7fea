"""Slots: the rows that a constraint reads, and what it reads of them."""

from __future__ import annotations

import pytest

from arael.check.typed import ConstraintSite, Present, Read
from arael.check.walk import postorder
from arael.runtime.layout import Slot, Step
from tests.check.models import checked, constraint, standard

ROOT = Step("root")
PARENT = Step("parent")


def ref(column: str) -> Step:
    return Step("ref", column)


def reads(site: ConstraintSite) -> set[tuple[int, str, str]]:
    nodes = postorder(site.residual)
    return {(n.slot, n.column, n.version) for n in nodes if isinstance(n, Read)}


def test_bearing_reads_landmark_pose_feature_and_root() -> None:
    site = constraint(standard("slam"), "PointFrine.bearing")
    assert site.table == "landmarks.frines"
    slots = {s.steps: (i, s.table) for i, s in enumerate(site.slots)}
    assert site.slots[0] == Slot((), "landmarks.frines")
    assert {k: v[1] for k, v in slots.items()} == {
        (): "landmarks.frines",
        (PARENT,): "landmarks",
        (ref("pose"),): "poses",
        (ref("feature"),): "poses.info.features",
        (ROOT,): "",
    }
    pose = slots[(ref("pose"),)][0]
    assert (pose, "ea", "trial") in reads(site)
    assert (slots[(ROOT,)][0], "gamma", "data") in reads(site)


def test_one_slot_per_way() -> None:
    site = constraint(standard("slam"), "PosePair.odometry")
    assert [s.steps for s in site.slots] == [(), (ref("prev"),), (ref("cur"),)]


def test_stored_values_are_read_apart() -> None:
    site = constraint(standard("slam"), "PointLandmark.drift")
    own = {r for r in reads(site) if r[0] == 0}
    assert own == {(0, "pos", "trial"), (0, "pos", "stored")}


def test_guard_tests_presence() -> None:
    site = constraint(standard("slam"), "Pose.gps")
    assert isinstance(site.guard, Present)
    assert (site.guard.slot, site.guard.column) == (0, "info.gps")
    assert constraint(standard("slam"), "Pose.tilt").guard is None


def test_fit_runs_over_elements_with_the_root_at_hand() -> None:
    site = constraint(standard("linear"), "LinearModel.data")
    assert (site.table, site.prefix, site.struct) == ("data", "", "LinearModel")
    assert site.slots == (Slot((), "data"), Slot((ROOT,), "")) or reads(site) == {
        (0, "x", "data"),
        (0, "y", "data"),
        (1, "a", "trial"),
        (1, "b", "trial"),
        (1, "sigma", "data"),
        (1, "gamma", "data"),
    }


def test_a_body_is_typed_at_every_place_of_its_struct() -> None:
    model = checked(
        """
        struct Point { param x: real; constraint near { x - parent.at } }
        struct A { at: real; points: list of Point }
        struct B { at: real; point: Point }
        root Scene { as: list of A; bs: list of B }
        """.replace("as:", "aa:")
    )
    sites = [c for c in model.constraints if c.label == "Point.near"]
    # In a collection the parent is another row, by value it is the same row.
    assert [(c.table, c.prefix, [s.steps for s in c.slots]) for c in sites] == [
        ("bs", "point.", [()]),
        ("aa.points", "", [(), (PARENT,)]),
    ]
    assert (0, "at", "data") in reads(sites[0])


def test_presence_of_the_site_itself_is_part_of_its_guard() -> None:
    model = checked(
        """
        struct Bias { param b: real; mean: real; constraint prior when mean > 0 { b - mean } }
        struct Pose { bias: Bias? }
        root Path { poses: list of Pose }
        """
    )
    site = constraint(model, "Bias.prior")
    assert site.prefix == "bias."
    assert site.guard is not None
    present = [n.column for n in postorder([site.guard]) if isinstance(n, Present)]
    assert present == ["bias"]


def test_ways_to_write_the_same_entity() -> None:
    text = """
    struct Pose {{ param pos: vec3; w: real; constraint c {{ {} }} }}
    root Path {{ poses: list of Pose; gain: real }}
    """
    for body in ("pos * w", "pose.pos * w", "self.pos * pose.w", "self.pos * self.w"):
        assert len(checked(text.format(body)).constraints[0].slots) == 1
    for body in ("pos * root.gain", "pos * path.gain", "pos * parent.gain"):
        slots = checked(text.format(body)).constraints[0].slots
        assert [s.steps for s in slots] == [(), (ROOT,)]


def test_a_let_may_bind_an_entity_or_an_optional() -> None:
    model = checked(
        """
        struct Gps { pos: vec3 }
        struct Info { gps: Gps?; h: real? }
        struct Pose {
            param pos: vec3
            info: Info
            constraint c {
                let i = info
                let g = i.gps
                let h = i.h
                [if g then pos - g.pos else [0, 0, 0], if h then pos.z - h else 0]
            }
        }
        root Path { poses: list of Pose }
        """
    )
    assert (0, "info.gps.pos", "data") in reads(model.constraints[0])


def test_the_parent_of_a_feature_is_the_pose_that_names_it() -> None:
    model = checked(
        """
        struct Feature { ray: vec3 }
        struct Info { features: list of Feature }
        struct Pose { param pos: vec3; info: Info }
        struct Sight {
            pose: ref Pose in root.poses
            feature: ref Feature in pose.info.features
            constraint c { feature.parent.parent.pos - pose.pos + feature.ray }
        }
        root Path { poses: list of Pose; sights: list of Sight }
        """
    )
    slots = [s.steps for s in model.constraints[0].slots]
    assert slots == [(), (ref("pose"),), (ref("feature"),)]


def test_constraints_on_the_root_read_its_own_row() -> None:
    model = checked(
        """
        struct Globals { param s: real; constraint near { s - root.k } }
        root Path { globals: Globals; k: real; constraint c { root.globals.s - path.k } }
        """
    )
    for site in model.constraints:
        assert site.slots == (Slot((), ""),)


@pytest.mark.parametrize("name", ["a", "b", "c"])
def test_refs_to_refs(name: str) -> None:
    model = checked(
        """
        struct Node { param x: real; next: ref Node in root.nodes }
        struct Probe {
            n: ref Node in root.nodes
            constraint a { n.x }
            constraint b { n.next.x }
            constraint c { n.next.next.x }
        }
        root Ring { nodes: list of Node; probes: list of Probe }
        """
    )
    steps = constraint(model, f"Probe.{name}").slots[1].steps
    assert steps == (ref("n"), ref("next"), ref("next"))[: "abc".index(name) + 1]


def test_fits_are_named_after_their_collections() -> None:
    model = checked(
        """
        struct D { x: real; more: list of D2 }
        struct D2 { x: real }
        root F {
            param a: real
            data: list of D
            constraint data { a }
            fit data as e { a - e.x }
            fit root.data as e { a * e.x }
        }
        """
    )
    assert [c.label for c in model.constraints] == ["F.data", "F.data_2", "F.data_3"]
