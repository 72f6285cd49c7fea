"""Bundler and COLMAP reconstructions: the same problem in each format has the same residuals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import arael
from arael import io
from arael.diagnostics.records import AraelError
from arael.io import DataWarning
from arael.io.formats import read_listing

VECTORS = np.array([[0.1, -0.2, 0.3], [0.0, 0.4, 0.1]])
MOVES = np.array([[1.0, 2.0, -3.0], [0.0, 0.5, -1.0]])
LENSES = np.array([[500.0, 1e-3, -2e-5], [400.0, 0.01, 0.0]])
POINTS = np.array([[0.5, -0.25, -8.0], [1.5, 0.75, -9.0], [-1.0, 0.5, -7.0]])
VIEWS = [(0, 0, -1.5, 2.0), (1, 0, 3.25, -4.5), (0, 1, 60.0, 30.5), (1, 2, -70.0, 12.25)]
CENTRE = np.array([320.0, 240.0])


def bal() -> str:
    cameras = np.hstack([VECTORS, MOVES, LENSES])
    lines = [f"2 3 {len(VIEWS)}", *(f"{c} {p} {x} {y}" for c, p, x, y in VIEWS)]
    return "\n".join([*lines, *map(str, cameras.ravel()), *map(str, POINTS.ravel())]) + "\n"


def bundler() -> str:
    """The same, with a camera before them that is not registered."""
    lines = ["# Bundle file v0.3", "3 3", "0 0 0", *["0 0 0"] * 4]
    for vector, move, lens in zip(VECTORS, MOVES, LENSES, strict=True):
        turn = Rotation.from_rotvec(vector).as_matrix()
        lines += [
            " ".join(map(repr, row)) for row in [lens.tolist(), *turn.tolist(), move.tolist()]
        ]
    for number, point in enumerate(POINTS):
        seen = [(c + 1, 17, x, y) for c, p, x, y in VIEWS if p == number]
        views = " ".join(" ".join(map(str, view)) for view in seen)
        lines += [" ".join(map(str, point)), "255 128 0", f"{len(seen)} {views}"]
    return "\n".join(lines) + "\n"


def colmap(folder: Path, first: str = "", second: str = "") -> Path:
    """The same, in COLMAP's axes; `first` and `second` are lines of other cameras."""
    folder.mkdir(exist_ok=True)
    flip = np.diag([1.0, -1.0, -1.0])
    (f, k1, k2), (g, h, _) = LENSES.tolist()
    one = first or f"7 RADIAL 640 480 {f} 320 240 {k1} {k2}"
    two = second or f"9 SIMPLE_RADIAL 640 480 {g} 320 240 {h}"
    (folder / "cameras.txt").write_text(f"# Camera list\n{one}\n{two}\n")
    lines = ["# Image list with two lines of data per image:"]
    for image, lens in enumerate((7, 9)):
        turn = Rotation.from_matrix(flip @ Rotation.from_rotvec(VECTORS[image]).as_matrix())
        x, y, z, w = turn.as_quat().tolist()
        move = (flip @ MOVES[image]).tolist()
        lines.append(" ".join(map(str, (image + 1, w, x, y, z, *move, lens, f"{image} a.png"))))
        seen = [f"{CENTRE[0] + u} {CENTRE[1] - v} {p + 100}" for c, p, u, v in VIEWS if c == image]
        lines.append(" ".join([*seen, "5.5 6.5 -1"]))
    (folder / "images.txt").write_text("\n".join(lines) + "\n")
    points = [f"{k + 100} {x} {y} {z} 1 2 3 0.5 1 0 2 0" for k, (x, y, z) in enumerate(POINTS)]
    (folder / "points3D.txt").write_text("\n".join(points) + "\n")
    return folder


def model() -> Any:
    return arael.load("bundle_adjustment", interpret=True)()  # type: ignore[call-arg]


def by_view(problem: Any) -> dict[tuple[int, int], list[float]]:
    """Residuals of each camera and point."""
    seen = problem.observations
    ends = zip(list(seen.camera.rows), list(seen.point.rows), strict=True)
    values = problem.jacobian().residuals.reshape(-1, 2).tolist()
    return {(int(c), int(p)): v for (c, p), v in zip(ends, values, strict=True)}


