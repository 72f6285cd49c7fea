"""Models of several files: what an import may read, and when a change of a file is noticed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import arael
from arael.compiler import imports
from arael.diagnostics.records import Diagnostic
from arael.loading import load_compiled

ROOT = "root R { param a: real; constraint c { twice(a) - GOAL } }\n"


def write(folder: Path, **texts: str) -> Path:
    """Files by name, ``__`` for a folder; returns the one called `main`."""
    for name, text in texts.items():
        path = folder / (name.replace("__", "/") + ".arael")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder / "main.arael"


def solved(path: Path) -> float:
    model = arael.load(path, interpret=True)(a=0.0)
    model.solve()
    return float(model.a.value)


def said(path: Path) -> list[Diagnostic]:
    with pytest.raises(arael.AraelError) as caught:
        load_compiled(path, interpret=True)
    return list(caught.value.diagnostics)


def test_an_import_is_relative_to_its_own_file(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main='import "parts/all.arael"\n' + ROOT,
        parts__all='import "numbers/goal.arael"\nimport "twice.arael"\n',
        parts__twice="fn twice(x) = 2 * x\n",
        parts__numbers__goal="const GOAL = 3\n",
        twice="fn twice(x) = 1000 * x\n",
    )
    assert solved(main) == pytest.approx(1.5)


def test_a_file_imported_along_two_ways_counts_once(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main='import "left.arael"\nimport "./right.arael"\n' + ROOT,
        left='import "base.arael"\nconst GOAL = UNIT\n',
        right='import "./base.arael"\nfn twice(x) = 2 * x * UNIT\n',
        base="const UNIT = 1\n",
    )
    assert solved(main) == pytest.approx(0.5)


def test_a_circle_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, main='import "a.arael"\n' + ROOT, a='import "main.arael"\nconst GOAL = 1\n')
    monkeypatch.chdir(tmp_path)
    for name in ("main.arael", "./main.arael"):
        (found, *_) = said(Path(name))
        assert found.code == "E0212"
        assert "main.arael -> a.arael -> main.arael" in found.message


@pytest.mark.parametrize(
    "path",
    [
        "../secret.arael",
        "parts/../../secret.arael",
        "/etc/passwd",
        "/etc/model.arael",
        "~/secret.arael",
        "C:/secret.arael",
        "parts\\\\..\\\\secret.arael",
        "notes.txt",
        "",
        "linked.arael",
        "outside/secret.arael",
    ],
)
def test_nothing_outside_is_read(tmp_path: Path, path: str) -> None:
    write(tmp_path, secret="const GOAL = 1\n")
    home = tmp_path / "home"
    main = write(home, main=f'import "{path}"\n' + ROOT)
    (home / "notes.txt").write_text("const GOAL = 1\n")
    (home / "linked.arael").symlink_to(tmp_path / "secret.arael")
    (home / "outside").symlink_to(tmp_path)
    (found,) = said(main)
    assert found.code == "E0220"
    assert found.span is not None and found.span.source.name == str(main)


def test_dots_that_stay_in_the_folder_of_the_model_are_followed(tmp_path: Path) -> None:
    write(tmp_path, unit="const UNIT = 3\nfn twice(x) = x\n")
    write(tmp_path / "parts", goal='import "../unit.arael"\nconst GOAL = UNIT\n')
    for path in ("parts/goal.arael", "parts/../parts/goal.arael"):
        main = write(tmp_path, main=f'import "{path}"\n' + ROOT)
        assert solved(main) == pytest.approx(3.0)


def test_dots_out_of_the_folder_of_the_model_are_refused(tmp_path: Path) -> None:
    home = tmp_path / "home"
    write(tmp_path, unit="const UNIT = 3\n")
    write(home / "parts", goal='import "../../unit.arael"\nconst GOAL = UNIT\n')
    (found,) = said(write(home, main='import "parts/goal.arael"\n' + ROOT))
    assert (found.code, found.label) == ("E0220", "`..` leaves the folder of the model")


def test_a_circle_of_links_is_refused(tmp_path: Path) -> None:
    main = write(tmp_path, main='import "one.arael"\n' + ROOT)
    (tmp_path / "one.arael").symlink_to("two.arael")
    (tmp_path / "two.arael").symlink_to("one.arael")
    (found,) = said(main)
    assert (found.code, found.label) == ("E0220", "this is a link that leads to itself")


def test_links_within_the_folder_are_fine(tmp_path: Path) -> None:
    main = write(tmp_path, main='import "link.arael"\n' + ROOT, real="const GOAL = 2\n")
    (tmp_path / "link.arael").symlink_to(tmp_path / "more.arael")
    write(tmp_path, more='import "real.arael"\nfn twice(x) = 2 * x\n')
    assert solved(main) == pytest.approx(1.0)


def test_what_is_wrong_with_an_imported_file_names_both_places(tmp_path: Path) -> None:
    (found,) = said(write(tmp_path, main='import "gaol.arael"\n' + ROOT, goal="const GOAL = 1\n"))
    assert found.code == "E0101"
    assert found.notes == (f"imported by {tmp_path}/main.arael:1:1",)
    assert "goal.arael" in found.help[0]


def test_bounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [f"part{k}" for k in range(5)]
    main = write(
        tmp_path,
        main="".join(f'import "{n}.arael"\n' for n in names) + ROOT,
        **{n: f"const {n.upper()} = 1\n" for n in names},
    )
    monkeypatch.setattr(imports, "MAX_FILES", 4)
    assert [d.code for d in said(main)] == ["E0221"]
    monkeypatch.setattr(imports, "MAX_FILES", 64)
    monkeypatch.setattr(imports, "MAX_CHARACTERS", 60)
    assert [d.code for d in said(main)] == ["E0221"]


def test_a_change_of_an_imported_file_is_noticed(tmp_path: Path) -> None:
    files = {"main": 'import "goal.arael"\nfn twice(x) = 2 * x\n' + ROOT}
    main = write(tmp_path, **files, goal="const GOAL = 2\n")
    assert solved(main) == pytest.approx(1.0)
    assert load_compiled(main, interpret=True).origin == "interpreted"
    write(tmp_path, goal="const GOAL = 6\n")
    assert solved(main) == pytest.approx(3.0)


def test_the_same_text_beside_other_files_is_another_model(tmp_path: Path) -> None:
    text = 'import "goal.arael"\nfn twice(x) = 2 * x\n' + ROOT
    first = write(tmp_path / "one", main=text, goal="const GOAL = 2\n")
    second = write(tmp_path / "two", main=text, goal="const GOAL = 6\n")
    assert [solved(p) for p in (first, second, first)] == pytest.approx([1.0, 3.0, 1.0])


def test_functions_of_imported_files(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main='import "functions.arael"\nroot R { param a: real; constraint c { f(a) - 1 } }\n',
        functions="extern fn f(x) derivs [slope(x)]\nfn slope(x) = 3\n",
    )
    model = arael.load(main, functions={"f": _triple()}, interpret=True)
    assert model.functions["slope"](0.0) == 3
    found = model(a=0.0)
    found.solve()
    assert found.a.value == pytest.approx(1 / 3)


def _triple() -> object:
    import ctypes

    return ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(lambda x: 3 * x)


def test_relative_paths_of_the_caller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {"main": 'import "p/goal.arael"\nfn twice(x) = 2 * x\n' + ROOT}
    write(tmp_path, **files, p__goal="const GOAL = 2\n")
    monkeypatch.chdir(tmp_path)
    assert solved(Path("main.arael")) == pytest.approx(1.0)
    os.chdir(tmp_path / "p")
    assert solved(Path("../main.arael")) == pytest.approx(1.0)
