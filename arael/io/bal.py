"""Bundle adjustment problems in the format of the BAL data sets.

The text is numbers with white space between: ``cameras points observations``, then for each
observation ``camera point x y``, then nine numbers per camera (rotation vector world to camera,
translation, focal length, two radial distortions) and three per point. See S. Agarwal, N. Snavely,
S. Seitz, R. Szeliski: Bundle Adjustment in the Large, ECCV 2010.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.io.json_writer import refuse_not_finite
from arael.io.report import Report
from arael.runtime.store import Store, rotations
from arael.runtime.store.messages import error, shorten

Array = NDArray[Any]

HEAD = re.compile(rb"\s*\d+\s+\d+\s+\d+\s*\n\s*\d+\s+\d+\s+[-+.\d]")
"""Matches the start of such a file."""
WORD = re.compile(r"\S+", re.ASCII)  # the white space of bytes.split
CAMERA = ("r", "t", "f", "k1", "k2")
SHAPES: dict[str, dict[str, tuple[int, ...]]] = {
    "cameras": {"r": (4,), "t": (3,), "f": (), "k1": (), "k2": ()},
    "points": {"pos": (3,)},
    "observations": {"camera": (), "point": (), "pixel": (2,)},
}


def read(store: Store, content: bytes, name: str) -> None:
    """Replace the data of a bundle adjustment model by that of a BAL file.

    Raises
    ------
    AraelError
        With file and line: E0716 not a number, or too few or too many numbers; E0705 not finite;
        E0708 a camera or point out of range; E0722 a model of another structure.
    """
    check_shape(store, name)
    report = Report(name)
    fresh = store.fresh()
    report.run(lambda: _fill(fresh, _Text(name, content, report)))
    store.adopt(fresh)


class _Text:
    """The numbers of a file with their places."""

    def __init__(self, name: str, content: bytes, report: Report) -> None:
        self.name, self.content, self.report = name, content, report
        self.words = content.split()
        self.underscores = b"_" in content  # Python would read 1_5 as 15

    def numbers(self, first: int, count: int) -> Array:
        """Words ``first : first + count`` as finite numbers."""
        words = self.words[first : first + count]
        try:
            if self.underscores and any(b"_" in word for word in words):
                raise ValueError
            found = np.array(words, dtype="S32" if words else "S1").astype(np.float64)
        except ValueError:
            bad = next(k for k, w in enumerate(words) if not _is_number(w))
            self.fail("E0716", f"expected a number, found `{self.word(first + bad)}`", first + bad)
        if len(max(words, key=len, default=b"")) > 32:
            found = np.array([float(w) for w in words])
        if not np.isfinite(found).all():
            bad = first + int(np.flatnonzero(~np.isfinite(found))[0])
            self.fail("E0705", f"expected a finite number, found `{self.word(bad)}`", bad)
        return found

    def integers(self, first: int, count: int, step: int, limit: int, what: str) -> Array:
        """Words ``first, first + step, ...`` as indices below `limit`."""
        words = self.words[first : first + count * step : step]
        for k, word in enumerate(words):
            if not word.isdigit() or len(word) > 18:
                at = first + k * step
                self.fail("E0716", f"expected a whole number, found `{self.word(at)}`", at)
        found = np.array([int(w) for w in words], dtype=np.int64)
        beyond = np.flatnonzero(found >= limit)
        if len(beyond):
            at = first + int(beyond[0]) * step
            known = f"there are {limit} {what}s, counted from 0"
            self.fail("E0708", f"{what} {self.word(at)} is not in the file: {known}", at)
        return found

    def word(self, number: int) -> str:
        """The `number`-th word, shortened."""
        return shorten(self.words[number].decode("utf-8", "replace"))

    def fail(self, code: str, message: str, number: int) -> None:
        """Raise an error at the `number`-th word."""
        text = self.content.decode("utf-8", "replace")
        source = Source(self.name, text)
        for k, match in enumerate(WORD.finditer(text)):
            if k == number:
                raise AraelError(Diagnostic(code, message, Span(source, *match.span())))
        raise error(code, message, self.name)


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return b"_" not in word


def _fill(store: Store, text: _Text) -> None:
    head = text.words[:3]
    if len(head) < 3 or not all(w.isdigit() and len(w) < 10 for w in head):
        raise error(
            "E0716",
            "the file does not begin with the numbers of cameras, points and observations",
            text.name,
        )
    cameras, points, observations = (int(w) for w in head)
    expected = 3 + 4 * observations + 9 * cameras + 3 * points
    if len(text.words) != expected:
        raise error(
            "E0716",
            f"{cameras} cameras, {points} points and {observations} observations take {expected} "
            f"numbers, found {len(text.words)}",
            text.name,
            help="the file is truncated, or its first line is wrong",
        )
    camera = text.integers(3, observations, 4, cameras, "camera")
    point = text.integers(4, observations, 4, points, "point")
    pixels = text.numbers(3, 4 * observations).reshape(-1, 4)[:, 2:]
    start = 3 + 4 * observations
    poses = text.numbers(start, 9 * cameras).reshape(-1, 9)
    places = text.numbers(start + 9 * cameras, 3 * points).reshape(-1, 3)
    store.tables["cameras"].extend(
        cameras,
        r=rotations.quaternion_from_vector(poses[:, :3]),
        t=poses[:, 3:6],
        f=poses[:, 6],
        k1=poses[:, 7],
        k2=poses[:, 8],
    )
    store.tables["points"].extend(points, pos=places)
    store.tables["observations"].extend(observations, camera=camera, point=point, pixel=pixels)


def dump(store: Store, name: str) -> bytes:
    """Return the model's data as BAL text; reading it gives the same cost.

    Raises
    ------
    AraelError
        E0722 a model of another structure, E0705 not finite, E0709 a stale ref.
    """
    check_shape(store, name)
    cameras, points, seen = (store.tables[t] for t in SHAPES)
    for table in (cameras, points, seen):
        for leaf in table.fields.leaves():
            if leaf.column.kind == "real" and leaf.column.role != "ref":
                refuse_not_finite(table, leaf, table.column(leaf.path), table.present(leaf.path))
    lines = [f"{cameras.size} {points.size} {seen.size}"]
    ends = (seen.target_rows("camera").tolist(), seen.target_rows("point").tolist())
    pixels = seen.column("pixel").tolist()
    lines += [f"{c} {p} {x!r} {y!r}" for c, p, (x, y) in zip(*ends, pixels, strict=True)]
    vectors = rotations.vector_from_quaternion(cameras.column("r").astype(np.float64))
    rest = [cameras.column(c).reshape(cameras.size, -1) for c in CAMERA[1:]]
    lines += map(repr, np.hstack([vectors, *rest]).ravel().tolist())
    lines += map(repr, points.column("pos").ravel().tolist())
    return ("\n".join(lines) + "\n").encode()


def check_shape(store: Store, name: str) -> None:
    """Raise E0722 unless the model has the structure of a bundle adjustment."""
    for path, columns in SHAPES.items():
        table = store.tables.get(path)
        fits = table is not None and all(
            c in table.data and table.data[c].shape == shape for c, shape in columns.items()
        )
        if not fits:
            raise error(
                "E0722",
                f"`{store.layout.root}` of {store.layout.source} is not a bundle adjustment",
                name,
                help="such files fill models with the fields of `bundle_adjustment`",
            )