@pytest.fixture
def expected(tmp_path: Path) -> dict[tuple[int, int], list[float]]:
    (tmp_path / "same.bal").write_text(bal())
    problem = model()
    problem.read(tmp_path / "same.bal")
    return by_view(problem)


def agree(found: dict[tuple[int, int], list[float]], expected: object) -> bool:
    assert isinstance(expected, dict) and found.keys() == expected.keys()
    return all(found[k] == pytest.approx(expected[k], abs=1e-9) for k in found)


def test_bundler_has_the_residuals_of_bal(
    tmp_path: Path, expected: dict[tuple[int, int], list[float]]
) -> None:
    (tmp_path / "bundle.out").write_text(bundler())
    problem = model()
    with pytest.warns(DataWarning, match=r"W0701.*1 cameras that are not registered, the colours"):
        problem.read(tmp_path / "bundle.out")
    assert len(problem.cameras) == 2
    assert agree(by_view(problem), expected)


def test_colmap_has_the_residuals_of_bal(
    tmp_path: Path, expected: dict[tuple[int, int], list[float]]
) -> None:
    problem = model()
    lost = read_listing(problem, colmap(tmp_path / "sparse"))
    assert lost[2] == "2 features without a point"
    assert agree(by_view(problem), expected)
    # Distortion that a camera does not have is not solved for.
    assert problem.cameras.k1.fixed.tolist() == [False, False]
    assert problem.cameras.k2.fixed.tolist() == [False, True]


def test_bundler_in_and_bal_out(tmp_path: Path) -> None:
    (tmp_path / "bundle.out").write_text(bundler())
    problem, again = model(), model()
    read_listing(problem, tmp_path / "bundle.out")
    problem.write(tmp_path / "out.bal")
    again.read(tmp_path / "out.bal")
    assert agree(by_view(again), by_view(problem))


@pytest.mark.parametrize("format", ["bundler", "colmap"])
def test_they_are_not_written(tmp_path: Path, format: str) -> None:
    with pytest.raises(AraelError, match=rf"E0713.*{format} files are read and not written"):
        io.write(model(), tmp_path / "out", format)


@pytest.mark.parametrize(
    ("camera", "focal", "fixed"),
    [
        ("SIMPLE_PINHOLE 640 480 450 320 240", 450, (True, True)),
        ("PINHOLE 640 480 450 450 320 240", 450, (True, True)),
        ("OPENCV 640 480 450 450 320 240 0.1 0.2 0 0", 450, (False, False)),
    ],
)
def test_camera_models_that_map(
    tmp_path: Path, camera: str, focal: float, fixed: tuple[bool, bool]
) -> None:
    problem = model()
    read_listing(problem, colmap(tmp_path / "sparse", f"7 {camera}"))
    assert problem.cameras[0].f.value == focal
    assert (problem.cameras[0].k1.fixed, problem.cameras[0].k2.fixed) == fixed


