"""Trajectories as text: TUM, KITTI, EuRoC.

TUM: ``time x y z qx qy qz qw`` [s, m] (J. Sturm et al., "A Benchmark for the Evaluation of RGB-D
SLAM Systems", 2012). KITTI: the upper three rows of the homogeneous matrix, 12 numbers, without
times (A. Geiger et al., "Are we ready for Autonomous Driving?", 2012). EuRoC: ``time [ns], p, q (w
first)``, then optionally velocity, gyroscope bias and accelerometer bias, separated by commas (M.
Burri et al., "The EuRoC micro aerial vehicle datasets", 2016). Lines that begin with ``#`` are
comments.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.io.lines import Lines
from arael.io.plain_numbers import whole
from arael.io.report import Report
from arael.io.trajectory.record import NANO, UNIT_TOLERANCE, Trajectory
from arael.runtime.store import rotations
from arael.runtime.store.messages import shorten

Array = NDArray[np.float64]

LARGEST = 2**63 - 1
FORMATS = ("tum", "kitti", "euroc")
HEADER = (
    "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], "
    "q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []"
)
MORE = (
    ", v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]",
    ", b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1]"
    ", b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]",
)


def parse(content: bytes, name: str, format: str) -> Trajectory:
    """Read a trajectory.

    Raises
    ------
    AraelError
        With file and line, several at once: E0716 a wrong number of values or not a number, E0705
        not finite, E0721 not a rotation, E0712 no poses.
    """
    report = Report(name)
    found: list[Trajectory] = []
    report.run(lambda: found.append(_PARSERS[format](name, content, report)))
    return found[0]


def _tum(name: str, content: bytes, report: Report) -> Trajectory:
    lines = Lines(name, content, report, "," if _has_commas(content) else None)
    numbers = lines.table([8], "time x y z qx qy qz qw")
    quaternions = numbers[:, [7, 4, 5, 6]]
    _check(lines, numbers, quaternions, (4, 8))
    return Trajectory(numbers[:, 1:4], quaternions, numbers[:, 0], _exact(lines))


def _kitti(name: str, content: bytes, report: Report) -> Trajectory:
    lines = Lines(name, content, report)
    numbers = lines.table([12], "the upper three rows of the matrix of a pose")
    matrices = numbers.reshape(-1, 3, 4)
    for row in np.flatnonzero(~rotations.is_rotation(matrices[:, :, :3])).tolist():
        lines.add("E0721", "the matrix of the pose is not a rotation and a translation", row)
    _stop_if_wrong(lines)
    return Trajectory.from_matrices(matrices)


def _euroc(name: str, content: bytes, report: Report) -> Trajectory:
    lines = Lines(name, content, report, ",")
    numbers = lines.table([8, 11, 17], "time, p, q and optionally velocity and biases")
    quaternions = numbers[:, 4:8]
    stamps = _nanoseconds(lines)
    _check(lines, numbers, quaternions, (4, 8))
    parts = {"velocities": (8, 11), "gyro_biases": (11, 14), "accel_biases": (14, 17)}
    more = {k: numbers[:, a:b] for k, (a, b) in parts.items() if numbers.shape[1] >= b}
    return Trajectory(numbers[:, 1:4], quaternions, stamps / NANO, stamps, **more)


def _nanoseconds(lines: Lines) -> NDArray[np.int64]:
    """The first words of all lines as integers; a wrong one is reported."""
    found = []
    for row, words in enumerate(lines.words):
        try:
            found.append(whole(words[0]))
        except ValueError:
            found.append(LARGEST)
        if abs(found[-1]) >= LARGEST:
            text = f"expected a time in whole nanoseconds, found `{shorten(words[0])}`"
            lines.add("E0716", text, row, 0)
            found[-1] = 0
    return np.array(found, np.int64)


_PARSERS = {"tum": _tum, "kitti": _kitti, "euroc": _euroc}


def _has_commas(content: bytes) -> bool:
    line = next((x for x in content.split(b"\n") if x.strip() and not x.startswith(b"#")), b"")
    return b"," in line


def _check(lines: Lines, numbers: Array, quaternions: Array, words: tuple[int, int]) -> None:
    """Report quaternions that are not unit, then raise what was reported."""
    norms = np.linalg.norm(quaternions, axis=1)
    for row in np.flatnonzero(np.abs(norms - 1) > UNIT_TOLERANCE).tolist():
        text = " ".join(shorten(w) for w in lines.words[row][slice(*words)])
        lines.add(
            "E0721",
            f"expected a unit quaternion, found `{text}` of norm {norms[row]:.3g}",
            row,
            help="is this the order of the columns?",
        )
    _stop_if_wrong(lines)


def _stop_if_wrong(lines: Lines) -> None:
    if not len(lines) and not lines.report.found:
        lines.report.add("E0712", "the file has no poses", "")
    lines.report.halt()


def _exact(lines: Lines) -> NDArray[np.int64] | None:
    """Times of at most nine decimals as whole nanoseconds; None if a time has more, or is huge."""
    found = []
    for words in lines.words:
        seconds, _, decimals = words[0].partition(".")
        digits = seconds.isdigit() and len(seconds) < 10 + 1 and (decimals or "0").isdigit()
        if not digits or len(decimals) > 9:
            return None
        found.append(int(seconds) * NANO + int(decimals.ljust(9, "0")))
        if found[-1] > LARGEST:
            return None
    return np.array(found, np.int64)


def dump(trajectory: Trajectory, format: str) -> bytes:
    """A trajectory as text; reading it gives the same numbers (KITTI: to rounding)."""
    if format == "kitti":
        rows = trajectory.matrices[:, :3].reshape(-1, 12).tolist()
        return _text(" ".join(map(repr, row)) for row in rows)
    positions = trajectory.positions.tolist()
    turns = trajectory.quaternions.tolist()
    if format == "tum":
        poses = zip(_seconds(trajectory), positions, turns, strict=True)
        return _text(
            f"{time} {x!r} {y!r} {z!r} {qx!r} {qy!r} {qz!r} {qw!r}"
            for time, (x, y, z), (qw, qx, qy, qz) in poses
        )
    columns = [trajectory.positions, trajectory.quaternions]
    header = HEADER
    more = [trajectory.velocities, trajectory.gyro_biases, trajectory.accel_biases]
    if any(part is not None for part in more):
        zeros = np.zeros((len(trajectory), 3))
        wide = more[1] is not None or more[2] is not None
        columns += [zeros if p is None else p for p in (more if wide else more[:1])]
        header += MORE[0] + (MORE[1] if wide else "")
    rows = np.hstack(columns).tolist()
    stamps = trajectory.exact_stamps().tolist()
    body = (",".join((str(s), *map(repr, row))) for s, row in zip(stamps, rows, strict=True))
    return (header + "\n").encode() + _text(body)


def _text(lines: Iterable[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()


def _seconds(trajectory: Trajectory) -> list[str]:
    """Times as decimals, exactly."""
    if trajectory.stamps is None and trajectory.times is not None:
        return [repr(time) for time in trajectory.times.tolist()]
    stamps = trajectory.exact_stamps().tolist()
    signs = ("-" if stamp < 0 else "" for stamp in stamps)
    parts = (divmod(abs(stamp), NANO) for stamp in stamps)
    return [f"{sign}{s}.{rest:09d}" for sign, (s, rest) in zip(signs, parts, strict=True)]
