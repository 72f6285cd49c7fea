"""Names of what many problems give: of numbers, and of files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

import arael
from arael.distributed.many import tasks_of
from arael.distributed.work import Settings, stored_names
from tests.optional import needs

MODEL = """
struct Pose {
    param q: quaternion
    param pos: vec2
    constraint level { [q.rotate([0, 0, 1]).x, q.rotate([0, 0, 1]).y, 0.1 * q.z, pos.x - 3, pos.y] }
}
root Turned {
    param a: real
    poses: list of Pose
    constraint near { a - 5 }
}
"""


def test_numbers_are_named_by_what_is_stored() -> None:
    model = arael.loads(MODEL, interpret=True)(a=0)
    model.poses.append(q=[1, 0, 0, 0], pos=[0, 0])
    model.poses.append(q=[1, 0, 0, 0], pos=[0, 0])
    model.poses[0].pos.fixed = True
    model.solve()
    found = dict(zip(stored_names(model._problem()), model.serialize(), strict=True))
    assert found["a"] == np.float64(model.a)
    assert found["poses[1].pos.x"] == model.poses[1].pos[0]
    for row in (0, 1):
        stored = [found[f"poses[{row}].q[{k}]"] for k in range(4)]
        column = np.asarray(model._store.tables["poses"].column("q"))
        np.testing.assert_array_equal(stored, column[row])


@needs("Dask")
def test_files_that_would_be_written_twice_get_names_of_their_own(tmp_path: Path) -> None:
    from arael.distributed.compiled import Shipped

    paths = [tmp_path / name for name in ("a/b.npz", "a__b.npz", "x.csv", "x.csv.npz")]
    for path in paths:
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps({}))
    shipped = Shipped("0" * 64, "model", {})
    tasks = tasks_of(paths, shipped, Settings(), tmp_path / "out")
    results = [task.result for task in tasks]
    assert len(set(results)) == len({task.row for task in tasks}) == 4
    assert results[0] == str(tmp_path / "out" / "a__b.npz")
    assert results[1] == str(tmp_path / "out" / "a__b~2.npz")
