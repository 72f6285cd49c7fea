"""Differences between planar and spatial pose graphs: tags, numbers per line, fields of the model.

A pose is a row of numbers in the file: ``x y theta`` or ``x y z qx qy qz qw``. The information
matrix of an edge is its upper triangle, row by row.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime.store import Store, rotations
from arael.runtime.store.messages import error

Array = NDArray[Any]

# TORO's EDGE2 gives the information as xx xy yy tt xt yt (tt: heading).
TORO_ORDER = [0, 1, 4, 2, 5, 3]


@dataclass(frozen=True)
class Kind:
    """One of the two kinds of graph.

    Attributes
    ----------
    name : ``SE2`` or ``SE3``
    vertex, edge : tags for writing
    vertices, edges : tags for reading, and for edges the order of the information's numbers
    size : numbers of a pose in the file
    tangent : rows of the information matrix
    position, rotation : shapes of the model's ``t`` and of its ``th`` or ``q``
    rotation_field : ``th`` or ``q``
    model : the standard model of this structure
    prior : tag of a prior on one vertex
    offset : tag of the sensor offset that a prior names after its vertex; "" if it names none
    """

    name: str
    vertex: str
    edge: str
    vertices: frozenset[str]
    edges: dict[str, list[int] | None]
    size: int
    tangent: int
    position: tuple[int, ...]
    rotation: tuple[int, ...]
    rotation_field: str
    model: str
    prior: str
    offset: str

    @property
    def identity(self) -> list[float]:
        """The identity pose in the form of the file."""
        return [0.0] * self.size if self.size == 3 else [0.0] * 6 + [1.0]

    @property
    def unit_information(self) -> list[float]:
        """The upper triangle of a unit matrix."""
        n = self.tangent
        return [float(i == j) for i in range(n) for j in range(i, n)]

    @property
    def information(self) -> int:
        """Numbers of an information matrix in the file."""
        return self.tangent * (self.tangent + 1) // 2

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


SE2 = Kind(
    "SE2",
    "VERTEX_SE2",
    "EDGE_SE2",
    frozenset({"VERTEX_SE2", "VERTEX2"}),
    {"EDGE_SE2": None, "EDGE2": TORO_ORDER},
    3,
    3,
    (2,),
    (),
    "th",
    "pose_graph_2d",
    "EDGE_PRIOR_SE2",
    "",
)
SE3 = Kind(
    "SE3",
    "VERTEX_SE3:QUAT",
    "EDGE_SE3:QUAT",
    frozenset({"VERTEX_SE3:QUAT"}),
    {"EDGE_SE3:QUAT": None},
    7,
    6,
    (3,),
    (4,),
    "q",
    "pose_graph_3d",
    "EDGE_SE3_PRIOR",
    "PARAMS_SE3OFFSET",
)


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
    wanted = {"t": kind.position, rotation: kind.rotation}
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
