"""Reconstructions of Snavely's Bundler, ``bundle.out``, for the model `bundle_adjustment`.

After the first line, ``# Bundle file v0.3``: numbers of cameras and points; for each camera ``f k1
k2``, three rows of the rotation (world to camera) and the translation; for each point the position,
the colour, and a list ``camera key x y`` after its length. The camera looks along its negative z
axis, and pixels are from the centre of the image, y up, as in BAL files. Source: the Bundler v0.4
manual.
"""

from __future__ import annotations

import numpy as np

from arael.io.bal import check_shape
from arael.io.lines import Lines
from arael.io.report import Report
from arael.runtime.store import Store, rotations

HEAD = b"# Bundle file"


def read(store: Store, content: bytes, name: str) -> list[str]:
    """Replace the data of a bundle adjustment model by that of a ``bundle.out``.

    Cameras that Bundler did not register (focal length 0) are left out.

    Returns
    -------
    what of the file the model has no field for

    Raises
    ------
    AraelError
        With file and line: E0716 not a number, or too few or too many; E0705 not finite; E0708 a
        camera out of range or not registered; E0721 not a rotation; E0722 a model of another
        structure.
    """
    check_shape(store, name)
    report = Report(name)
    fresh = store.fresh()
    lost: list[str] = []
    report.run(lambda: lost.extend(_fill(fresh, Lines(name, content, report))))
    store.adopt(fresh)
    return lost


def _fill(store: Store, lines: Lines) -> list[str]:
    counts = _counts(lines)
    lines.report.halt()
    cameras, points = counts
    if len(lines) != 1 + 5 * cameras + 3 * points:
        lines.add(
            "E0716",
            f"{cameras} cameras and {points} points take {1 + 5 * cameras + 3 * points} lines, "
            f"found {len(lines)}",
            min(len(lines), 1 + 5 * cameras + 3 * points) - 1,
            help="the file is truncated, or its first line is wrong",
        )
        lines.report.halt()
    numbers = _block(lines, 1, 5 * cameras, 3, "a row of a camera").reshape(-1, 5, 3)
    first = 1 + 5 * cameras
    places = _block(lines, first, 3 * points, 3, "the position of a point", 3)
    lines.report.halt()

    registered = numbers[:, 0, 0] != 0
    turns = numbers[:, 1:4]
    for camera in np.flatnonzero(registered & ~rotations.is_rotation(turns)).tolist():
        lines.add("E0721", f"the matrix of camera {camera} is not a rotation", 2 + 5 * camera)
    row_of = np.where(registered, np.cumsum(registered) - 1, -1)
    seen_by, point, pixels = _views(lines, first, points, row_of)
    lines.report.halt()
    kept = numbers[registered]
    store.tables["cameras"].extend(
        len(kept),
        r=rotations.quaternion_from_matrix(turns[registered]),
        t=kept[:, 4],
        f=kept[:, 0, 0],
        k1=kept[:, 0, 1],
        k2=kept[:, 0, 2],
    )
    store.tables["points"].extend(points, pos=places)
    store.tables["observations"].extend(len(seen_by), camera=seen_by, point=point, pixel=pixels)
    absent = cameras - len(kept)
    lost = [f"{absent} cameras that are not registered"] if absent else []
    lost += [f"the colours of {points} points"] if points else []
    return lost + ([f"the keys of {len(seen_by)} observations"] if seen_by else [])


def _counts(lines: Lines) -> tuple[int, int]:
    if not len(lines) or len(lines.words[0]) != 2:
        lines.add("E0716", "expected the numbers of cameras and points", 0)
        return 0, 0
    return (
        lines.whole(0, 0, "a number of cameras"),
        lines.whole(0, 1, "a number of points"),
    )


def _block(
    lines: Lines, first: int, count: int, width: int, what: str, step: int = 1
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Every `step`-th line of a block as numbers (lines, width)."""
    rows = range(first, first + count, step)
    wrong = [row for row in rows if len(lines.words[row]) != width]
    for row in wrong:
        text = f"expected {width} numbers ({what}), found {len(lines.words[row])}"
        lines.add("E0716", text, row)
    if wrong:
        return np.empty((0, width))
    return lines.reals([lines.words[row] for row in rows], rows, 0, width)


def _views(
    lines: Lines, first: int, points: int, row_of: np.ndarray[tuple[int], np.dtype[np.int64]]
) -> tuple[list[int], list[int], np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Camera rows, points and pixels (N, 2) of all observations."""
    cameras: list[int] = []
    owners: list[int] = []
    pixels: list[list[str]] = []
    rows: list[int] = []
    for point in range(points):
        row = first + 3 * point + 2
        words = lines.words[row]
        count = lines.whole(row, 0, "a number of views")
        if count < 0:
            continue
        if len(words) != 1 + 4 * count:
            text = f"{count} views take {1 + 4 * count} numbers, found {len(words)}"
            lines.add("E0716", text, row)
            continue
        for k in range(count):
            camera = lines.whole(row, 1 + 4 * k, "a camera")
            if camera >= len(row_of) or (camera >= 0 and row_of[camera] < 0):
                text = "is not registered" if camera < len(row_of) else "is not in the file"
                lines.add("E0708", f"camera {camera} {text}", row, 1 + 4 * k)
                camera = -1
            cameras.append(int(row_of[camera]) if camera >= 0 else -1)
            owners.append(point)
            pixels.append(words[3 + 4 * k : 5 + 4 * k])
            rows.append(row)
    found = lines.reals(pixels, rows, 3, 2)
    return cameras, owners, found
