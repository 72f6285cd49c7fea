"""Tables and columns: where structs sit, and what the runtime will store of them."""

from __future__ import annotations

import math

import pytest

from arael.runtime.layout import Param, Step, Table
from tests.check.models import checked, standard


def table(name: str, path: str) -> Table:
    return next(t for t in standard(name).tables if t.path == path)


def test_slam_tables_in_order_of_owners() -> None:
    model = standard("slam")
    assert [(t.path, t.struct, t.collection, t.parent, t.field) for t in model.tables] == [
        ("", "Path", "root", "", ""),
        ("poses", "Pose", "deque", "", "poses"),
        ("landmarks", "PointLandmark", "list", "", "landmarks"),
        ("pose_pairs", "PosePair", "list", "", "pose_pairs"),
        ("poses.info.features", "PointFeature", "list", "poses", "info.features"),
        ("landmarks.frines", "PointFrine", "list", "landmarks", "frines"),
    ]
    assert (model.name, model.root, model.precision) == ("slam", "Path", "f64")


def test_structs_by_value_become_columns_of_their_owner() -> None:
    poses = table("slam", "poses")
    assert [c.path for c in poses.columns] == [
        "pos",
        "ea",
        "info.delta_pos",
        "info.delta_ea",
        "info.delta_pos_cov_r",
        "info.delta_pos_cov_isigma",
        "info.delta_ea_cov_r",
        "info.delta_ea_cov_isigma",
        "info.gps",
        "info.gps.pos",
        "info.gps.cov_r",
        "info.gps.cov_isigma",
        "info.tilt_roll",
        "info.tilt_pitch",
    ]
    assert [(v.path, v.struct, v.optional) for v in poses.values] == [
        ("info", "PoseInfo", False),
        ("info.gps", "GpsData", True),
    ]
    assert poses.column("info.gps").role == "present"
    within = {c.path for c in poses.columns if c.within == "info.gps"}
    assert within == {"info.gps", "info.gps.pos", "info.gps.cov_r", "info.gps.cov_isigma"}
    assert poses.column("info.gps.cov_r").shape == (3, 3)
    assert poses.column("info.gps.pos").where == "slam.arael:14:5"
    assert poses.column("info.gps.pos").type == "vec3 [m]"
    assert poses.column("info.gps.pos").unit == "m"


def test_parameters_of_the_standard_models() -> None:
    assert table("slam", "poses").column("ea").param == Param("euler", 3, 3)
    assert table("slam", "poses").column("pos").param == Param("vec", 3, 3)
    q = table("pose_graph_3d", "poses").column("q")
    assert (q.param, q.shape, q.kind) == (Param("quaternion", 4, 3), (4,), "real")
    assert table("linear", "").column("a").param == Param("real", 1, 1)
    assert standard("linear").precision == "f32"


def test_entities_are_places_with_parameters() -> None:
    entities = standard("slam").entities
    assert [(e.struct, e.table, e.prefix, [c.path for c in e.columns]) for e in entities] == [
        ("Pose", "poses", "", ["pos", "ea"]),
        ("PointLandmark", "landmarks", "", ["pos"]),
    ]


def test_a_struct_by_value_is_an_entity_of_its_own() -> None:
    model = checked(
        """
        struct Globals { param scale: real; constraint prior { scale - 1 } }
        root Path { globals: Globals; param x: real; constraint c { x * globals.scale } }
        """
    )
    assert [(e.table, e.prefix) for e in model.entities] == [("", ""), ("", "globals.")]
    assert [c.path for c in model.entities[1].columns] == ["globals.scale"]


def test_defaults_are_numbers() -> None:
    root = table("slam", "")
    assert root.column("gamma").default == pytest.approx((2 * 5 / math.pi,))
    assert root.column("drift_ea_isigma").default == pytest.approx((1 / math.radians(1800),))
    assert table("slam", "poses").column("info.tilt_roll").default is None


