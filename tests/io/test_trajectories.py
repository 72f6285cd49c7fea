"""Trajectories in TUM, KITTI and EuRoC files, and as collections of poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael import io
from arael.diagnostics.records import AraelError
from arael.io import DataWarning, Trajectory
from arael.io.formats import TRAJECTORIES, read_listing
from arael.runtime.store import Store, rotations
from tests.io.cases import layout_of
from tests.optional import require

POSES = """
struct Pose {
    param t: vec3
    param q: quaternion
    skip time: real [s] = 0
    skip note: int = 7
    constraint origin { t }
}
root Path { poses: list of Pose }
"""


def some(count: int = 6, full: bool = False, seed: int = 0) -> Trajectory:
    rng = np.random.default_rng(seed)
    q = rng.standard_normal((count, 4))
    more = {}
    if full:
        parts = ("velocities", "gyro_biases", "accel_biases")
        more = {name: rng.standard_normal((count, 3)) for name in parts}
    return Trajectory(
        rng.standard_normal((count, 3)) * 10,
        q / np.linalg.norm(q, axis=1)[:, None],
        stamps=1403636579763555584 + np.arange(count) * 5_000_001,
        **more,
    )


def same_rotation(a: np.ndarray, b: np.ndarray, most: float = 1e-15) -> bool:
    """Whether quaternions are those of the same rotations."""
    return bool(np.abs(np.abs((a * b).sum(axis=1)) - 1).max() <= most * 4)


def store_of(text: str) -> Store:
    return Store(layout_of(text))


# --- files ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("format", TRAJECTORIES)
@pytest.mark.parametrize("ending", ["", ".gz"])
def test_written_and_read_again_it_is_the_same(tmp_path: Path, format: str, ending: str) -> None:
    given = some(full=True)
    path = tmp_path / f"path.{format}{ending}"
    io.write_trajectory(given, path)
    again = io.read_trajectory(path)
    assert again.positions.tolist() == given.positions.tolist()
    if format == "kitti":
        assert again.times is None and again.stamps is None
        assert same_rotation(again.quaternions, given.quaternions)
        return
    assert again.quaternions == pytest.approx(given.quaternions, abs=1e-15)
    assert again.stamps is not None and given.stamps is not None
    assert again.stamps.tolist() == given.stamps.tolist()
    for name in ("velocities", "gyro_biases", "accel_biases"):
        kept = getattr(again, name)
        assert (kept is None) == (format == "tum")
        if kept is not None:
            assert kept.tolist() == getattr(given, name).tolist()


def test_velocities_alone_take_eleven_columns(tmp_path: Path) -> None:
    given = some(3)
    path = tmp_path / "path.euroc"
    io.write_trajectory(
        Trajectory(given.positions, given.quaternions, given.times, velocities=np.ones((3, 3))),
        path,
    )
    assert len(path.read_text().splitlines()[1].split(",")) == 11
    again = io.read_trajectory(path)
    assert again.velocities is not None and again.gyro_biases is None


def test_a_time_with_more_than_nine_decimals_is_a_number(tmp_path: Path) -> None:
    path = tmp_path / "path.tum"
    path.write_text("0.12345678901 0 0 0 0 0 0 1\n")
    found = io.read_trajectory(path)
    assert found.stamps is None and found.times is not None
    assert found.times.tolist() == [0.12345678901]


def test_times_before_zero_are_kept(tmp_path: Path) -> None:
    given = Trajectory(np.zeros((2, 3)), [[1, 0, 0, 0]] * 2, stamps=np.array([-1_500_000_000, 3]))
    for format in ("tum", "euroc"):
        io.write_trajectory(given, tmp_path / f"path.{format}")
        again = io.read_trajectory(tmp_path / f"path.{format}")
        assert again.times is not None and again.times.tolist() == [-1.5, 3e-9]


def test_a_rounded_quaternion_is_normalised(tmp_path: Path) -> None:
    path = tmp_path / "path.tum"
    path.write_text("0 1 2 3 0.0 0.0 0.707 0.707\n")
    assert np.linalg.norm(io.read_trajectory(path).quaternions) == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize(
    ("name", "format"),
    [("poses.txt", "tum"), ("00.txt", "kitti"), ("data.csv", "euroc"), ("nameless", "tum")],
)
def test_the_format_follows_from_the_content(tmp_path: Path, name: str, format: str) -> None:
    io.write_trajectory(some(), tmp_path / name, format)
    content = (tmp_path / name).read_bytes()
    assert io.format_of(tmp_path / name, content) == format
    assert len(io.read_trajectory(tmp_path / name)) == 6


def test_a_bundle_adjustment_is_no_trajectory() -> None:
    assert io.format_of("x.txt", b"2 1 2\n0 0 -1.5 2.0\n") == "bal"
    assert io.format_of("x.txt", b"1 2\n4 5\n") == ""


@pytest.mark.parametrize("format", TRAJECTORIES)
def test_evo_reads_the_same(tmp_path: Path, format: str) -> None:
    require("evo")
    from evo.tools import file_interface

    reader = {
        "tum": file_interface.read_tum_trajectory_file,
        "kitti": file_interface.read_kitti_poses_file,
        "euroc": file_interface.read_euroc_csv_trajectory,
    }[format]
    given = some(full=True)
    path = tmp_path / f"path.{format}"
    io.write_trajectory(given, path)
    found = reader(str(path))
    assert found.positions_xyz.tolist() == given.positions.tolist()
    assert same_rotation(found.orientations_quat_wxyz, given.quaternions)
    if format != "kitti":
        assert given.times is not None
        assert found.timestamps == pytest.approx(given.times, abs=1e-6)


@pytest.mark.parametrize("format", ["tum", "kitti"])
def test_what_evo_writes_is_read(tmp_path: Path, format: str) -> None:
    require("evo")
    from evo.core.trajectory import PoseTrajectory3D
    from evo.tools import file_interface

    given = some()
    theirs = PoseTrajectory3D(given.positions, given.quaternions, given.times)
    path = str(tmp_path / f"path.{format}")
    write = {
        "tum": file_interface.write_tum_trajectory_file,
        "kitti": file_interface.write_kitti_poses_file,
    }[format]
    write(path, theirs)
    again = io.read_trajectory(path)
    assert again.positions == pytest.approx(given.positions, rel=1e-15)
    assert same_rotation(again.quaternions, given.quaternions)


# --- collections of poses ------------------------------------------------------------------------

SHAPES = {
    "quaternion": "param t: vec3; param q: quaternion; skip time: real = 0",
    "euler": "param pos: vec3; param ea: euler; skip stamp: real [s] = 0",
    "rotation": "param pos: vec3; param att: rotation; skip time_ns: int = 0",
    "transform": "param T: transform; skip time: real = 0",
    "velocity": "param v: vec3; param p: vec3; param q: quaternion; skip time: real = 0",
    "data": "t: vec3; q: quat; skip time: real = 0; param s: real = 1",
}


def model_of(fields: str) -> str:
    return f"struct Pose {{ {fields} }}\nroot Path {{ param a: real = 0; path: list of Pose }}"


@pytest.mark.parametrize("fields", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("format", TRAJECTORIES)
def test_poses_are_found_by_type(tmp_path: Path, fields: str, format: str) -> None:
    given = some(full="v: vec3" in fields)
    path = tmp_path / f"in.{format}"
    io.write_trajectory(given, path)
    store = store_of(model_of(fields))
    if "v: vec3" in fields and format != "euroc":
        with pytest.raises(AraelError, match=r"E0702.*`v` is missing"):
            read_listing(store, path)
        return
    lost = read_listing(store, path)
    assert lost == (["gyro biases", "accel biases"] if "v: vec3" in fields else [])
    assert store.tables["path"].size == 6
    again = io.trajectory_of(store)
    assert again.positions == pytest.approx(given.positions, abs=1e-14)
    assert same_rotation(again.quaternions, given.quaternions, 1e-14)
    if format != "kitti":
        assert again.times == pytest.approx(given.times, abs=1e-6)
    io.write(store, tmp_path / f"out.{format}")
    twice = io.read_trajectory(tmp_path / f"out.{format}")
    assert twice.positions == pytest.approx(given.positions, abs=1e-14)


def test_whole_nanoseconds_are_exact(tmp_path: Path) -> None:
    given = some()
    io.write_trajectory(given, tmp_path / "in.euroc")
    store = store_of(model_of(SHAPES["rotation"]))
    io.read(store, tmp_path / "in.euroc")
    assert store.tables["path"].column("time_ns").tolist() == given.stamps.tolist()  # type: ignore[union-attr]
    io.write(store, tmp_path / "out.euroc")
    assert io.read_trajectory(tmp_path / "out.euroc").stamps.tolist() == given.stamps.tolist()  # type: ignore[union-attr]


def test_planar_poses(tmp_path: Path) -> None:
    path = tmp_path / "in.tum"
    half = np.array([0.0, 0.3, -0.5])
    path.write_text(
        "".join(f"{k} {k} -{k} 0 0 0 {np.sin(a)} {np.cos(a)}\n" for k, a in enumerate(half))
    )
    store = store_of("")  # pose_graph_2d
    with pytest.warns(DataWarning, match="W0701.*no field for times"):
        io.read(store, path)
    poses = store.tables["poses"]
    assert poses.column("t").tolist() == [[0, 0], [1, -1], [2, -2]]
    assert poses.column("th") == pytest.approx(2 * half, abs=1e-15)
    with pytest.warns(DataWarning, match="row numbers are written as seconds"):
        io.write(store, tmp_path / "out.tum")
    again = io.read_trajectory(tmp_path / "out.tum")
    assert again.quaternions[:, 3] == pytest.approx(np.sin(half), abs=1e-15)


def test_spatial_poses_do_not_fit_planar_ones(tmp_path: Path) -> None:
    io.write_trajectory(some(), tmp_path / "in.tum")
    with pytest.raises(AraelError, match=r"E0724.*pose 0 has a height, roll or pitch"):
        io.read(store_of(""), tmp_path / "in.tum")


def test_rows_that_exist_keep_their_other_fields(tmp_path: Path) -> None:
    store = store_of(POSES)
    poses = store.tables["poses"]
    poses.extend(2, t=np.zeros((2, 3)), q=[[1, 0, 0, 0]] * 2, note=[1, 2])
    poses.fixed("t")[0] = True
    io.write_trajectory(some(2), tmp_path / "in.tum")
    io.read(store, tmp_path / "in.tum")
    assert poses.column("t").tolist() == some(2).positions.tolist()
    assert poses.column("note").tolist() == [1, 2] and poses.fixed("t").tolist() == [True, False]
    io.write_trajectory(some(3), tmp_path / "in.tum")
    with pytest.raises(AraelError, match=r"E0704.*3 poses, `poses` has 2 rows"):
        io.read(store, tmp_path / "in.tum")
    assert poses.column("t").tolist() == some(2).positions.tolist()


TWO = model_of("param start: vec3; param end: vec3; param q: quaternion; skip time: real = 0")


def test_two_positions_need_a_choice(tmp_path: Path) -> None:
    io.write_trajectory(some(), tmp_path / "in.tum")
    with pytest.raises(AraelError, match=r"E0724.*ambiguous: `start`, `end`") as failure:
        io.read(store_of(TWO), tmp_path / "in.tum")
    assert "--fields position=start" in str(failure.value)
    store = store_of(TWO.replace("end: vec3", "end: vec3 = [1, 2, 3]"))
    io.read(store, tmp_path / "in.tum", fields={"position": "start"})
    assert store.tables["path"].column("start").tolist() == some().positions.tolist()
    assert io.trajectory_of(store, fields={"position": "end"}).positions[0].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"positon": "start"}, "a pose has no part `positon`"),
        ({"position": "begin"}, "no field `begin`"),
        ({"position": "q"}, "`q` cannot hold the position"),
    ],
)
def test_wrong_fields_are_named(tmp_path: Path, fields: dict[str, str], words: str) -> None:
    io.write_trajectory(some(), tmp_path / "in.tum")
    with pytest.raises(AraelError, match="E0724") as failure:
        io.read(store_of(TWO), tmp_path / "in.tum", fields=fields)
    assert words in str(failure.value)


def test_collections_of_poses_are_chosen_by_name(tmp_path: Path) -> None:
    text = """
