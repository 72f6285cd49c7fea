"""`arael metrics`: errors of an estimated trajectory against a reference."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from arael.cli.exits import Exit
from arael.cli.options import json_option

if TYPE_CHECKING:
    from arael.metrics import Alignment, Errors, Trajectory

PARTS = ("translation", "angle_deg", "angle_rad", "rotation", "full", "distance", "distance_ratio")
"""Copy of `arael.metrics.errors.PARTS`, whose import would load NumPy for ``--help``."""
FORMATS = ("tum", "kitti", "euroc")
STATISTICS = ("rmse", "mean", "median", "std", "min", "max", "sse")


@click.command("metrics", short_help="Errors of a trajectory: ATE and RPE.")
@click.argument("reference", metavar="REF")
@click.argument("estimate", metavar="EST")
@click.option("--align", is_flag=True, help="Align EST to REF rigidly (Umeyama).")
@click.option("--scale", is_flag=True, help="Estimate the scale; without --align the scale alone.")
@click.option("--origin", is_flag=True, help="Align the first poses instead.")
@click.option(
    "--first", type=click.IntRange(min=3), help="Align by this many poses from the start."
)
@click.option(
    "--part",
    "parts",
    multiple=True,
    type=click.Choice(PARTS),
    help="What to measure, several times; translation and angle_deg by default.",
)
@click.option(
    "--max-diff",
    type=click.FloatRange(min=0),
    default=0.01,
    show_default=True,
    help="Largest difference of times of poses that belong together [s].",
)
@click.option("--offset", type=float, default=0.0, help="Added to the times of EST [s].")
@click.option(
    "--delta",
    type=float,
    default=1.0,
    show_default=True,
    help="Distance of the poses of a pair, for RPE.",
)
@click.option(
    "--unit",
    type=click.Choice(["frames", "m", "deg", "rad"]),
    default="frames",
    show_default=True,
    help="Unit of --delta.",
)
@click.option("--all-pairs", is_flag=True, help="Pairs from every pose, not only consecutive ones.")
@click.option("--format", type=click.Choice(FORMATS), help="Format of both files.")
@json_option
def command(
    reference: str,
    estimate: str,
    align: bool,
    scale: bool,
    origin: bool,
    first: int | None,
    parts: tuple[str, ...],
    max_diff: float,
    offset: float,
    delta: float,
    unit: str,
    all_pairs: bool,
    format: str | None,
    as_json: bool,
) -> int:
    """Compare the trajectory EST with REF: absolute (ATE) and relative (RPE) errors.

    Both are TUM, KITTI or EuRoC files. Poses belong together by time, or in order where neither
    file has times. The numbers are those of evo.
    """
    if origin and (align or scale):
        raise click.UsageError("--origin excludes --align and --scale")
    # imported here: start-up time
    from arael import io, metrics

    read = [io.read_trajectory(path, format) for path in (reference, estimate)]
    ref, est = metrics.associate(*read, max_diff=max_diff, offset=offset)
    est, alignment = _aligned(metrics, ref, est, align, scale, origin, first)
    wanted: Any = parts or ("translation", "angle_deg")
    options: Any = {"delta": delta, "unit": unit, "all_pairs": all_pairs}
    found: dict[str, list[Errors]] = {
        "ate": [metrics.ate(ref, est, part) for part in wanted if part != "distance_ratio"],
        "rpe": [metrics.rpe(ref, est, part, **options) for part in wanted],
    }
    if as_json:
        click.echo(json.dumps(_as_dict(read, ref, alignment, found)))
        return Exit.OK
    click.echo(f"{len(ref)} of {len(read[0])} and {len(read[1])} poses belong together")
    if alignment is not None:
        click.echo(f"aligned: scale {alignment.scale:.9g}")
    head = ("", *STATISTICS)
    lines: list[tuple[str, ...]] = [head]
    for name, errors in found.items():
        for one in errors:
            unit_of = f" [{one.unit}]" if one.unit else ""
            numbers = one.statistics.to_dict()
            label = f"{name.upper()} {one.part}{unit_of}"
            lines.append((label, *(f"{numbers[key]:.6g}" for key in STATISTICS)))
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    for label, *cells in lines:
        numbers_of = (cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True))
        click.echo(f"{label.ljust(widths[0])}  {'  '.join(numbers_of)}")
    return Exit.OK


def _aligned(
    metrics: Any,
    ref: Trajectory,
    est: Trajectory,
    align: bool,
    scale: bool,
    origin: bool,
    first: int | None,
) -> tuple[Trajectory, Alignment | None]:
    if origin:
        moved: tuple[Trajectory, Alignment] = metrics.align_origin(est, ref)
        return moved
    if align or scale:
        found: tuple[Trajectory, Alignment] = metrics.align(
            est, ref, scale=scale, only_scale=not align, first=first
        )
        return found
    return est, None


def _as_dict(
    read: list[Trajectory],
    ref: Trajectory,
    alignment: Alignment | None,
    found: dict[str, list[Errors]],
) -> dict[str, Any]:
    moved = None
    if alignment is not None:
        moved = {
            "rotation": alignment.rotation.tolist(),
            "translation": alignment.translation.tolist(),
            "scale": alignment.scale,
        }
    return {
        "status": "ok",
        "reference_poses": len(read[0]),
        "estimate_poses": len(read[1]),
        "associated": len(ref),
        "alignment": moved,
        **{
            name: {one.part: {**one.statistics.to_dict(), "unit": one.unit} for one in errors}
            for name, errors in found.items()
        },
    }