@pytest.mark.parametrize(
    ("camera", "code", "words"),
    [
        ("7 OPENCV_FISHEYE 640 480 1 1 3 2 0 0 0 0", "E0726", "OPENCV_FISHEYE does not map"),
        ("7 PINHOLE 640 480 450 451 320 240", "E0726", "focal lengths differ"),
        ("7 OPENCV 640 480 450 450 320 240 0 0 1e-3 0", "E0726", "tangential distortion"),
        ("7 SIMPLE_RADAL 640 480 450 320 240 0", "E0716", "did you mean `SIMPLE_RADIAL`"),
        ("7 PINHOLE 640 480 450 450 320", "E0716", "PINHOLE has 4 parameters"),
        ("7 PINHOLE 640", "E0716", "expected `id MODEL width height`"),
        ("7 PINHOLE 640 480 450 inf 320 240", "E0705", "expected a finite number"),
        ("9 PINHOLE 640 480 450 450 320 240", "E0718", "camera 9 is given twice"),
        ("8 PINHOLE 640 480 450 450 320 240", "E0708", "camera 7 is not in cameras.txt"),
        ("x PINHOLE 640 480 450 450 320 240", "E0716", "expected the id of a camera"),
    ],
)
def test_wrong_cameras_are_named(tmp_path: Path, camera: str, code: str, words: str) -> None:
    with pytest.raises(AraelError, match=code) as failure:
        read_listing(model(), colmap(tmp_path / "sparse", camera))
    text = str(failure.value)
    assert words in text and ("cameras.txt:" in text or "images.txt:" in text)


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("images.txt", " -1", "", "images.txt:3:1: error[E0716]: expected `x y point`"),
        ("images.txt", " 100", " 999", "error[E0708]: point 999 is not in points3D.txt"),
        ("images.txt", "a.png", "", "error[E0716]: expected `id qw qx"),
        ("points3D.txt", " 0.5 1 0 2 0", "", "points3D.txt:1:1: error[E0716]"),
        ("points3D.txt", "101 ", "100 ", "error[E0718]: point 100 is given twice"),
        ("points3D.txt", "-8.0", "nan", "points3D.txt:1:15: error[E0705]"),
    ],
)
def test_wrong_lines_are_named(tmp_path: Path, file: str, old: str, new: str, words: str) -> None:
    folder = colmap(tmp_path / "sparse")
    text = (folder / file).read_text()
    assert old in text
    text = text.replace("1 a.png", "a.png").replace("0 a.png", "a.png") if not new else text
    (folder / file).write_text(text.replace(old, new))
    problem = model()
    with pytest.raises(AraelError) as failure:
        read_listing(problem, folder)
    assert words in str(failure.value)
    assert len(problem.cameras) == 0


def test_an_image_without_features_keeps_its_place(tmp_path: Path) -> None:
    folder = colmap(tmp_path / "sparse")
    lines = (folder / "images.txt").read_text().splitlines()
    (folder / "images.txt").write_text("\n".join([*lines[:2], "", *lines[3:]]) + "\n")
    problem = model()
    read_listing(problem, folder)
    assert len(problem.cameras) == 2 and len(problem.observations) == 2


def test_a_folder_is_recognised_or_refused(tmp_path: Path) -> None:
    with pytest.raises(AraelError, match=r"E0712.*found a directory"):
        model().read(tmp_path)
    (tmp_path / "cameras.bin").write_bytes(b"\0")
    with pytest.raises(AraelError, match=r"model_converter --output_type TXT"):
        model().read(tmp_path)
    (tmp_path / "cameras.txt").write_text("")
    with pytest.raises(AraelError, match=r"E0712.*the file is empty"):
        model().read(tmp_path)


def test_any_cut_of_a_bundle_file_is_refused(tmp_path: Path) -> None:
    content = bundler().encode()
    path = tmp_path / "bundle.out"
    for end in range(14, len(content) - 12, 11):
        path.write_bytes(content[:end])
        with pytest.raises(AraelError):
            read_listing(model(), path)


@pytest.mark.parametrize("file", ["bundle.out", "cameras.txt", "images.txt", "points3D.txt"])
def test_changed_characters_are_read_or_refused(tmp_path: Path, file: str) -> None:
    (tmp_path / "bundle.out").write_text(bundler())
    colmap(tmp_path)
    content = (tmp_path / file).read_bytes()
    rng = np.random.default_rng(0)
    problem = model()
    for place in rng.integers(14, len(content), 60).tolist():
        changed = bytearray(content)
        changed[place] = b"\0\n #,.-e_9\xff"[int(rng.integers(11))]
        (tmp_path / file).write_bytes(changed)
        try:
            read_listing(problem, tmp_path / file if file == "bundle.out" else tmp_path)
        except AraelError as failure:
            assert failure.diagnostics[0].code.startswith("E07")


def test_only_a_bundle_adjustment_takes_them(tmp_path: Path) -> None:
    (tmp_path / "bundle.out").write_text(bundler())
    for path in (tmp_path / "bundle.out", colmap(tmp_path / "sparse")):
        with pytest.raises(AraelError, match=r"E0722.*not a bundle adjustment"):
            arael.load("linear", interpret=True)().read(path)  # type: ignore[call-arg]
