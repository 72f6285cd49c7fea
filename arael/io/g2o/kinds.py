"""Differences between planar and spatial pose graphs: tags, numbers per line, fields of the model.

A pose is a row of numbers in the file: ``x y theta`` or ``x y z qx qy qz qw``. An information
matrix is its upper triangle, row by row. Formats as in g2o's ``types/slam2d`` and ``types/slam3d``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime.store import Store, rotations
from arael.runtime.store.messages import error

Array = NDArray[Any]

# TORO's EDGE2 gives the information as xx xy yy tt xt yt (tt: heading).
TORO_ORDER = (0, 1, 4, 2, 5, 3)

TUTORIAL = "TUTORIAL_"
"""Prefix of the tags of g2o's tutorial; the rest is that of the library, but for `RENAMED`."""

RENAMED = {
    "VERTEX_POINT_XY": "VERTEX_XY",
    "PARAMS_SE2_OFFSET": "PARAMS_SE2OFFSET",
    "EDGE_SE2_POINT_XY": "EDGE_SE2_POINTXY_OFFSET",
}
"""Tags of the tutorial, without prefix, by those of the library."""

SWITCHES = frozenset(
    {
        "EDGE_SE2_SWITCHABLE",
        "EDGE_SE3_SWITCHABLE",
        "EDGE_SE2_MAXMIX",
        "EDGE_SE3_MAXMIX",
        "VERTEX_SWITCH",
        "EDGE_SWITCH_PRIOR",
    }
)
"""Tags of Vertigo, whose robust edges have variables or components of their own."""

EQUIV = "EQUIV"

IMAGES = frozenset(
    {
        "EDGE_SE3_TRACKUVD",
        "EDGE_SE3_TRACKDEPTH",
        "EDGE_PROJECT_DEPTH",
        "EDGE_PROJECT_DISPARITY",
        "PARAMS_CAMERACALIB",
        "PARAMS_CAMERAPARAMETERS",
    }
)
"""Tags of measurements in images with depth, and of the cameras that make them."""


@dataclass(frozen=True)
class Form:
    """What stands in a line after its tag: ids, measured numbers, information.

    Attributes
    ----------
    part : the records that it belongs to, named as the model's collection
    ids : number of vertices that it names
    shown : the measured numbers in words
    size : how many these are
    positions, rotations : rows of the information matrix; none for vertices and parameters
    offset : whether the id of a sensor offset follows those of the vertices
    order : order of the information's numbers if it is not that of the upper triangle
    euler : whether the rotation is roll, pitch and yaw
    """

    part: str
    ids: int
    shown: str
    size: int
    positions: int = 0
    rotations: int = 0
    offset: bool = False
    order: tuple[int, ...] | None = None
    euler: bool = False

    @property
    def tangent(self) -> int:
        """Rows of the information matrix."""
        return self.positions + self.rotations

    @property
    def information(self) -> int:
        """Numbers of the information matrix in the file."""
        return self.tangent * (self.tangent + 1) // 2

    @property
    def before(self) -> int:
        """Words before the measured numbers, with the tag."""
        return 1 + self.ids + self.offset


@dataclass(frozen=True)
class Kind:
    """One of the two kinds of graph.

    Attributes
    ----------
    name : ``SE2`` or ``SE3``
    forms : form of a line by tag; of several of one part the first is written
    rotation : shape of the model's ``th`` or ``q``
    rotation_field : ``th`` or ``q``
    model : the standard model of this structure
    """

    name: str
    forms: dict[str, Form]
    rotation: tuple[int, ...]
    rotation_field: str
    model: str

    def tag(self, part: str, rotations: bool = True) -> str:
        """The tag with which a line of a part is written.

        Parameters
        ----------
        rotations : False for a prior of a position alone
        """
        return next(
            tag
            for tag, form in self.forms.items()
            if form.part == part and (rotations or not form.rotations)
        )

    @cached_property
    def size(self) -> int:
        """Numbers of a pose in the file."""
        return self.forms[self.tag("poses")].size

    @cached_property
    def dimension(self) -> int:
        """Dimension of space."""
        return self.forms[self.tag("edges")].positions

    @cached_property
    def tangent(self) -> int:
        """Rows of an edge's information matrix."""
        return self.forms[self.tag("edges")].tangent

    @property
    def identity(self) -> list[float]:
        """The identity pose in the form of the file."""
        return [0.0] * self.size if self.size == 3 else [0.0] * 6 + [1.0]

    def fields(self, poses: Array) -> dict[str, Any]:
        """Columns of the model from poses in the form of the file."""
        if self.name == "SE2":
            return {"t": poses[:, :2], "th": poses[:, 2]}
        q = poses[:, [6, 3, 4, 5]]
        return {"t": poses[:, :3], "q": rotations.normalised(q)}

    def numbers(self, columns: dict[str, Array]) -> Array:
        """Poses in the form of the file from columns of the model."""
        if self.name == "SE2":
            return np.column_stack([columns["t"], columns["th"]])
        return np.column_stack([columns["t"], columns["q"][:, [1, 2, 3, 0]]])

    def matrices(self, poses: Array) -> Array:
        """Rotation matrices (n, d, d) of poses in the form of the file."""
        if self.name == "SE3":
            return rotations.matrix_from_quaternion(self.fields(poses)["q"])
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        found: Array = np.array([[c, -s], [s, c]]).transpose(2, 0, 1)
        return found

    def in_model(self, part: str, poses: Array, information: Array, back: bool = False) -> Array:
        """Information of measured poses for the axes in which the model has their positions.

        g2o has the error in the axes of the measured pose. The models have the position of an
        anchor in the axes of the world, and of an edge in space in those of its first pose.
        """
        if part == "edges" and self.name == "SE2":
            return information
        d, found = self.dimension, information.copy()
        even = information[:, :1, :1] * np.eye(d)
        uneven = (information[:, :d, :d] != even).any(axis=(1, 2))
        rows = np.flatnonzero(uneven | information[:, :d, d:].any(axis=(1, 2)))
        turn = np.tile(np.eye(self.tangent), (len(rows), 1, 1))
        turn[:, :d, :d] = self.matrices(poses[rows])
        if back:
            turn = turn.transpose(0, 2, 1)
        found[rows] = turn @ information[rows] @ turn.transpose(0, 2, 1)
        return found


