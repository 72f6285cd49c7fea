import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import arael
from arael.compiler import build, cache
from arael.diagnostics.records import AraelError
from arael.loading import InterpretedWarning, load_compiled

LINE = """
struct Point { x: real; y: real }
root Line {
    param a: real
    data: list of Point
    fit data as e { a * e.x - e.y }
}
"""


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model file and an empty cache beside it."""
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    path = tmp_path / "line.arael"
    path.write_text(LINE)
    return path


def test_second_load_finds_what_the_first_compiled(model: Path) -> None:
    first, second = load_compiled(model), load_compiled(model)
    assert (first.origin, second.origin) == ("compiled", "cache")
    assert second.layout == first.layout


def test_cache_is_private(model: Path) -> None:
    load_compiled(model)
    assert stat.S_IMODE(cache.directory().stat().st_mode) == 0o700
    assert not list(cache.directory().glob("build-*"))
    assert not list(cache.directory().glob("*.lock"))


@pytest.mark.parametrize("suffix", [".so", ".json", ".pyx"])
def test_changed_entry_is_not_used_but_made_again(model: Path, suffix: str) -> None:
    load_compiled(model)
    ((key, _, _),) = cache.entries()
    victim = next(
        p
        for p in (cache.directory() / key).iterdir()
        if p.suffix == suffix and p.name != "manifest.json"
    )
    changed = victim.read_bytes() + b" "
    victim.unlink()  # this process has the kernels mapped: a file changed in place would end it
    victim.write_bytes(changed)
    assert cache.find(key) is None
    code = f"from arael.loading import load_compiled; print(load_compiled({str(model)!r}).origin)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert done.stdout.strip() == "compiled"
    assert cache.find(key) is not None


def test_manifest_cannot_point_outside_its_folder(model: Path) -> None:
    load_compiled(model)
    ((key, manifest, _),) = cache.entries()
    folder = cache.directory() / key
    outside = cache.directory() / "outside.so"
    outside.write_bytes(b"x")
    text = (folder / "manifest.json").read_text()
    (folder / "manifest.json").write_text(
        text.replace('"layout.json"', '"../outside.so"').replace(
            manifest.files["layout.json"], cache.digest(b"x")
        )
    )
    assert cache.find(key) is None


def test_key_covers_text_root_precision_and_target() -> None:
    keys = {
        cache.key("a", None, None, "native"),
        cache.key("b", None, None, "native"),
        cache.key("a", "R", None, "native"),
        cache.key("a", None, "f32", "native"),
        cache.key("a", None, None, "interpreter"),
    }
    assert len(keys) == 5


def test_key_covers_compiler_and_flags(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = cache.key("a", None, None, "native")
    monkeypatch.setenv("CFLAGS", "-O0")
    assert cache.key("a", None, None, "native") != plain


@pytest.mark.skipif(os.name != "posix", reason="permissions of other users are a POSIX matter")
def test_directory_open_to_others_is_refused(model: Path) -> None:
    cache.directory().mkdir()
    cache.directory().chmod(0o777)
    with pytest.raises(AraelError) as error:
        load_compiled(model)
    assert error.value.diagnostics[0].code == "E0805"
    assert "chmod 700" in error.value.diagnostics[0].help[0]


def test_cache_that_is_a_file_is_reported(model: Path) -> None:
    cache.directory().write_text("not a directory")
    with pytest.raises(AraelError) as error:
        load_compiled(model)
    assert error.value.diagnostics[0].code == "E0804"
    assert "ARAEL_CACHE_DIR" in error.value.diagnostics[0].help[0]


def test_without_compiler_the_interpreter_stands_in(
    model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.warns(InterpretedWarning, match="no-such-compiler"):
        line = arael.load(model)(a=0.0)
    assert type(line).compiled.origin == "interpreted"  # type: ignore[attr-defined]
    line.data.extend(x=[1.0, 2.0], y=[3.0, 6.0])
    line.solve()
    assert line.a.value == pytest.approx(3)


def test_once_there_is_a_compiler_it_is_used(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as without:
        without.setattr(build, "find_compiler", lambda: None)
        with pytest.warns(InterpretedWarning, match="no C compiler"):
            load_compiled(model)
        with pytest.warns(InterpretedWarning):  # from the cache
            assert load_compiled(model).origin == "interpreted"
        with pytest.raises(AraelError, match="no C compiler found"):
            load_compiled(model, interpret=False)
    assert load_compiled(model).origin == "compiled"


def test_broken_compiler_is_reported_and_its_words_are_kept(
    model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "false")
    with pytest.warns(InterpretedWarning, match="ended with status 1"):
        assert load_compiled(model).kernels is None
    (log,) = (cache.directory() / "failed").iterdir()
    assert "status 1" in log.read_text()


def test_clear_removes_everything_and_counts_it(model: Path) -> None:
    load_compiled(model)
    count, size = cache.clear()
    assert count == 1
    assert size > 10_000
    assert cache.entries() == []


def test_imported_files_are_watched(model: Path) -> None:
    shared = model.with_name("shared.arael")
    shared.write_text("const K = 2\n")
    model.write_text('import "shared.arael"\n' + LINE.replace("a * e.x", "K * a * e.x"))
    load_compiled(model)
    assert load_compiled(model).origin == "cache"
    shared.write_text("const K = 3\n")
    assert load_compiled(model).origin == "compiled"


def test_entries_used_longest_ago_are_dropped(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "KEPT", 2)
    texts = [model.read_text() + f"# {k}\n" for k in range(4)]
    made = []
    for k, text in enumerate(texts):
        model.write_text(text)
        load_compiled(model)
        (new,) = {name for name, _, _ in cache.entries()} - set(made)
        made.append(new)
        os.utime(cache.directory() / new, (k, k))
        if k == 1:  # the first one is used again
            model.write_text(texts[0])
            load_compiled(model)
    assert {name for name, _, _ in cache.entries()} == {made[0], made[3]}


def test_messages_name_the_file_at_hand(tmp_path: Path) -> None:
    """The same text elsewhere is the same model, at another place."""
    text = "struct Unheld { x: real }\nroot R { param a: real; b: real; constraint c { a - b } }\n"
    for name in ("one", "two"):
        path = tmp_path / f'{name} "é"' / "m.arael"
        path.parent.mkdir()
        path.write_text(text)
        layout = load_compiled(path, interpret=True).layout
        assert layout.source == str(path)
        assert layout.tables[0].column("b").where == f"{path}:2:25"
        assert layout.groups[0].where.startswith(str(path))
        assert f" --> {path}:1:8" in layout.warnings[0]
