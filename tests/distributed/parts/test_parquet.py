"""A folder of Parquet files is the data set that NPZ files are, bit by bit."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.distributed import solve
from arael.distributed.parts import parquet
from arael.distributed.parts.data import columns_of, rows_of_share
from arael.distributed.parts.parquet import Piece
from arael.distributed.parts.solve import prepare
from arael.io import arrow
from tests.optional import needs, require

from .problems import PROBLEMS, arrays_of

pytestmark = needs("pyarrow")


def arrow_and_parquet() -> tuple[Any, Any]:
    """The package and its module of Parquet files."""
    return require("pyarrow"), import_module("pyarrow.parquet")


def as_parquet(model: Any, folder: Path, files: int, row_group: int = 16) -> Path:
    """Write a model as a folder of Parquet files, a few per collection."""
    pa, pq = arrow_and_parquet()
    folder.mkdir()
    arrays = arrays_of(model)
    for path, table in model._store.tables.items():
        name = path or "root"
        if table.layout.parent:
            owners = np.repeat(np.arange(table.parent.size), np.diff(arrays[f"{path}.offsets"]))
            columns = {"parent": owners}
            prefix = f"{path}."
            plain = {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}
            rows = pa.table(columns | {k: v for k, v in plain.items() if k != "offsets"})
        elif path:
            content = arrow.dump(model._store, "x.parquet", "parquet", path)
            rows = pq.read_table(pa.BufferReader(content))
        else:
            rows = pa.table({k: [v[()]] for k, v in arrays.items() if k in table.data})
            if not rows.num_columns:
                continue
        if not path:
            pq.write_table(rows, folder / "root.parquet")
            continue
        (folder / name).mkdir()
        for k in range(files):
            begin, end = rows.num_rows * k // files, rows.num_rows * (k + 1) // files
            pq.write_table(
                rows.slice(begin, end - begin),
                folder / name / f"part-{k}.parquet",
                row_group_size=row_group,
            )
    return folder


@pytest.mark.parametrize("name", PROBLEMS)
def test_parts_of_parquet_files_have_the_rows_of_an_archive(name: str, tmp_path: Path) -> None:
    model: Any = PROBLEMS[name]()
    model.write(tmp_path / "data.npz")
    folder = as_parquet(model, tmp_path / "data", 3)
    layout = model._compiled.layout
    one = prepare(model._compiled, tmp_path / "data.npz", 3, None)
    other = prepare(model._compiled, folder, 3, None)
    for mine, theirs in zip(one.shares, other.shares, strict=True):
        expected = rows_of_share(layout, columns_of(tmp_path / "data.npz", layout), mine)
        found = rows_of_share(layout, columns_of(folder, layout), theirs)
        assert found.keys() == expected.keys()
        for key, array in expected.items():
            np.testing.assert_array_equal(found[key].reshape(array.shape), array, key)


@pytest.mark.parametrize("name", ["bundle", "chain", "fleet"])
def test_a_folder_of_parquet_files_is_solved_bit_by_bit_as_an_archive(
    name: str, tmp_path: Path
) -> None:
    model: Any = PROBLEMS[name]()
    model.write(tmp_path / "data.npz")
    folder = as_parquet(model, tmp_path / "data", 2)
    expected = solve(type(model), tmp_path / "data.npz", partition=3, workers=0)
    found = solve(type(model), folder, partition=3, workers=0)
    assert found.result.history["cost"].tolist() == expected.result.history["cost"].tolist()
    np.testing.assert_array_equal(found.result.x, expected.result.x)


def test_a_part_reads_only_the_row_groups_of_its_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model: Any = PROBLEMS["loop"](200)
    folder = as_parquet(model, tmp_path / "data", 2, row_group=10)
    prepared = prepare(model._compiled, folder, 4, None)
    columns = columns_of(folder, model._compiled.layout)
    read = 0
    plain = Piece._plain

    def counted(self: Piece, title: str, cells: Any) -> Any:
        nonlocal read
        read += len(cells) * (title == "t.x")
        return plain(self, title, cells)

    monkeypatch.setattr(Piece, "_plain", counted)
    share = prepared.shares[0]
    rows = rows_of_share(model._compiled.layout, columns, share)
    wanted = len(rows["edges.t"]) + len(rows["poses.t"])
    assert wanted <= read < wanted + 200
    assert read < (200 + len(arrays_of(model)["edges.t"])) / 2


SOME = """
struct Gps { at: vec2; sigma: real = 1 }
struct Pose {
    param pos: vec2
    gps: Gps?
    speed: real?
    label: string = ""
    constraint near { pos - [1, 2] }
    constraint measured when gps { (pos - gps.at) / gps.sigma }
    constraint fast when speed { pos.x - speed }
}
struct Joined {
    a: ref Pose in root.poses; b: ref Pose in root.poses
    constraint c { b.pos - a.pos }
}
root R { poses: list of Pose; joined: list of Joined }
"""


def test_optional_structs_and_flags_of_components_are_read(tmp_path: Path) -> None:
    model: Any = arael.loads(SOME, interpret=True)()
    for k in range(6):
        model.poses.append(pos=[k, 0], label=f"p{k}")
    model.poses[1].gps = {"at": [3, 4], "sigma": 2.0}
    model.poses[4].speed = 7.0
    model.poses[2].pos.x.fixed = True
    model.joined.extend(a=np.arange(5), b=np.arange(1, 6))
    model.write(tmp_path / "data.npz")
    folder = as_parquet(model, tmp_path / "data", 2)
    layout = model._compiled.layout
    prepared = prepare(model._compiled, folder, 1, None)
    found = rows_of_share(layout, columns_of(folder, layout), prepared.shares[0])
    assert found["poses.gps"].tolist() == [False, True, False, False, False, False]
    assert found["poses.speed.present"].tolist() == [False] * 4 + [True, False]
    assert found["poses.pos.fixed"].tolist() == [[k == 2, False] for k in range(6)]
    solved = solve(type(model), folder, partition=2, workers=0)
    expected = solve(type(model), tmp_path / "data.npz", partition=2, workers=0)
    np.testing.assert_array_equal(solved.result.x, expected.result.x)


# --- messages ----------------------------------------------------------------------------------


def refused(code: str, folder: Path, name: str = "loop") -> str:
    with pytest.raises(AraelError) as caught:
        solve(type(PROBLEMS[name]()), folder, partition=2, workers=0)
    assert caught.value.diagnostics[0].code == code
    return str(caught.value)


def changed(folder: Path, file: str, change: Any) -> None:
    """Write a file of a folder again with other columns."""
    pa, pq = arrow_and_parquet()
    rows = pq.read_table(folder / file).to_pydict()
    pq.write_table(pa.table(change(rows)), folder / file)


def test_files_of_no_collection_are_refused(tmp_path: Path) -> None:
    (tmp_path / "pose").mkdir()
    (tmp_path / "pose" / "a.parquet").write_bytes(b"PAR1")
    assert "did you mean `poses`?" in refused("E0713", tmp_path)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "poses.parquet").write_bytes(b"PAR1 and nothing")
    assert "poses.parquet" in refused("E0711", tmp_path)


def test_a_missing_scalar_is_named(tmp_path: Path) -> None:
    folder = as_parquet(PROBLEMS["loop"](), tmp_path / "data", 1)
    changed(folder, "edges/part-0.parquet", lambda c: {k: v for k, v in c.items() if k != "t.y"})
    assert "`t.y` is missing" in refused("E0702", folder)


def test_an_unknown_column_is_named(tmp_path: Path) -> None:
    folder = as_parquet(PROBLEMS["loop"](), tmp_path / "data", 1)
    changed(folder, "edges/part-0.parquet", lambda c: c | {"extra": c["a"]})
    assert "edges.extra" in refused("E0701", folder)


def test_a_missing_value_is_named_with_its_row(tmp_path: Path) -> None:
    folder = as_parquet(PROBLEMS["loop"](), tmp_path / "data", 1)
    changed(folder, "edges/part-0.parquet", lambda c: c | {"th": [None, *c["th"][1:]]})
    assert "`th` has no value in row 0" in refused("E0702", folder)


@pytest.mark.parametrize("change", [lambda c: c | {"parent": c["parent"][::-1]}, dict.copy])
def test_owners_of_nested_rows_must_be_sorted(tmp_path: Path, change: Any) -> None:
    folder = as_parquet(PROBLEMS["bundle"](), tmp_path / "data", 2)
    if change is dict.copy:  # sorted in each file, but not over both
        names = [folder / "points.seen" / f"part-{k}.parquet" for k in (0, 1)]
        names[0].rename(folder / "points.seen" / "part-2.parquet")
    else:
        changed(folder, "points.seen/part-0.parquet", change)
    assert "sorted" in refused("E0704", folder, "bundle")


def test_owners_of_nested_rows_must_be_given(tmp_path: Path) -> None:
    folder = as_parquet(PROBLEMS["bundle"](), tmp_path / "data", 1)
    changed(folder, "points.seen/part-0.parquet", lambda c: {k: c[k] for k in c if k != "parent"})
    assert "need their owners as `parent`" in refused("E0702", folder, "bundle")


def test_without_pyarrow_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = as_parquet(PROBLEMS["loop"](), tmp_path / "data", 1)

    def absent(module: str, name: str, format: str) -> Any:
        from arael.io import packages

        monkeypatch.setattr(packages, "import_module", _raise_import_error)
        return packages.required(module, name, format)

    monkeypatch.setattr(parquet, "required", absent)
    assert "arael[arrow]" in refused("E0725", folder)


def _raise_import_error(name: str) -> Any:
    raise ImportError(name)