_POSE2, _POSE3, _EULER3 = "x y theta", "x y z qx qy qz qw", "x y z roll pitch yaw"

SE2 = Kind(
    "SE2",
    {
        "VERTEX_SE2": Form("poses", 1, _POSE2, 3),
        "VERTEX2": Form("poses", 1, _POSE2, 3),
        "EDGE_SE2": Form("edges", 2, _POSE2, 3, 2, 1),
        "EDGE2": Form("edges", 2, _POSE2, 3, 2, 1, order=TORO_ORDER),
        "EDGE_PRIOR_SE2": Form("anchors", 1, _POSE2, 3, 2, 1),
        "EDGE_PRIOR_SE2_XY": Form("anchors", 1, "x y", 2, 2),
        "VERTEX_XY": Form("landmarks", 1, "x y", 2),
        "EDGE_SE2_XY": Form("observations", 2, "x y", 2, 2),
        "EDGE_SE2_POINTXY_OFFSET": Form("observations", 2, "x y", 2, 2, offset=True),
        "EDGE_BEARING_SE2_XY": Form("bearings", 2, "theta", 1, 0, 1),
        "EDGE_PRIOR_XY": Form("landmark_anchors", 1, "x y", 2, 2),
        "PARAMS_SE2OFFSET": Form("offsets", 1, _POSE2, 3),
    },
    rotation=(),
    rotation_field="th",
    model="pose_graph_2d",
)
SE3 = Kind(
    "SE3",
    {
        "VERTEX_SE3:QUAT": Form("poses", 1, _POSE3, 7),
        "VERTEX3": Form("poses", 1, _EULER3, 6, euler=True),
        "EDGE_SE3:QUAT": Form("edges", 2, _POSE3, 7, 3, 3),
        "EDGE3": Form("edges", 2, _EULER3, 6, 3, 3, euler=True),
        "EDGE_SE3_PRIOR": Form("anchors", 1, _POSE3, 7, 3, 3, offset=True),
        "EDGE_SE3_XYZ_PRIOR": Form("anchors", 1, "x y z", 3, 3, offset=True),
        "VERTEX_TRACKXYZ": Form("landmarks", 1, "x y z", 3),
        "EDGE_SE3_TRACKXYZ": Form("observations", 2, "x y z", 3, 3, offset=True),
        "EDGE_POINTXYZ_PRIOR": Form("landmark_anchors", 1, "x y z", 3, 3),
        "PARAMS_SE3OFFSET": Form("offsets", 1, _POSE3, 7),
    },
    rotation=(4,),
    rotation_field="q",
    model="pose_graph_3d",
)

PARTS = ("landmarks", "observations", "bearings", "landmark_anchors", "anchors")
"""Collections that a model may lack if the file has nothing for them."""


def kind_of(store: Store, name: str) -> Kind:
    """The kind of graph of a model; E0722 if its structure is neither."""
    for kind in (SE2, SE3):
        if _fits(store, kind):
            return kind
    shapes = " or ".join(f"`{k.model}`" for k in (SE2, SE3))
    raise AraelError(
        error(
            "E0722",
            f"`{store.layout.root}` of {store.layout.source} is not a pose graph of g2o's kinds",
            name,
            help=f"g2o files fill models with the collections and fields of {shapes}",
        ).diagnostics
    )


def _fits(store: Store, kind: Kind) -> bool:
    if not {"poses", "edges"} <= store.tables.keys():
        return False
    poses, edges = store.tables["poses"], store.tables["edges"]
    rotation = kind.rotation_field
    wanted = {"t": (kind.dimension,), rotation: kind.rotation}
    square = (kind.tangent, kind.tangent)
    for table, shapes in ((poses, wanted), (edges, {**wanted, "u": square})):
        for path, shape in shapes.items():
            if path not in table.data or table.data[path].shape != shape:
                return False
    for path in ("a", "b"):
        target = edges.data[path].target if path in edges.data else None
        if target is None or target.table != "poses":
            return False
    return all(poses.data[p].role == "param" for p in wanted)
