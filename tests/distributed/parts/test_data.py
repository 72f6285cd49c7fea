"""Data sets in one file or several: parts read their rows, the client reads refs and parameters."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.distributed import solve
from arael.distributed.parts.data import Archive, columns_of, rows_of_share
from arael.distributed.parts.solve import prepare

from .problems import PROBLEMS, arrays_of, with_arrays


def cut(arrays: dict[str, Any], folder: Path, pieces: int) -> None:
    """Write a bundle as several files, each with some cameras and some points."""
    folder.mkdir()
    cameras, points = len(arrays["cameras.c"]), len(arrays["points.x"])
    offsets = arrays["points.seen.offsets"]
    for k in range(pieces):
        c = slice(cameras * k // pieces, cameras * (k + 1) // pieces)
        p = slice(points * k // pieces, points * (k + 1) // pieces)
        seen = slice(offsets[p.start], offsets[p.stop])
        found = {"points.seen.offsets": offsets[p.start : p.stop + 1] - offsets[p.start]}
        for name, array in arrays.items():
            if name.startswith("cameras."):
                found[name] = array[c]
            elif name.startswith("points.seen.") and name != "points.seen.offsets":
                found[name] = array[seen]
            elif name == "points.x":
                found[name] = array[p]
        if k == 0:
            found["focal"] = arrays["focal"]
        np.savez(folder / f"part-{k}.npz", **found)


def test_a_folder_of_files_is_solved_like_one(tmp_path: Path) -> None:
    model = PROBLEMS["bundle"]()
    arrays = arrays_of(model)
    cut(arrays, tmp_path / "data", 3)
    found = solve(type(model), tmp_path / "data", partition=3, workers=0)
    alone = with_arrays(model, arrays)
    result = alone.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)
    np.testing.assert_allclose(found.parameters()["points.x"], alone.points.x.value, atol=1e-7)
    found.write(tmp_path / "solved.npz")
    with np.load(tmp_path / "solved.npz") as file:
        assert sorted(file) == ["cameras.c", "cameras.th", "focal", "points.x"]


def test_the_client_reads_no_measurements(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = PROBLEMS["bundle"]()
    cut(arrays_of(model), tmp_path / "data", 2)
    asked = set()
    read = Archive.__getitem__

    def noted(self: Archive, name: str) -> Any:
        asked.add(name)
        return read(self, name)

    monkeypatch.setattr(Archive, "__getitem__", noted)
    prepared = prepare(model._compiled, tmp_path / "data", 2, None)
    assert "points.seen.camera" in asked
    assert "points.seen.u" not in asked
    assert prepared.split.parts == 2


def test_a_part_has_its_rows_only(tmp_path: Path) -> None:
    model = PROBLEMS["bundle"]()
    cut(arrays_of(model), tmp_path / "data", 2)
    prepared = prepare(model._compiled, tmp_path / "data", 4, None)
    columns = columns_of(tmp_path / "data", model._compiled.layout)
    rows = [
        len(rows_of_share(prepared.compiled.layout, columns, share)["points.seen.u"])
        for share in prepared.shares
    ]
    assert sum(rows) == len(arrays_of(model)["points.seen.u"])
    assert max(rows) < sum(rows) / 2


def test_a_file_of_another_format_is_read_whole(tmp_path: Path) -> None:
    model = PROBLEMS["grid"]()
    model.write(tmp_path / "grid.json")
    found = solve(type(model), tmp_path / "grid.json", partition=3, workers=0)
    result = model.solve(solver="sparse")
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)


def test_an_instance_is_solved_in_place() -> None:
    model, other = PROBLEMS["bundle"](), PROBLEMS["bundle"]()
    solve(model, partition=3, workers=0)
    other.solve(solver="sparse")
    np.testing.assert_allclose(model.points.x.value, other.points.x.value, atol=1e-7)
    assert model.cost() == pytest.approx(other.cost(), rel=1e-9)


SCHEDULED = """
struct A { param x: real; y: real; constraint c { x - y } }
struct B { one: ref A in root.a; two: ref A in root.a
    constraint d { root.w * (one.x - two.x + 0.1 * root.s) }
}
struct D { a: ref A in root.a; constraint e { 0.5 * (a.x - a.x.value - 1) } }
root R {
    w: real = 1
    param s: real = 0
    a: list of A
    b: list of B
    d: list of D
    constraint f { s - 2 * w }
    constraint g { 0.1 * (s - 3) }
    solve { pass first { freeze s; w = 3 }; pass second { w = 0.5 } }
}
"""


def test_passes_set_data_freeze_and_begin_where_the_last_ended() -> None:
    kind = arael.loads(SCHEDULED, interpret=True)
    model: Any = kind()
    n = 30
    model.a.extend(x=np.zeros(n), y=np.arange(n) % 7.0)
    model.b.extend(one=np.arange(n - 1), two=np.arange(1, n))
    model.d.extend(a=np.arange(0, n, 5))
    other = with_arrays(model, arrays_of(model))
    found = solve(model, partition=3, workers=0)
    result = other.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)
    np.testing.assert_allclose(model.a.x.value, other.a.x.value, atol=1e-9)


OPTIONAL = """
struct Camera { param f: real }
struct Pose {
    param x: real
    camera: Camera?
    speed: real?
    constraint near { 0.1 * (x - 3) }
    constraint seen when camera { [camera.f * x - 6, camera.f - 1.5] }
    constraint fast when speed { x - speed }
}
struct Step {
    a: ref Pose in root.poses; b: ref Pose in root.poses
    constraint c { b.x - a.x - 0.1 }
}
root R { poses: list of Pose; steps: list of Step }
"""


def test_optional_parameters_and_values_of_a_file_are_those_of_one_machine(tmp_path: Path) -> None:
    model: Any = arael.loads(OPTIONAL, interpret=True)()
    for k in range(8):
        model.poses.append(x=float(k))
    model.poses[2].camera = {"f": 1.0}
    model.poses[5].speed = 2.0
    model.steps.extend(a=np.arange(7), b=np.arange(1, 8))
    model.write(tmp_path / "data.npz")
    found = solve(type(model), tmp_path / "data.npz", partition=2, workers=0)
    result = model.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)
    np.testing.assert_allclose(found.result.x, result.x, rtol=1e-9)


# --- messages ----------------------------------------------------------------------------------


def refused(code: str, *args: Any, **kwargs: Any) -> str:
    with pytest.raises(AraelError) as caught:
        solve(*args, workers=0, **kwargs)
    assert caught.value.diagnostics[0].code == code
    return str(caught.value)


def test_a_folder_without_archives_is_refused(tmp_path: Path) -> None:
    text = refused("E0711", type(PROBLEMS["grid"]()), tmp_path, partition=2)
    assert "neither .npz nor .parquet files" in text


def test_a_sum_over_rows_is_refused() -> None:
    text = """
    struct K { v: real }
    struct L {
        param x: real; ks: list of K
        constraint c { x - sum(k in self.ks) { sin(k.v * x) } }
    }
    root R { ls: list of L }
    """
    model: Any = arael.loads(text, interpret=True)()
    model.ls.append(x=1.0)
    assert "sums over the rows of a list" in refused("E0895", model, partition=2)


def test_a_look_up_is_refused() -> None:
    text = """
    struct K { key t; t: real; v: real }
    struct L { param x: real; constraint c { root.ks.at(x, v) } }
    root R { ls: list of L; ks: list of K }
    """
    model: Any = arael.loads(text, interpret=True)()
    model.ls.append(x=1.0)
    assert "looks rows of a list up" in refused("E0895", model, partition=2)


def test_single_precision_is_refused() -> None:
    model: Any = arael.load("pose_graph_2d", precision="f32", interpret=True)()
    text = refused("E0895", model, partition=2)
    assert "parts are solved in f64" in text and "--precision f64" in text


@pytest.mark.filterwarnings("ignore:.*bound to a Python function")
def test_native_functions_are_refused() -> None:
    text = """
    extern fn twice(x) derivs [2]
    struct L { param x: real; constraint c { twice(x) - 2 } }
    root R { ls: list of L }
    """
    kind = arael.loads(text, functions={"twice": lambda x: 2 * x}, interpret=True)
    model: Any = kind()
    model.ls.append(x=1.0)
    assert "native functions, which workers do not have" in refused("E0895", model, partition=2)


def test_residuals_added_at_run_time_are_refused() -> None:
    model: Any = PROBLEMS["grid"]()
    model.add_residuals(lambda h: h - 1, [model.nodes.h])
    assert "added at run time" in refused("E0895", model, partition=2)


def test_an_unknown_column_is_refused() -> None:
    text = refused("E0896", PROBLEMS["bundle"](), partition_by="day")
    assert "`day`" in text and "cameras" in text


def test_a_wrong_number_of_parts_is_refused() -> None:
    refused("E0828", PROBLEMS["grid"](), partition=0)


def test_a_residual_that_is_not_finite_is_named_as_on_one_machine() -> None:
    model: Any = PROBLEMS["bundle"]()
    model.points[30].x.value = model.cameras[7].c.value
    model.cameras[7].th.value = 0.0
    model.points[30].seen.append(camera=7, u=1.0)
    other = with_arrays(model, arrays_of(model))
    with pytest.raises(AraelError) as alone:
        other.solve()
    with pytest.raises(AraelError) as found:
        solve(model, partition=4, workers=0)
    assert str(found.value) == str(alone.value)
    assert "points[30].seen[" in str(found.value)


def test_an_unread_parameter_is_named() -> None:
    model: Any = PROBLEMS["loop"]()
    model.poses.append(t=[0, 0], th=0.0)
    with pytest.raises(AraelError) as found:
        solve(model, partition=3, workers=0)
    assert found.value.diagnostics[0].code == "E1003"
    assert "poses[60]" in str(found.value)


def test_failures_of_workers_reach_the_caller_whole() -> None:
    # Dask pickles exceptions.
    model: Any = PROBLEMS["loop"]()
    model.poses[3].t.value = [1e200, 0]
    with pytest.raises(AraelError) as found:
        solve(model, partition=3, workers=0)
    again = pickle.loads(pickle.dumps(found.value))
    assert str(again) == str(found.value)
