"""Points that start behind cameras, treated in several ways: ``python -m benchmarks.behind``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.runtime.store import rotations
from benchmarks.cases import DATA
from benchmarks.measure import machine, table

Array = NDArray[Any]
FILE = DATA / "bundle_adjustment" / "problem-49-7776-pre.txt"


class Bundle:
    """The bundle of the file, with what the treatments need."""

    def __init__(self) -> None:
        self.model = arael.load("bundle_adjustment")()
        self.model.read(FILE)
        tables = self.model._store.tables
        self.camera = tables["observations"].target_rows("camera").copy()
        self.point = tables["observations"].target_rows("point").copy()
        self.bad = np.unique(self.point[self.depth() <= 0])
        self.sights = np.isin(self.point, self.bad)

    def depth(self) -> Array:
        """Distance of each observed point before its camera, negative behind it."""
        cameras = self.model.cameras
        turn = rotations.matrix_from_quaternion(np.array(cameras.r.value))[self.camera]
        at = np.einsum("nij,nj->ni", turn, self.model.points.pos.value[self.point])
        depth: Array = -(at + cameras.t.value[self.camera])[:, 2]
        return depth

    def rays(self) -> tuple[Array, Array]:
        """Centres and directions of the sights of the points that start behind."""
        cameras, camera = self.model.cameras, self.camera[self.sights]
        turn = rotations.matrix_from_quaternion(np.array(cameras.r.value))[camera]
        pixel = np.array(self.model.observations.pixel)[self.sights]
        way = np.column_stack([pixel / cameras.f.value[camera, None], -np.ones(len(camera))])
        way /= np.linalg.norm(way, axis=1)[:, None]
        centre = -np.einsum("nji,nj->ni", turn, cameras.t.value[camera])
        return centre, np.einsum("nji,nj->ni", turn, way)


def left(bundle: Bundle) -> None:
    """Leave them where they are."""


def triangulated(bundle: Bundle) -> None:
    """Move them to where their rays come nearest to each other, whichever side that is."""
    centre, way = bundle.rays()
    which = np.searchsorted(bundle.bad, bundle.point[bundle.sights])
    across = np.eye(3) - way[:, :, None] * way[:, None, :]
    matrix, right = np.zeros((len(bundle.bad), 3, 3)), np.zeros((len(bundle.bad), 3, 1))
    np.add.at(matrix, which, across)
    np.add.at(right, which, across @ centre[:, :, None])
    bundle.model.points.pos.value[bundle.bad] = np.linalg.solve(matrix, right)[:, :, 0]


def far(bundle: Bundle) -> None:
    """Move them ten times the median depth before their cameras."""
    centre, way = bundle.rays()
    which = bundle.point[bundle.sights]
    away = 10 * np.median(bundle.depth())
    for point in bundle.bad:
        own = which == point
        bundle.model.points.pos.value[point] = centre[own].mean(0) + away * way[own].mean(0)


def dropped(bundle: Bundle) -> None:
    """Leave out the points and what is seen of them."""
    whole, bundle.model = bundle.model, arael.load("bundle_adjustment")()
    cameras, kept = whole.cameras, ~bundle.sights
    columns = {name: np.array(cameras[name].value) for name in ("r", "t", "f", "k1", "k2")}
    bundle.model.cameras.extend(len(cameras), **columns)
    bundle.model.points.extend(pos=np.delete(np.array(whole.points.pos.value), bundle.bad, axis=0))
    stays = ~np.isin(np.arange(len(whole.points)), bundle.bad)
    bundle.point = (np.cumsum(stays) - 1)[bundle.point[kept]]
    bundle.camera = bundle.camera[kept]
    pixel = np.array(whole.observations.pixel)[kept]
    bundle.model.observations.extend(
        int(kept.sum()), camera=bundle.camera, point=bundle.point, pixel=pixel
    )


WAYS: tuple[Callable[[Bundle], None], ...] = (left, triangulated, far, dropped)


def main() -> None:
    """Print a table."""
    rows = []
    for way in WAYS:
        bundle = Bundle()
        way(bundle)
        behind = int((bundle.depth() <= 0).sum())
        result = bundle.model.solve()
        after = int((bundle.depth() <= 0).sum())
        cost = f"{result.end_cost:.1f}"
        rows.append([way.__name__, behind, result.status, cost, result.iterations, after])
    head = ("points behind", "sights behind", "status", "cost", "attempts", "behind at the end")
    print("\n".join([*machine(), "", *table(head, rows)]))


if __name__ == "__main__":
    main()
