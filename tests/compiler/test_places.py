"""Entries hold no paths: messages name the file at hand, wherever it was compiled."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args, get_type_hints

import msgspec
import pytest

from arael.compiled_model import CompiledModel
from arael.compiler import ship
from arael.compiler.cache.models import decode, encode
from arael.compiler.compilation import compile_text
from arael.loading import load_compiled, standard_models
from arael.runtime.layout import Layout
from arael.runtime.relocation import attached, detached
from arael.syntax.files import read_source

WARNED = "struct Unheld { x: real }\nroot R { param a: real; b: real; constraint c { a - b } }\n"


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of the test's own."""
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def twice(first: Path, second: Path) -> tuple[Layout, Layout]:
    """The layout of a model as it was compiled, and as it is found from another place."""
    found = load_compiled(first, interpret=True)
    assert found.seconds
    again = load_compiled(second, interpret=True)
    assert again.seconds == {}
    return found.layout, again.layout


def test_messages_name_the_file_at_hand(tmp_path: Path) -> None:
    """The same text elsewhere is the same model, at another place."""
    paths = [tmp_path / f'{name} "é"' / f"{name}.arael" for name in ("one", "two")]
    for path in paths:
        path.parent.mkdir()
        path.write_text(WARNED)
    for path, layout in zip(paths, twice(*paths), strict=True):
        assert layout.source == str(path)
        assert layout.name == path.stem
        assert layout.tables[0].column("b").where == f"{path}:2:25"
        assert layout.groups[0].where.startswith(str(path))
        assert f" --> {path}:1:8" in layout.warnings[0]


@pytest.mark.parametrize("name", ["fit.arael", "data", "a", "0", "m.v2.arael", "x:1:2.arael"])
def test_text_that_looks_like_a_file_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """A default, a collection or a parameter may be called as the file is."""
    text = (
        'struct Point { x: real; name: string = "fit.arael"; at: string = "0:1:2" }\n'
        "root R { param a: real; data: list of Point\n    fit data as e { a - e.x }\n}\n"
    )
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(text)
    (tmp_path / "moved.arael").write_text(text)
    before, after = twice(Path("./" + name), Path("moved.arael"))
    assert [t.path for t in after.tables] == [t.path for t in before.tables] == ["", "data"]
    columns = after.table("data")
    assert columns.column("name").default == "fit.arael"
    assert columns.column("at").default == "0:1:2"
    assert columns.column("x").where == "moved.arael:1:16"
    assert after.tables[0].column("a").path == "a"


def test_imported_files_are_named_from_the_caller(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "point.arael").write_text(
        "struct Point { x: real }\nstruct Un { x: real }\n"
    )
    (tmp_path / "main.arael").write_text(
        'import "parts/point.arael"\nroot R { param a: real; data: list of Point\n'
        "    fit data as e { a - e.x }\n}\n"
    )
    load_compiled(tmp_path / "main.arael", interpret=True)
    monkeypatch.chdir(tmp_path / "parts")
    found = load_compiled("../main.arael", interpret=True)
    assert found.seconds == {}
    assert found.layout.table("data").column("x").where == "../parts/point.arael:1:16"
    assert " --> ../parts/point.arael:2:8" in found.layout.warnings[0]
    assert found.layout.tables[0].where == "../main.arael:2:6"


def test_a_file_imported_under_two_names_is_watched_under_both(tmp_path: Path) -> None:
    (tmp_path / "goal.arael").write_text("const GOAL = 1\n")
    (tmp_path / "link.arael").symlink_to("goal.arael")
    main = tmp_path / "main.arael"
    main.write_text(
        'import "goal.arael"\nimport "link.arael"\n'
        "root R { param a: real; constraint c { a - GOAL } }\n"
    )
    load_compiled(main, interpret=True)
    assert load_compiled(main, interpret=True).seconds == {}
    (tmp_path / "link.arael").unlink()
    (tmp_path / "link.arael").write_text("const OTHER = 1\n")
    assert load_compiled(main, interpret=True).seconds != {}


@pytest.mark.sweep(4, slow=("sketch",))
@pytest.mark.parametrize("name", sorted(standard_models()))
def test_entries_hold_no_path(tmp_path: Path, name: str) -> None:
    path = tmp_path / "folder" / f"{name}_.arael"
    path.parent.mkdir()
    shutil.copyfile(standard_models()[name], path)
    compilation = compile_text(read_source(path))
    data = encode(compilation.known("code"))
    assert str(tmp_path).encode() not in data
    assert path.name.encode() not in data
    assert attached(decode(data).layout, [str(path)], compilation.layout.warnings) == (
        compilation.layout
    )


def test_places_are_all_moved() -> None:
    """Every kind of record that has a place is known to `relocation`."""

    def records(kind: Any, seen: set[type]) -> Iterator[type]:
        for part in get_args(kind):
            yield from records(part, seen)
        if isinstance(kind, type) and issubclass(kind, msgspec.Struct) and kind not in seen:
            seen.add(kind)
            yield kind
            for hint in get_type_hints(kind).values():
                yield from records(hint, seen)

    placed = {k.__name__ for k in records(Layout, set()) if "where" in k.__struct_fields__}
    assert placed == {
        *("Table", "Column", "ByValue", "Group", "Place", "LookUp", "Block", "Function")
    }


def test_detached_and_attached_are_inverse(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_text(WARNED)
    layout = compile_text(read_source(path)).layout
    stored = detached(layout, [str(path)])
    assert stored.tables[0].where == "0:2:6"
    assert attached(stored, [str(path)], layout.warnings) == layout


def test_shipped_models_carry_no_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CFLAGS", "-O0")
    source = tmp_path / "sources" / "small-model.arael"
    source.parent.mkdir()
    source.write_text(WARNED)
    (folder,) = ship.ship([source], tmp_path / "package", ["baseline"])
    files = [p for p in folder.iterdir() if p.is_file()]
    assert {p.suffix for p in files} >= {".json", ".so", ".pyx"}
    for file in files:
        data = file.read_bytes()
        for place in (str(tmp_path), os.getcwd(), str(Path.home())):
            assert os.fsencode(place) not in data, file
    found = shipped(tmp_path / "package", monkeypatch)
    assert found.origin == "shipped"
    assert found.layout.source == str(tmp_path / "package" / source.name)
    assert found.layout.groups[0].where.startswith(found.layout.source)


def shipped(package: Path, monkeypatch: pytest.MonkeyPatch) -> CompiledModel:
    """Load the model in `package` as one that arael brings along."""
    from arael import loading

    package.rename(package.with_name("models"))
    package.symlink_to(package.with_name("models"))
    monkeypatch.setattr(loading, "__file__", str(package.parent / "loading.py"))
    monkeypatch.setattr(loading.processor, "usable_targets", lambda: ["baseline"])
    return load_compiled(package / "small-model.arael")
