"""Rotations, directions and transforms in data files: every form, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from arael import io
from arael.runtime.store import Store
from tests.io.cases import found, layout_of

MODEL = """
struct Pose {
    param T: transform
    param S: similarity
    param d: direction
    z: transform
    q: quat
    maybe: similarity?
    constraint c { [(T.inverse() * z).log(), S * d, rotation_matrix(q) * d] }
}
root Graph { poses: list of Pose }
"""
HALF = [0.5, 0.5, 0.5, 0.5]
CYCLE = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]  # what HALF turns by


def row(**changed: object) -> dict[str, object]:
    whole = {"T": [1, 2, 3, *HALF], "S": [1, 2, 3, *HALF, 2], "d": [0, 0.6, 0.8],
             "z": [0, 0, 0, 1, 0, 0, 0], "q": HALF}  # fmt: skip
    return {**whole, **changed}


def read(tmp_path: Path, *rows: dict[str, object]) -> Store:
    path = tmp_path / "data.json"
    path.write_text(json.dumps({"poses": rows}))
    store = Store(layout_of(MODEL))
    io.read(store, path)
    return store


def homogeneous(scale: float) -> list[list[float]]:
    top = [[*(scale * c for c in r), t] for r, t in zip(CYCLE, [1, 2, 3], strict=True)]
    return [*top, [0, 0, 0, 1]]


def test_all_forms_of_transforms(tmp_path: Path) -> None:
    euler = [np.pi / 2, 0, np.pi / 2]
    for form in (homogeneous(1), homogeneous(1)[:3], [1, 2, 3, *euler]):
        for name in ("T", "z"):
            column = read(tmp_path, row(), row(**{name: form})).tables["poses"].column(name)
            np.testing.assert_allclose(column[1], [1, 2, 3, *HALF], atol=1e-15)
    for similar in (homogeneous(2), homogeneous(2)[:3]):
        column = read(tmp_path, row(S=similar)).tables["poses"].column("S")
        np.testing.assert_allclose(column[0], [1, 2, 3, *HALF, 2], atol=1e-15)


@pytest.mark.parametrize("kind", ["json", "npz"])
def test_what_is_written_is_read_again(tmp_path: Path, kind: str) -> None:
    store = read(tmp_path, row(), row(maybe=[0, 0, 1, *HALF, 3], T={"value": homogeneous(1),
                                                                     "fixed": True}))  # fmt: skip
    io.write(store, tmp_path / f"out.{kind}")
    again = Store(layout_of(MODEL))
    io.read(again, tmp_path / f"out.{kind}")
    for name in ("T", "S", "d", "z", "q", "maybe", "maybe?"):
        one, other = (s.tables["poses"].column(name).tolist() for s in (store, again))
        assert one == other, name
    assert again.tables["poses"].fixed("T").tolist() == [False, True]
    assert again.tables["poses"].column("maybe?").tolist() == [False, True]


def test_columns_of_a_table_are_named(tmp_path: Path) -> None:
    model = (
        "struct P { param T: transform\n    constraint c { T.translation }\n}\n"
        "root G { ps: list of P }\n"
    )
    store = Store(layout_of(model))
    store.tables["ps"].extend(1, None, T=[[1, 2, 3, 1, 0, 0, 0]])
    io.write(store, tmp_path / "ps.csv")
    names = (tmp_path / "ps.csv").read_text().splitlines()[0]
    assert names.startswith("T.translation.x,T.translation.y,T.translation.z,T.rotation.w")
    again = Store(layout_of(model))
    io.read(again, tmp_path / "ps.csv")
    assert again.tables["ps"].column("T").tolist() == [[1, 2, 3, 1, 0, 0, 0]]


@pytest.mark.parametrize(
    ("changed", "code", "message"),
    [
        ({"T": [1, 2, 3, 1, 1, 0, 0]}, "E0721", "unit quaternion: its norm is 1.41421"),
        ({"z": [1, 2, 3, 1, 1, 0, 0]}, "E0721", "unit quaternion: its norm is 1.41421"),
        ({"S": [1, 2, 3, *HALF, -2]}, "E0721", "expected a positive scale"),
        ({"S": [1, 2, 3, *HALF]}, "E0704", "expected 8 numbers, found 7"),
        ({"d": [0, 0, 0]}, "E0721", "unit vector: its norm is 0"),
        ({"T": homogeneous(2)}, "E0721", "expected a rotation matrix on the left"),
        ({"T": [*homogeneous(1)[:3], [0, 0, 1, 1]]}, "E0721", "expected a last row of 0 0 0 1"),
        ({"S": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}, "E0721", "rotation matrix times"),
        ({"maybe": [1, 2]}, "E0704", "expected 8 numbers, found 2"),
    ],
)
def test_what_is_no_transform_is_refused(
    tmp_path: Path, changed: dict[str, object], code: str, message: str
) -> None:
    (problem,) = found(MODEL, json.dumps({"poses": [row(), row(**changed)]}), "json", tmp_path)
    assert problem.code == code and message in problem.message
    assert f"poses[1].{next(iter(changed))}" in problem.origin