struct Pose { param t: vec3; param q: quaternion; skip time: real = 0 }
root Two { param a: real = 0; first: list of Pose; second: list of Pose }
"""
    io.write_trajectory(some(), tmp_path / "in.tum")
    store = store_of(text)
    with pytest.raises(AraelError, match="several collections hold poses: `first`, `second`"):
        io.read(store, tmp_path / "in.tum")
    io.read(store, tmp_path / "in.tum", collection="second")
    assert (store.tables["first"].size, store.tables["second"].size) == (0, 6)
    (tmp_path / "first.tum").write_bytes((tmp_path / "in.tum").read_bytes())
    io.read(store, tmp_path / "first.tum")
    assert store.tables["first"].size == 6
    with pytest.raises(AraelError, match="no collection holds poses"):
        store_without_poses = store_of("root R { param a: real = 0 }")
        io.read(store_without_poses, tmp_path / "in.tum")


@pytest.mark.parametrize("options", [{"fields": {"position": "t"}}, {"collection": "poses"}])
def test_options_of_other_formats_are_refused(tmp_path: Path, options: dict[str, Any]) -> None:
    (tmp_path / "in.g2o").write_text("VERTEX_SE2 0 0 0 0\n")
    with pytest.raises(AraelError, match="E0713"):
        io.read(store_of(""), tmp_path / "in.g2o", **options)


# --- wrong values --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda: Trajectory(np.zeros((2, 3)), np.zeros((2, 4))), "E0721"),
        (lambda: Trajectory(np.zeros((2, 3)), [[1, 0, 0, 0]]), "E0704"),
        (lambda: Trajectory([[0, 0, np.nan]], [[1, 0, 0, 0]]), "E0705"),
        (lambda: Trajectory([["a", 0, 0]], [[1, 0, 0, 0]]), "E0703"),  # type: ignore[list-item]
        (lambda: Trajectory([[0, 0, 0]], [[1, 0, 0, 0]], stamps=np.array([0.5])), "E0704"),  # type: ignore[arg-type]
        (lambda: Trajectory.from_matrices(np.zeros((2, 2, 4))), "E0704"),
        (lambda: Trajectory.from_matrices([np.diag([1, 1, -1, 1])]), "E0721"),
    ],
)
def test_wrong_values_are_refused(make: Callable[[], Trajectory], code: str) -> None:
    with pytest.raises(AraelError, match=code):
        make()


def test_matrices_and_rows() -> None:
    given = some(full=True)
    again = Trajectory.from_matrices(given.matrices, given.times)
    assert same_rotation(again.quaternions, given.quaternions)
    matrices = rotations.matrix_from_quaternion(given.quaternions)
    assert given.matrices[:, :3, :3].tolist() == matrices.tolist()
    part = given.rows([4, 1])
    assert len(part) == 2 and part.positions.tolist() == given.positions[[4, 1]].tolist()
    assert part.stamps is not None and given.stamps is not None
    assert part.stamps.tolist() == given.stamps[[4, 1]].tolist()


@pytest.mark.parametrize("format", TRAJECTORIES)
def test_any_cut_of_a_file_is_read_or_refused(tmp_path: Path, format: str) -> None:
    io.write_trajectory(some(2, full=True), tmp_path / f"whole.{format}")
    content = (tmp_path / f"whole.{format}").read_bytes()
    path = tmp_path / f"cut.{format}"
    for end in range(0, len(content), 7):
        path.write_bytes(content[:end])
        try:
            io.read_trajectory(path)
        except AraelError as failure:
            assert failure.diagnostics[0].code in ("E0712", "E0716", "E0721")


@pytest.mark.parametrize("format", TRAJECTORIES)
def test_changed_characters_are_read_or_refused(tmp_path: Path, format: str) -> None:
    io.write_trajectory(some(2, full=True), tmp_path / f"whole.{format}")
    content = (tmp_path / f"whole.{format}").read_bytes()
    rng = np.random.default_rng(0)
    path = tmp_path / f"changed.{format}"
    for place in rng.integers(0, len(content), 200).tolist():
        changed = bytearray(content)
        changed[place] = b"\0\n #,.-e_9\xff"[int(rng.integers(11))]
        path.write_bytes(changed)
        try:
            io.read_trajectory(path)
        except AraelError as failure:
            places = {d.code for d in failure.diagnostics}
            assert places <= {"E0705", "E0716", "E0721"}


def test_a_file_over_the_limit_is_refused(tmp_path: Path) -> None:
    io.write_trajectory(some(50), tmp_path / "in.tum")
    with pytest.raises(AraelError, match="E0714"):
        io.read_trajectory(tmp_path / "in.tum", limit=1000)


def test_times_beyond_nanoseconds_of_64_bits_are_refused(tmp_path: Path) -> None:
    """Nanoseconds in a TUM file, whose times are seconds."""
    (tmp_path / "a.tum").write_text("1403636579763555584 0 0 0 0 0 0 1\n")
    (tmp_path / "b.tum").write_text("9999999999.5 0 0 0 0 0 0 1\n")
    for name in "ab":
        found = io.read_trajectory(tmp_path / f"{name}.tum")
        assert found.stamps is None and found.times is not None and found.times[0] > 9.9e9
        with pytest.raises(AraelError, match=r"E0706.*is too large: are these nanoseconds"):
            found.exact_stamps()
