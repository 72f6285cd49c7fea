"""COLMAP models as text, a folder of three files, for the model `bundle_adjustment`.

``cameras.txt``: ``id MODEL width height parameters``. ``images.txt``, two lines for each image:
``id qw qx qy qz tx ty tz camera name`` (world to camera) and ``x y point`` for each feature, point
-1 where there is none. ``points3D.txt``: ``id x y z r g b error`` and the track. COLMAP's camera
looks along z, x right, y down, and pixels are from the upper left corner; that of
`bundle_adjustment` looks along -z, y up, pixels from the principal point. The axes y and z change
sign. Source: COLMAP's documentation, "Output Format"; camera models in its
``src/colmap/sensor/models.h``.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io import files
from arael.io.bal import check_shape
from arael.io.lines import Lines
from arael.io.report import Report
from arael.runtime.store import Store, rotations
from arael.runtime.store.messages import shorten, suggestion

Array = NDArray[np.float64]

TEXTS = ("cameras.txt", "images.txt", "points3D.txt")
PARAMETERS = {
    "SIMPLE_PINHOLE": ("f", "cx", "cy"),
    "PINHOLE": ("fx", "fy", "cx", "cy"),
    "SIMPLE_RADIAL": ("f", "cx", "cy", "k1"),
    "RADIAL": ("f", "cx", "cy", "k1", "k2"),
    "OPENCV": ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"),
}
"""Names of the parameters of the camera models that can be read."""
OTHERS = (
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
    "RAD_TAN_THIN_PRISM_FISHEYE",
)
"""Camera models with another projection or more distortion than `bundle_adjustment` has."""
FLIP = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Lens:
    """Intrinsic parameters of one camera, and which of k1, k2 its model has."""

    number: int
    f: float
    centre: tuple[float, float]
    k1: float
    k2: float
    has: frozenset[str]


def is_folder(path: str) -> bool:
    """Whether a path is a folder with one of the files of a COLMAP model."""
    return os.path.isdir(path) and any(os.path.exists(os.path.join(path, t)) for t in TEXTS)


def is_binary_folder(path: str) -> bool:
    """Whether a folder holds a COLMAP model in binary form."""
    return os.path.isfile(os.path.join(path, "cameras.bin"))


def read(store: Store, path: str, limit: int) -> list[str]:
    """Replace the data of a bundle adjustment model by that of a COLMAP folder.

    Each image becomes a camera with the parameters of its COLMAP camera; distortion that the camera
    model does not have is fixed at 0.

    Returns
    -------
    what of the files the model has no field for

    Raises
    ------
    AraelError
        With file and line: E0712 a file is missing, E0716 malformed, E0705 not finite, E0708 an
        unknown camera or point, E0718 an id twice, E0721 not a rotation, E0726 a camera model that
        `bundle_adjustment` does not have; E0722 a model of another structure.
    """
    check_shape(store, files.shown(path))
    texts = {}
    for text in TEXTS:
        place = os.path.join(path, text)
        content = files.without_mark(files.read_bytes(place, limit), files.shown(place))
        limit -= len(content)
        texts[text] = (files.shown(place), content)
    lenses = _run(texts["cameras.txt"], _lenses)
    rows, places = _run(texts["points3D.txt"], _points)
    images = _run(texts["images.txt"], lambda lines: _images(lines, lenses, rows), True)
    fresh = store.fresh()
    _put(fresh, images, places)
    store.adopt(fresh)
    lost = [f"the names and ids of {len(images.lenses)} images"]
    lost += [f"the principal points of {len(images.lenses)} images"]
    if images.unmatched:
        lost.append(f"{images.unmatched} features without a point")
    shared = len(images.lenses) - len({lens.number for lens in images.lenses})
    if shared:
        lost.append(f"that {shared} images have the camera of another")
    return [*lost, f"the colours, errors and ids of {len(rows)} points"]


def _run(text: tuple[str, bytes], parse: Any, keep_empty: bool = False) -> Any:
    """Parse one file; its errors are raised together."""
    report = Report(text[0])
    found: list[Any] = []
    report.run(lambda: found.append(parse(Lines(*text, report, keep_empty=keep_empty))))
    return found[0]


def _lenses(lines: Lines) -> dict[int, Lens]:
    """Intrinsic parameters by the id of the camera."""
    found: dict[int, Lens] = {}
    for row, words in enumerate(lines.words):
        if len(words) < 4:
            lines.add("E0716", "expected `id MODEL width height` and parameters", row)
            continue
        id, model = lines.whole(row, 0, "the id of a camera"), words[1]
        if id in found:
            lines.add("E0718", f"camera {id} is given twice", row, 0)
        if model not in PARAMETERS:
            _refuse_model(lines, row, model)
            continue
        names = PARAMETERS[model]
        if len(words) != 4 + len(names):
            expected = f"{len(names)} parameters ({', '.join(names)})"
            lines.add("E0716", f"{model} has {expected}, found {len(words) - 4}", row)
            continue
        numbers = lines.reals([words[4:]], [row], 4, len(names))
        if len(numbers):
            lens = _lens(lines, row, model, dict(zip(names, numbers[0].tolist(), strict=True)))
            if lens is not None:
                found[id] = lens
    return found


def _refuse_model(lines: Lines, row: int, model: str) -> None:
    if model in OTHERS:
        lines.add(
            "E0726",
            f"the camera model {model} does not map to `bundle_adjustment`, which has a focal "
            "length and the radial distortion k1, k2",
            row,
            1,
            help=f"models that do: {', '.join(PARAMETERS)}",
        )
        return
    help = suggestion(model, [*PARAMETERS, *OTHERS])
    lines.add("E0716", f"COLMAP has no camera model `{shorten(model)}`", row, 1, help=help)


def _lens(lines: Lines, row: int, model: str, given: dict[str, float]) -> Lens | None:
    """Parameters as `bundle_adjustment` has them; None after reporting why they do not map."""
    fx = given.get("f", given.get("fx", 0.0))
    why = ""
    if given.get("fy", fx) != fx:
        why = f"its focal lengths differ (fx = {fx:g}, fy = {given['fy']:g})"
    elif given.get("p1") or given.get("p2"):
        why = "its tangential distortion p1, p2 is not 0"
    if why:
        at = 5 if "differ" in why else 10
        text = f"this {model} camera does not map to `bundle_adjustment`: {why}"
        lines.add("E0726", text, row, at, help="its model has one focal length and k1, k2")
        return None
    has = frozenset({"k1", "k2"} & given.keys())
    centre = (given["cx"], given["cy"])
    return Lens(
        lines.whole(row, 0, "the id of a camera"),
        fx,
        centre,
        given.get("k1", 0.0),
        given.get("k2", 0.0),
        has,
    )


def _points(lines: Lines) -> tuple[dict[int, int], Array]:
    """Row of a point by its id, and positions (N, 3)."""
    rows: dict[int, int] = {}
    kept, words_of = [], []
    for row, words in enumerate(lines.words):
        if len(words) < 8 or len(words) % 2:
            lines.add("E0716", "expected `id x y z r g b error` and pairs `image feature`", row)
            continue
        id = lines.whole(row, 0, "the id of a point")
        if id in rows:
            lines.add("E0718", f"point {id} is given twice", row, 0)
        rows[id] = len(rows)
        kept.append(row)
        words_of.append(words[1:4])
    return rows, lines.reals(words_of, kept, 1, 3)


@dataclass(frozen=True)
class Images:
    """Images and what they see.

    Attributes
    ----------
    poses : quaternion and translation, world to camera, of each image (N, 7)
    lenses : intrinsic parameters of each image
    camera, point : row of the image and of the point of each observation (M,)
    pixels : (M, 2), from the upper left corner
    unmatched : features that belong to no point
    """

    poses: Array
    lenses: list[Lens]
    camera: list[int]
    point: list[int]
    pixels: Array
    unmatched: int


def _images(lines: Lines, lenses: dict[int, Lens], points: dict[int, int]) -> Images:
    heads = _heads(lines)
    poses = lines.reals([lines.words[row][1:8] for row in heads], heads, 1, 7)
    norms = np.linalg.norm(poses[:, :4], axis=1)
    for k in np.flatnonzero(np.abs(norms - 1) > rotations.UNIT_TOLERANCE).tolist():
        lines.add(
            "E0721", f"expected a unit quaternion, found one of norm {norms[k]:.3g}", heads[k]
        )
    chosen, camera, point, unmatched = [], [], [], 0
    pixels: list[list[str]] = []
    rows: list[int] = []
    for image, row in enumerate(heads):
        lens = lines.whole(row, 8, "the id of a camera")
        if lens >= 0 and lens not in lenses:
            lines.add("E0708", f"camera {lens} is not in cameras.txt", row, 8)
        chosen.append(lenses.get(lens, Lens(-1, 1, (0, 0), 0, 0, frozenset())))
        words = lines.words[row + 1] if row + 1 < len(lines) else []
        if len(words) % 3:
            text = f"expected `x y point` for each feature, found {len(words)} values"
            lines.add("E0716", text, row + 1)
            continue
        for k in range(2, len(words), 3):
            if words[k] == "-1":
                unmatched += 1
                continue
            id = lines.whole(row + 1, k, "the id of a point, or -1")
            if id >= 0 and id not in points:
                lines.add("E0708", f"point {id} is not in points3D.txt", row + 1, k)
            camera.append(image)
            point.append(points.get(id, 0))
            pixels.append(words[k - 2 : k])
            rows.append(row + 1)
    found = lines.reals(pixels, rows, 0, 2)
    return Images(poses, chosen, camera, point, found, unmatched)


def _heads(lines: Lines) -> list[int]:
    """Rows of the first lines of images."""
    found: list[int] = []
    row = 0
    while row < len(lines):
        words = lines.words[row]
        if not words:
            row += 1
            continue
        if len(words) < 10:
            text = "expected `id qw qx qy qz tx ty tz camera name`"
            lines.add("E0716", f"{text}, found {len(words)} values", row)
        else:
            found.append(row)
        row += 2
    return found


def _put(store: Store, images: Images, places: Array) -> None:
    """Fill the tables: the axes y and z of cameras change sign, and y of pixels."""
    count, lenses = len(images.lenses), images.lenses
    turns = rotations.matrix_from_quaternion(rotations.normalised(images.poses[:, :4]))
    more: dict[str, Any] = {
        f"{name}.fixed": np.array([name not in lens.has for lens in lenses], np.bool_)
        for name in ("k1", "k2")
        if store.tables["cameras"].data[name].role == "param"
    }
    store.tables["cameras"].extend(
        count,
        r=rotations.quaternion_from_matrix(FLIP[:, None] * turns),
        t=FLIP * images.poses[:, 4:7],
        f=np.array([lens.f for lens in lenses]),
        k1=np.array([lens.k1 for lens in lenses]),
        k2=np.array([lens.k2 for lens in lenses]),
        **more,
    )
    store.tables["points"].extend(len(places), pos=places)
    centres = np.array([lens.centre for lens in lenses]).reshape(-1, 2)[images.camera]
    store.tables["observations"].extend(
        len(images.camera),
        camera=np.array(images.camera, np.int64),
        point=np.array(images.point, np.int64),
        pixel=(images.pixels - centres) * [1, -1],
    )
