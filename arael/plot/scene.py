"""A solved scene from above: path, landmarks, uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, GREY, INK, ORANGE, new_figure, styled
from arael.plot.map import SIGMAS, draw_ellipses

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """What to draw, all in the frame of the truth [m].

    Attributes
    ----------
    true_poses, start_poses, poses : (n, 3)
    true_landmarks : (m, 3)
    landmarks : (m, 3), or None if they were known
    covariances : (m, 3, 3) of the landmarks, NaN where unknown; None without any
    title : of the figure
    """

    true_poses: Array
    start_poses: Array
    poses: Array
    true_landmarks: Array
    landmarks: Array | None
    covariances: Array | None
    title: str


@styled
def scene_figure(view: View) -> Figure:
    """Draw the whole scene on the left, and the path, enlarged, on the right."""
    figure, (whole, path) = new_figure(13.0, 6.2, columns=2)
    _landmarks(whole, view)
    _path(whole, view, detail=False)
    whole.set_title(view.title, color=INK)
    _path(path, view, detail=True)
    path.set_title("path", color=INK)
    for axes in (whole, path):
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(True)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
    _legend(figure, whole, path, ellipses=view.covariances is not None)
    return figure


def _legend(figure: Figure, whole: Axes, path: Axes, ellipses: bool) -> None:
    """One legend below both plots."""
    entries: dict[str, Any] = {}
    for axes in (path, whole):
        handles, labels = axes.get_legend_handles_labels()
        entries = {**dict(zip(labels, handles, strict=True)), **entries}
    if ellipses:
        # imported here: start-up time
        from matplotlib.lines import Line2D

        name = f"{SIGMAS:g} sigma relative to the closest pose"
        entries[name] = Line2D([], [], marker="o", color=ORANGE, fillstyle="none", linestyle="")
    figure.legend(
        list(entries.values()),
        list(entries),
        loc="outside lower center",
        ncols=len(entries),
        fontsize=9,
    )


def _path(axes: Axes, view: View, detail: bool) -> None:
    if detail:
        axes.plot(*view.true_poses[:, :2].T, color=FAINT, linewidth=6, zorder=1, label="truth")
        start = view.start_poses[:, :2]
        axes.plot(*start.T, ".", color=ORANGE, markersize=5, zorder=2, label="start")
    size = 4 if detail else 2
    axes.plot(
        *view.poses[:, :2].T,
        "o-",
        color=BLUE,
        markersize=size,
        linewidth=1.0,
        zorder=3,
        label="solved poses",
    )


def _landmarks(axes: Axes, view: View) -> None:
    true = view.true_landmarks[:, :2]
    if view.landmarks is None:
        axes.plot(*true.T, "+", color=GREY, markersize=5, label="landmarks (known)")
        return
    axes.plot(*true.T, "+", color=GREY, markersize=5, zorder=2, label="true landmarks")
    axes.plot(
        *view.landmarks[:, :2].T,
        ".",
        color=ORANGE,
        markersize=3,
        zorder=4,
        label="solved landmarks",
    )
    if view.covariances is not None:
        _ellipses(axes, view.landmarks, view.covariances)


def _ellipses(axes: Axes, centres: Array, covariances: Array) -> None:
    """Draw ellipses of `SIGMAS` standard deviations in the plane."""
    known = np.isfinite(covariances[:, 0, 0])
    if known.any():
        values, vectors = np.linalg.eigh(covariances[known, :2, :2])
        radii = SIGMAS * np.sqrt(np.maximum(values, 0.0))
        draw_ellipses(axes, centres[known, :2], radii, vectors, ORANGE)
