"""Layouts written by hand, as the compiler would write them, for tests of the data packages
alone."""
# ruff: noqa: E501 - a case, or a column, is one line

from __future__ import annotations

from typing import Any

from arael.runtime.layout import ByValue, Column, Layout, Param, Step, Table, Target

ROOT = (Step(kind="root"),)
SHAPES: dict[str, tuple[int, ...]] = {
    "vec2": (2,),
    "vec3": (3,),
    "mat3": (3, 3),
    "mat<6,6>": (6, 6),
    "quat": (4,),
    "euler": (3,),
    "rotation": (4,),
    "quaternion": (4,),
}
PARAMS = {
    "real": Param(kind="real", stored=1, tangent=1),
    "vec2": Param(kind="vec", stored=2, tangent=2),
    "vec3": Param(kind="vec", stored=3, tangent=3),
    "euler": Param(kind="euler", stored=3, tangent=3),
    "rotation": Param(kind="rotation", stored=4, tangent=3),
    "quaternion": Param(kind="quaternion", stored=4, tangent=3),
    "angle": Param(kind="angle", stored=1, tangent=1),
}


def data(
    path: str, type_: str, default: Any = None, within: str = "", role: Any = "data"
) -> Column:
    """A column of data."""
    bare = type_.split(" ")[0].rstrip("?")
    kind: Any = bare if bare in ("int", "bool", "string") else "real"
    return Column(
        path, kind, SHAPES.get(bare, ()), role, type_, "model.arael:1:1", default=default,
        within=within,
    )  # fmt: skip


def param(path: str, type_: str, default: Any = None, within: str = "") -> Column:
    """A parameter."""
    bare = type_.split(" ")[0]
    return Column(
        path, "real", SHAPES.get(bare, ()), "param", type_, "model.arael:2:1", default=default,
        param=PARAMS[bare], within=within,
    )  # fmt: skip


def ref(path: str, struct: str, table: str, text: str, base: tuple[Step, ...] = ROOT) -> Column:
    """A ref."""
    return Column(
        path, "int", (), "ref", f"ref {struct} in {text}", "model.arael:3:1",
        target=Target(table, struct, base, text),
    )  # fmt: skip


def present(path: str, type_: str = "T?") -> Column:
    """The presence of an optional."""
    return Column(path, "bool", (), "present", type_, "model.arael:4:1", within=path)


def table(
    path: str, struct: str, collection: Any, *columns: Column, values: Any = (), **more: Any
) -> Table:
    """A table; its parent is found by its path unless given."""
    return Table(
        path, struct, collection, more.pop("parent", ""), more.pop("field", path),
        "model.arael:5:1", columns, tuple(values), **more,
    )  # fmt: skip


def layout(name: str, root: str, *tables: Table, precision: Any = "f64") -> Layout:
    """A model without constraints."""
    return Layout(1, name, root, precision, f"{name}.arael", tables, (), (), ())


def slam(precision: Any = "f64") -> Layout:
    """The SLAM model's shape, somewhat shortened."""
    gps = "info.gps"
    return layout(
        "slam", "Path",
        table(
            "", "Path", "root",
            data("gamma", "real", (3.0,)),
            data("tilt_isigma", "real [1/rad]", (1.0,)),
        ),
        table(
            "poses", "Pose", "deque",
            param("pos", "vec3 [m]"), param("ea", "euler"),
            data("info.delta_pos", "vec3 [m]"), data("info.tilt_roll", "real [rad]"),
            present(gps, "GpsData?"),
            data("info.gps.pos", "vec3 [m]", within=gps), data("info.gps.cov_r", "mat3", within=gps),
            values=[
                ByValue("info", "PoseInfo", False, "model.arael:6:1"),
                ByValue(gps, "GpsData", True, "model.arael:7:1"),
            ],
        ),
        table(
            "landmarks", "PointLandmark", "arena",
            param("pos", "vec3 [m]"), data("name", "string", "", role="skip"),
        ),
        table(
            "pose_pairs", "PosePair", "list",
            ref("prev", "Pose", "poses", "root.poses"), ref("cur", "Pose", "poses", "root.poses"),
        ),
        table(
            "poses.info.features", "PointFeature", "list",
            data("pixel", "vec2 [px]"), data("camera", "int", (0,)),
            parent="poses", field="info.features",
        ),
        table(
            "landmarks.frines", "PointFrine", "list",
            ref("pose", "Pose", "poses", "root.poses"),
            ref(
                "feature", "PointFeature", "poses.info.features", "pose.info.features",
                (Step(kind="ref", ref="pose"),),
            ),
            data("row", "int", (-1,), role="constraint_index"),
            parent="landmarks", field="frines",
        ),
        precision=precision,
    )  # fmt: skip


def odds() -> Layout:
    """A model with everything that is rare: optionals of scalars and refs, keys, strings, nesting."""
    return layout(
        "odds", "Odds",
        table(
            "", "Odds", "root",
            data("n", "int"), data("on", "bool", (1.0,)), param("scale", "real", (1.0,)),
            data("global.offset", "vec3", (0.0, 0.0, 0.0)), param("global.q", "rotation", (1.0, 0.0, 0.0, 0.0)),
            values=[ByValue("global", "Globals", False, "model.arael:6:1")],
        ),
        table(
            "cameras", "Camera", "list",
            data("name", "string", role="data"), param("q", "quaternion"), param("th", "angle"),
            data("base", "quat", (1.0, 0.0, 0.0, 0.0)),
            present("weight", "real?"), data("weight", "real?", within="weight"),
            present("twin", "ref Camera?"),
            ref("twin", "Camera", "cameras", "root.cameras"),
            present("mount", "Mount?"),
            param("mount.t", "vec3 [m]", within="mount"),
            key="name", values=[ByValue("mount", "Mount", True, "model.arael:6:1")],
        ),
        table(
            "cameras.mount.bolts", "Bolt", "list", data("size", "real"),
            parent="cameras", field="mount.bolts",
        ),
        table(
            "views", "View", "list",
            ref("camera", "Camera", "cameras", "root.cameras"), data("ok", "bool"),
            data("count", "int"),
        ),
    )  # fmt: skip


def pose_graph(n: int) -> Layout:
    """The shape of pose_graph_2d (n = 2) or pose_graph_3d (n = 3)."""
    if n == 2:
        pose = (param("t", "vec2 [m]"), param("th", "angle"))
        measured = (data("t", "vec2 [m]"), data("th", "real [rad]"))
        u = data("u", "mat3")
        weights = (data("t_isigma", "real [1/m]", (1,)), data("th_isigma", "real [1/rad]", (1,)))
    else:
        pose = (param("t", "vec3 [m]"), param("q", "quaternion"))
        measured = (data("t", "vec3 [m]"), data("q", "quat"))
        u = data("u", "mat<6,6>")
        weights = (data("t_isigma", "real [1/m]", (1,)),)
    ends = [ref(name, "Pose", "poses", "root.poses") for name in ("a", "b")]
    return layout(
        f"pose_graph_{n}d", "PoseGraph",
        table("", "PoseGraph", "root"),
        table(
            "poses", "Pose", "list", *pose, data("id", "int", (0,), role="skip"),
            data("held", "bool", (False,), role="skip"),
        ),
        table("edges", "Edge", "list", *ends, *measured, u),
        table(
            "anchors", "Anchor", "list", ref("pose", "Pose", "poses", "root.poses"), *measured, *weights
        ),
    )  # fmt: skip
