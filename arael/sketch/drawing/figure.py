"""Layouts as PNG and PDF, by matplotlib."""

from __future__ import annotations

from io import BytesIO
from math import degrees
from typing import Any, Literal

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.drawing.primitives import Layout, Path
from arael.sketch.drawing.themes import THEMES, Theme


def to_image(
    drawing: Layout,
    kind: Literal["png", "pdf"],
    theme: Theme = "light",
    *,
    pixels_per_unit: float = 2.0,
) -> bytes:
    """A layout as the bytes of a PNG or PDF file.

    Parameters
    ----------
    pixels_per_unit
        Pixels of the PNG for one of the layout. A PDF has 96 units of the layout to the inch.

    Raises
    ------
    AraelError
        E1305: matplotlib is not installed.
    """
    try:
        # imported here: start-up time
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        # imported here: start-up time
        from matplotlib.figure import Figure
    except ImportError:
        raise AraelError(
            Diagnostic(
                "E1305",
                f"a {kind.upper()} picture is drawn by matplotlib, which is not installed",
                help=('pip install "arael[plot]"',),
            )
        ) from None
    colours = THEMES[theme]
    figure = Figure(figsize=(drawing.width / 96, drawing.height / 96), dpi=96 * pixels_per_unit)
    FigureCanvasAgg(figure)
    figure.patch.set_facecolor(colours["background"])
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(0, drawing.width)
    axes.set_ylim(drawing.height, 0)
    for depth, item in enumerate(drawing.items):
        if isinstance(item, Path):
            axes.add_patch(_patch(item, colours, depth))
        else:
            # imported here: start-up time
            from matplotlib.patheffects import withStroke

            axes.text(
                item.x, item.y, item.text.replace("$", r"\$"), size=item.size * 0.75,
                color=colours[item.role], rotation=degrees(item.angle), rotation_mode="anchor",
                ha={"start": "left", "middle": "center", "end": "right"}[item.anchor],
                va="center", zorder=depth,
                path_effects=[withStroke(linewidth=2.2, foreground=colours["background"])],
            )  # fmt: skip
    stream = BytesIO()
    metadata: dict[str, Any] = {"Title": drawing.title, "Creator": "arael"}
    if kind == "pdf":
        metadata["CreationDate"] = None  # the same sketch gives the same file
    else:
        metadata = {"Title": drawing.title, "Software": "arael"}
    figure.savefig(stream, format=kind, metadata=metadata)
    return stream.getvalue()


def _patch(item: Path, colours: Any, depth: int) -> Any:
    # imported here: start-up time
    from matplotlib.patches import PathPatch

    # imported here: start-up time
    from matplotlib.path import Path as Outline

    codes: list[Any] = []
    points: list[tuple[float, float]] = []
    start = (0.0, 0.0)
    for command, numbers in item.segments:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
        if command == "Z":
            codes.append(Outline.CLOSEPOLY)
            points.append(start)
            continue
        if command == "M":
            start = pairs[0]
        code = {"M": Outline.MOVETO, "L": Outline.LINETO, "C": Outline.CURVE4}[command]
        codes += [code] * len(pairs)
        points += pairs
    width = item.width * 0.75  # points of 1/72 inch
    dash: Any = (0, tuple(d / item.width for d in item.dash)) if item.dash and width else "solid"
    return PathPatch(
        Outline(points, codes),
        fill=bool(item.fill),
        facecolor=colours[item.fill] if item.fill else "none",
        edgecolor=colours[item.role] if width > 0 else "none",
        linewidth=width,
        linestyle=dash,
        capstyle="butt" if item.dash else "round",
        joinstyle="round",
        alpha=item.opacity,
        zorder=depth,
    )