def test_defaults_of_every_type() -> None:
    model = checked(
        """
        const G = [0, 0, -9.81]
        fn twice(x) = x + x
        root Fit {
            param a: vec2 = [1, 2]
            v: vec3 = 2 * G
            m: mat2 = [1, 2, 3, 4]
            i: mat3 = identity3
            q: quat = [1, 0, 0, 0]
            n: int = twice(3)
            on: bool = 1 < 2
            s: string = "camera"
            constraint c { a }
        }
        """
    )
    defaults = {c.path: c.default for c in model.tables[0].columns}
    assert defaults == {
        "a": (1, 2),
        "v": (0, 0, -19.62),
        "m": (1, 2, 3, 4),
        "i": (1, 0, 0, 0, 1, 0, 0, 0, 1),
        "q": (1, 0, 0, 0),
        "n": (6,),
        "on": (1,),
        "s": "camera",
    }


def test_bounds_are_one_number_per_component() -> None:
    model = checked(
        """
        root Fit {
            param a: real in 0 .. 10
            param b: vec2 in [0, 1] ..
            param c: vec2 in .. 2
            param d: real
            constraint k { [a, b, c, d] }
        }
        """
    )
    bounds = {c.path: (c.param.low, c.param.high) for c in model.tables[0].columns if c.param}
    assert bounds == {
        "a": ((0,), (10,)),
        "b": ((0, 1), (None, None)),
        "c": ((None, None), (2, 2)),
        "d": ((), ()),
    }


def test_chained_ref_has_its_owner_as_base() -> None:
    frines = table("slam", "landmarks.frines")
    pose, feature = frines.column("pose").target, frines.column("feature").target
    assert pose is not None
    assert feature is not None
    assert (pose.table, pose.struct, pose.base) == ("poses", "Pose", (Step("root"),))
    assert feature.table == "poses.info.features"
    assert feature.base == (Step("ref", "pose"),)
    assert feature.text == "pose.info.features"


def test_refs_may_be_declared_later_and_start_at_parent() -> None:
    model = checked(
        """
        struct Point { param x: real; constraint c { x } }
        struct Pair {
            b: ref Point in a.parent.points
            a: ref Point in parent.points
            constraint d { a.x - b.x }
        }
        struct Cloud { points: list of Point; pairs: list of Pair }
        root Scene { clouds: list of Cloud }
        """
    )
    pairs = next(t for t in model.tables if t.path == "clouds.pairs")
    a, b = pairs.column("a").target, pairs.column("b").target
    assert a is not None
    assert b is not None
    assert (a.table, a.base) == ("clouds.points", (Step("parent"),))
    # The parent of what `a` points to is known: it is the parent of the pair.
    assert (b.table, b.base) == ("clouds.points", (Step("parent"),))


def test_optional_scalars_have_presence_and_value() -> None:
    model = checked(
        """
        struct P { param x: real; h: real?; constraint c when h { x - h } }
        root R { ps: list of P }
        """
    )
    assert model.tables[1].column("h").role == "data"
    roles = [(c.path, c.role, c.within) for c in model.tables[1].columns]
    assert roles == [("x", "param", ""), ("h", "data", "h"), ("h", "present", "h")]


def test_key_skip_and_constraint_index() -> None:
    model = checked(
        """
        struct P {
            key name
            name: string
            skip note: string = ""
            ci: constraint_index
            param x: real
            constraint c { x }
        }
        struct Holder { p: P }
        root R { hs: list of Holder; ps: list of P }
        """
    )
    ps = next(t for t in model.tables if t.path == "ps")
    assert ps.key == "name"
    assert [c.role for c in ps.columns] == ["data", "skip", "constraint_index", "param"]
    assert [(c.table, c.index_column) for c in model.constraints] == [
        ("hs", "p.ci"),
        ("ps", "ci"),
    ]


def test_documentation_is_kept() -> None:
    model = standard("slam")
    assert "Visual-inertial" not in model.doc
    assert next(t for t in model.tables if t.path == "poses").doc.startswith("The body's position")
    gps = next(c for c in model.constraints if c.label == "Pose.gps")
    assert gps.doc == "GPS fixes, where there are any."
