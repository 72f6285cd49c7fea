"""A map of a model: points of its rows, the path through them, links, uncertainty, names."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError
from arael.plot.figure import BLUE, GREEN, GREY, INK, ORANGE, empty_figure, new_figure, styled
from arael.runtime.layout import Column, Layout

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

View = Literal["auto", "xy", "xz", "yz", "3d"]

SIGMAS = 2.0
"""Size of the ellipses in standard deviations."""
MAX_ELLIPSES = 60
"""Most ellipses of a collection: every k-th row has one."""
MAX_UNKNOWNS = 20_000
"""Most unknowns of a problem whose covariances are computed for a picture, which takes 1 s."""
MAX_NAMES = 30
"""Most rows of a collection whose names are drawn."""
MAX_LINKS = 4000
"""Most links between two collections: more hide the points."""
PATH = 0.8
"""Share of consecutive rows that are linked in a collection that is drawn as a path."""
FLAT = 0.25
"""A map is drawn in a plane if the smallest extent is below this share of the next."""
FAR = 0.5
"""Points are left out that are farther from 96 % of the points than this share of their extent."""
SIZES = (0.006, 0.04)
"""Least and largest size of the median ellipse, as a share of the extent: others are scaled."""

LENGTH = re.compile(r"([numcdkM]?m|met(er|re)s?|ft|inch)?")
"""Units of places; vectors in others, such as velocities and focal lengths, are no places."""

WORLD_TO_BODY = {("BundleAdjustment", "cameras"): "r"}
"""Rotations that, with the translation beside, lead from the world to a body, by root and path."""


@dataclass(frozen=True)
class Points:
    """Places of the rows of a collection.

    Attributes
    ----------
    places : (n, 2 or 3)
    covariances : (n, d, d) of the places; None: not known
    names : of the rows; None: they have none
    """

    places: Array
    covariances: Array | None = None
    names: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Links:
    """Pairs of rows (k, 2) that a measurement connects: of collection `a` and of `b`."""

    a: str
    b: str
    pairs: Ints


@dataclass(frozen=True)
class Map:
    """What a map shows.

    Attributes
    ----------
    points : by collection
    links : between them
    unit : of the places
    up : the axis that is drawn upwards in space
    """

    points: dict[str, Points]
    links: tuple[Links, ...] = ()
    unit: str = "m"
    up: str = "z"

    @property
    def is_a_point(self) -> bool:
        """Whether all of several rows are at one place, as before a solve from no start."""
        places = [one.places for one in self.points.values()]
        return sum(map(len, places)) > 1 and all((one == places[0][0]).all() for one in places)


def map_of(instance: Any, layout: Layout, uncertain: bool = False) -> Map | None:
    """The map of a model; None if no row of it has a place.

    Parameters
    ----------
    uncertain : whether covariances are computed; left out where the problem is singular or has
        more than `MAX_UNKNOWNS` unknowns
    """
    columns = _place_columns(instance, layout)
    if not columns:
        return None
    covariance = _covariance(instance) if uncertain else None
    points: dict[str, Points] = {}
    for table, column in columns.items():
        places = _places(instance, layout, table, column)
        spread = None
        if covariance is not None and (layout.root, table) not in WORLD_TO_BODY:
            spread = _marginals(covariance, table, column, places.shape[1])
        points[table] = Points(places, spread, _names(instance, layout, table))
    units = {layout.table(t).column(c).unit for t, c in columns.items()}
    unit = units.pop() if len(units) == 1 else ""
    images = any((layout.root, table) in WORLD_TO_BODY for table in points)
    up = "y" if images else "z"  # the y axis of images
    return Map(points, tuple(_links(instance, layout, points)), unit, up)


def _place_columns(instance: Any, layout: Layout) -> dict[str, str]:
    """The parameter that is the place, by collection: a vector or a transform."""
    found: dict[str, str] = {}
    pixels: dict[str, str] = {}
    for entity in layout.entities:
        for use in entity.params:
            plane = use.kind == "vec" and use.stored in (2, 3)
            nested = not entity.table or layout.table(entity.table).parent
            place = plane or use.kind in ("transform", "similarity")
            if place and not nested and len(instance[entity.table]):
                unit = layout.table(entity.table).column(use.column).unit
                if LENGTH.fullmatch(unit) or not plane:
                    found.setdefault(entity.table, use.column)
                elif unit == "px":
                    pixels.setdefault(entity.table, use.column)
    return found or pixels


def _places(instance: Any, layout: Layout, table: str, column: str) -> Array:
    rows = instance[table]
    places = np.array(rows[column].value, dtype=float).reshape(len(rows), -1)[:, :3]
    turned = WORLD_TO_BODY.get((layout.root, table))
    if turned is None:
        return places
    quaternions = np.array(rows[turned].value, dtype=float)
    w, v = quaternions[:, :1], quaternions[:, 1:]
    twice = 2 * np.cross(places, v)  # -R' t, by the conjugate of (w, v)
    return np.asarray(-(places + w * twice + np.cross(twice, v)))


def _covariance(instance: Any) -> Any:
    if instance._problem().size > MAX_UNKNOWNS:
        return None
    try:
        return instance.covariance()
    except AraelError:  # directions are free
        return None


def _marginals(covariance: Any, table: str, column: str, size: int) -> Array | None:
    try:
        found: Array = covariance.marginals(f"{table}.{column}")[:, :size, :size]
    except AraelError:  # parts are solved for apart
        return None
    return found if found.shape[1:] == (size, size) else None


def _names(instance: Any, layout: Layout, table: str) -> tuple[str, ...] | None:
    """Keys of the rows."""
    key, rows = layout.table(table).key, instance[table]
    if not key or len(rows) > MAX_NAMES:
        return None
    return tuple(str(text) for text in rows[key])


def _links(instance: Any, layout: Layout, points: dict[str, Points]) -> list[Links]:
    """Pairs of the rows that a row with two refs joins, or that a row and its own ref do."""
    found = []
    for table in layout.tables:
        refs = [c for c in table.columns if c.role == "ref" and c.target and _is_of_root(c)]
        ends = [(c.target.table, c) for c in refs if c.target and c.target.table in points]
        rows = 0 if table.parent or not table.path else len(instance[table.path])
        if not rows or not ends:
            continue
        at = [np.asarray(instance[table.path][c.path].rows) for _, c in ends]
        if len(ends) == 2:
            pairs, joined = np.column_stack(at), (ends[0][0], ends[1][0])
        elif len(ends) == 1 and ends[0][0] == table.path:
            pairs, joined = np.column_stack((at[0], np.arange(rows))), (table.path, table.path)
        else:
            continue
        pairs = pairs.astype(np.int64)
        found.append(Links(*joined, pairs[(pairs >= 0).all(axis=1)]))  # without null refs
    return found


def _is_of_root(column: Column) -> bool:
    """Whether a ref points into a collection of the root."""
    return column.target is not None and all(s.kind == "root" for s in column.target.base)


# --- the figure ------------------------------------------------------------------------------


def check_view(view: str) -> None:
    """Reject an unknown view; E0828."""
    if view not in get_args(View):
        raise wrong_argument("plot", "view", f"one of {', '.join(get_args(View))}", view)


def view_of(drawn: Map, view: View = "auto") -> View:
    """The view that shows most: a plane of two axes, or space where depth matters."""
    check_view(view)
    if all(p.places.shape[1] == 2 for p in drawn.points.values()):
        return "xy"
    if view != "auto":
        return view
    low, high = _extent(drawn, (0, 1, 2))
    order = np.argsort(-(high - low), kind="stable")
    extents = (high - low)[order]
    if extents[2] > FLAT * extents[1]:
        return "3d"
    names = "".join("xyz"[k] for k in sorted(order[:2]))
    return "xy" if names == "xy" else "xz" if names == "xz" else "yz"


def _extent(drawn: Map, axes: tuple[int, ...]) -> tuple[Array, Array]:
    """Least and largest coordinate of all but a few distant points."""
    low, high = [], []
    for k in axes:
        values = np.concatenate(
            [p.places[:, k] for p in drawn.points.values() if p.places.shape[1] > k]
        )
        values = values[np.isfinite(values)]
        if not len(values):
            values = np.zeros(1)
        a, b = np.quantile(values, (0.02, 0.98))
        reach = FAR * max(b - a, 1e-12)
        near = values[(values >= a - reach) & (values <= b + reach)]
        low.append(near.min())
        high.append(near.max())
    return np.array(low), np.array(high)


@styled
def map_figure(drawn: Map, title: str = "", subtitle: str = "", view: View = "auto") -> Figure:
    """Draw points, paths, links and ellipses, each collection in its own colour.

    Parameters
    ----------
    title, subtitle : what was solved, and how it ended
    view : plane of two axes, or ``3d``; see `view_of`
    """
    chosen = view_of(drawn, view)
    axes_of = (0, 1, 2) if chosen == "3d" else tuple("xyz".index(name) for name in chosen)
    low, high = _extent(drawn, axes_of)
    size = np.maximum(high - low, 1e-9 * max(1.0, float(np.abs(high).max())))
    span = float(size.max())
    if chosen == "3d":
        figure, axes = _space(low, high, drawn.up)
    else:
        width, height = np.maximum(size, 0.4 * span)
        height = float(np.clip(8.4 * height / width, 3.6, 8.0))
        figure, (axes,) = new_figure(9.0, height + 1.0)
        axes.set_aspect("equal")
        axes.grid(True)
        middle, half = (low + high) / 2, np.maximum((high - low) / 2, 0.2 * span) + 0.04 * span
        axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
        axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    unit = f" [{drawn.unit}]" if drawn.unit else ""
    for k, name in enumerate(axes_of):
        getattr(axes, f"set_{'xyz'[k]}label")(f"{'xyz'[name]}{unit}")
    margin = 0.02 * span if chosen == "3d" else 0.5 * span
    sheet = _Sheet(axes, axes_of, low - margin, high + margin, span)
    hidden = sheet.links(drawn)
    for (table, points), color in zip(
        drawn.points.items(), (BLUE, ORANGE, GREEN, INK) * 9, strict=False
    ):
        sheet.points(table, points, color)
    handles, labels = axes.get_legend_handles_labels()
    if len(handles) > 1:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=9)
    count = ", ".join(f"{len(p.places)} {table}" for table, p in drawn.points.items())
    lines = [title or count, *([f"{count}; {subtitle}" if subtitle else count] if title else [])]
    lines[-1] += f"; {sheet.left_out} far away left out" if sheet.left_out else ""
    lines[-1] += f"; {hidden} links not shown" if hidden else ""
    figure.suptitle("\n".join(lines), x=0.01, ha="left", color=INK, fontsize=11)
    return figure


def _space(low: Array, high: Array, up: str) -> tuple[Figure, Any]:
    flat = (high - low)["xyz".index(up)] < 0.5 * (high - low).max()
    figure = empty_figure(9.0, 6.0 if flat else 8.0)
    axes: Any = figure.add_subplot(projection="3d")
    axes.view_init(elev=24, azim=-62, vertical_axis=up)  # before the aspect, which it turns
    size = np.maximum(high - low, 1e-3 * float((high - low).max()) or 1.0)
    axes.set_box_aspect(np.maximum(size, 0.12 * size.max()))
    for name, a, b in zip("xyz", low, low + size, strict=True):
        getattr(axes, f"set_{name}lim")(a, b)
    return figure, axes


@dataclass
class _Sheet:
    """Axes, the coordinates that they show, and the limits of what is drawn."""

    axes: Any
    shown: tuple[int, ...]
    low: Array
    high: Array
    span: float
    left_out: int = 0

    def _project(self, places: Array) -> Array:
        """Coordinates (n, 2 or 3) that are shown; points of a plane lie at height 0."""
        whole = np.zeros((len(places), 3))
        whole[:, : places.shape[1]] = places
        return whole[:, self.shown]

    def _near(self, at: Array) -> NDArray[np.bool_]:
        return np.asarray(((at >= self.low) & (at <= self.high)).all(axis=1))

    def _lines(self, segments: Array, color: str, width: float, alpha: float) -> None:
        # imported here: start-up time
        from matplotlib.collections import LineCollection
        from mpl_toolkits.mplot3d.art3d import Line3DCollection

        kind = Line3DCollection if len(self.shown) == 3 else LineCollection
        near = self._near(segments[:, 0]) & self._near(segments[:, 1])
        drawn = kind(list(segments[near]), colors=color, linewidths=width, alpha=alpha, zorder=1)
        add = getattr(self.axes, "add_collection3d", None) or self.axes.add_collection
        add(drawn)

    def links(self, drawn: Map) -> int:
        """Draw paths and links; return how many are not shown."""
        hidden = 0
        for one in drawn.links:
            if one.a not in drawn.points or one.b not in drawn.points or not len(one.pairs):
                continue
            a = self._project(drawn.points[one.a].places)
            b = self._project(drawn.points[one.b].places)
            segments = np.stack((a[one.pairs[:, 0]], b[one.pairs[:, 1]]), axis=1)
            step = np.abs(one.pairs[:, 0] - one.pairs[:, 1]) == 1
            follows = one.a == one.b and step.sum() >= PATH * (len(a) - 1)
            if follows:
                self._lines(segments[step], BLUE, 1.2, 0.9)
                segments = segments[~step]
            if one.a != one.b and len(segments) > MAX_LINKS:
                hidden += len(segments)
            elif len(segments):
                self._lines(segments, GREY, 0.5, 0.5)
        return hidden

    def points(self, table: str, points: Points, color: str) -> None:
        """Draw the rows of a collection, their ellipses and names."""
        at = self._project(points.places)
        near = self._near(at)
        self.left_out += int((~near).sum())
        dot = float(np.clip(300 / np.sqrt(max(len(at), 1)), 1.2, 6.0))
        self.axes.plot(*at[near].T, ".", color=color, markersize=dot, label=table, zorder=3)
        if points.covariances is not None:
            apart = ORANGE if color == BLUE else color
            self._uncertainty(table, at, near, points.covariances, apart)
        for name, place, seen in zip(points.names or (), at, near, strict=False):
            if seen:
                self.axes.text(*place, f" {name}", color=INK, fontsize=8, zorder=4)

    def _uncertainty(
        self, table: str, at: Array, near: NDArray[np.bool_], covariances: Array, color: str
    ) -> None:
        """Ellipses, or in space the axes of ellipsoids, of every k-th row with a variance."""
        whole = np.zeros((len(at), 3, 3))
        size = covariances.shape[1]
        whole[:, :size, :size] = covariances
        part = whole[np.ix_(range(len(at)), self.shown, self.shown)]
        trace = np.trace(part, axis1=1, axis2=2)
        rows = np.flatnonzero(near & np.isfinite(part).all(axis=(1, 2)) & (trace > 0))
        if not len(rows):
            return
        rows = rows[:: -(-len(rows) // MAX_ELLIPSES)]
        values, vectors = np.linalg.eigh(part[rows])
        radii = SIGMAS * np.sqrt(np.maximum(values, 0.0))
        factor = _magnification(float(np.median(radii[:, -1])) / self.span)
        radii *= factor
        label = f"{SIGMAS:g} sigma of {table}" + (f", times {factor:,g}" if factor != 1 else "")
        self.axes.plot([], [], "o", color=color, fillstyle="none", label=label)
        if len(self.shown) == 3:
            arms = radii[:, None, :] * vectors  # columns are the axes
            ends = [
                np.stack((at[rows] - arms[:, :, k], at[rows] + arms[:, :, k]), 1) for k in range(3)
            ]
            self._lines(np.concatenate(ends), color, 0.9, 0.7)
            return
        draw_ellipses(self.axes, at[rows], radii, vectors, color)


def _magnification(share: float) -> float:
    """The round factor by which ellipses of this share of the extent are scaled, or 1."""
    least, most = SIZES
    if share <= 0 or least <= share <= most:
        return 1.0
    bound = most if share > most else least
    steps = np.array([step * 10.0**power for power in range(-12, 13) for step in (1, 2, 5)])
    fits = np.searchsorted(steps, bound / share, side="right" if share > most else "left")
    return float(steps[np.clip(fits - (share > most), 0, len(steps) - 1)])


def draw_ellipses(axes: Axes, centres: Array, radii: Array, vectors: Array, color: str) -> None:
    """Draw ellipses (n) with semi-axes `radii` (n, 2), rising, along columns of `vectors`."""
    # imported here: start-up time
    from matplotlib.collections import EllipseCollection

    ellipses = EllipseCollection(
        2 * radii[:, 1],
        2 * radii[:, 0],
        np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1])),
        units="xy",
        offsets=centres,
        offset_transform=axes.transData,
        facecolors="none",
        edgecolors=color,
        linewidths=0.8,
        alpha=0.8,
        zorder=4,
    )
    axes.add_collection(ellipses)
