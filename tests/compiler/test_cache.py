"""The cache of compiled models: what is found again, what is refused, and what is removed."""

import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import arael
from arael.cli.main import run
from arael.compiler import build, cache
from arael.compiler.cache import kernels, trust, upkeep
from arael.diagnostics.records import AraelError
from arael.loading import load_compiled
from tests.compiler.conftest import LINE

POSIX = pytest.mark.skipif(os.name != "posix", reason="owners and modes of files are POSIX's")


def entry() -> Path:
    """The folder of the only compiled kernels."""
    ((key, _, _),) = cache.entries()
    return cache.directory() / "arael-kernels" / key


def text_entry() -> Path:
    """The file of the only model text."""
    (path,) = (cache.directory() / "arael-models").iterdir()
    return path


def forbid_compiling(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> Path:
        raise AssertionError("the C compiler was called")

    monkeypatch.setattr(build, "compile_c", refuse)


def test_second_load_finds_what_the_first_compiled(model: Path) -> None:
    first, second = load_compiled(model), load_compiled(model)
    assert (first.origin, second.origin) == ("compiled", "cache")
    assert second.layout == first.layout


@pytest.mark.parametrize(
    "edit",
    [
        lambda text: "# A line through the origin.\n\n" + text,
        lambda text: text.replace("# Distance of a point.", "# Another comment."),
        lambda text: text.replace("    fit", "\n\n        fit"),
    ],
    ids=["above", "documentation", "spaces"],
)
def test_a_changed_comment_compiles_nothing(
    compiled: Path, monkeypatch: pytest.MonkeyPatch, edit: Callable[[str], str]
) -> None:
    before = load_compiled(compiled).layout.groups[0]
    forbid_compiling(monkeypatch)
    compiled.write_text(edit(LINE))
    for _ in range(2):
        found = load_compiled(compiled)
        assert found.origin == "cache"
    assert len(cache.entries()) == 1
    group = found.layout.groups[0]
    assert (group.where, group.doc) != (before.where, before.doc)
    line = 1 + compiled.read_text().split("fit data")[0].count("\n")
    assert group.where.split(":")[-2] == str(line)


@pytest.mark.slow
def test_processes_that_need_one_model_compile_it_once(model: Path) -> None:
    code = f"from arael.loading import load_compiled as l; print(l({str(model)!r}).origin)"
    running = [
        subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    origins = [process.communicate()[0].strip() for process in running]
    assert sorted(origins) == ["cache", "cache", "compiled"]


def test_a_changed_formula_is_compiled(model: Path) -> None:
    load_compiled(model)
    model.write_text(LINE.replace("- e.y", "+ e.y"))
    assert load_compiled(model).origin == "compiled"


def test_what_is_saved_during_a_compilation_is_not_kept_under_the_old_text(
    model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The text is read once: what is parsed, compiled and looked up again is the same."""
    from arael.compiler import compilation

    parse = compilation.compiler.syntax

    def saved_meanwhile(source: object) -> object:
        model.write_text(LINE.replace("- e.y", "- 2 * e.y"))
        return parse(source)  # type: ignore[arg-type]

    with monkeypatch.context() as editing:
        editing.setattr(compilation.compiler, "syntax", saved_meanwhile)
        load_compiled(model, interpret=True)
    model.write_text(LINE)
    line = arael.load(model, interpret=True)(a=0.0)
    line.data.extend(x=[1.0, 2.0], y=[3.0, 6.0])
    line.solve()
    assert line.a.value == pytest.approx(3)


@POSIX
def test_cache_is_private(compiled: Path) -> None:
    load_compiled(compiled)
    root = cache.directory()
    assert stat.S_IMODE(root.stat().st_mode) == 0o700
    for path in root.rglob("*"):
        assert not path.stat().st_mode & 0o077, path
    assert not list(root.rglob("build-*")) + list(root.rglob("new-*"))


@pytest.mark.sweep(2)
@pytest.mark.parametrize("suffix", [".so", ".pyx"])
def test_changed_kernels_are_not_used_but_made_again(compiled: Path, suffix: str) -> None:
    folder = entry()
    (victim,) = folder.glob(f"*{suffix}")
    changed = victim.read_bytes() + b" "
    victim.unlink()  # this process may have the kernels mapped: a change in place would end it
    victim.write_bytes(changed)
    victim.chmod(0o600)
    assert kernels.find(folder.name) is None
    code = (
        f"from arael.loading import load_compiled; print(load_compiled({str(compiled)!r}).origin)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert done.stdout.strip() == "compiled"
    assert kernels.find(folder.name) is not None


@pytest.mark.parametrize("place", range(0, 100, 7))
@pytest.mark.parametrize("of", ["text", "manifest"])
def test_a_flipped_bit_is_noticed_and_stops_no_command(
    compiled: Path, capsys: pytest.CaptureFixture[str], place: int, of: str
) -> None:
    load_compiled(compiled)
    path = text_entry() if of == "text" else entry() / kernels.MANIFEST
    data = bytearray(path.read_bytes())
    data[place * len(data) // 100] ^= 0x80  # no UTF-8 any more
    path.write_bytes(data)
    for command in ("info", "clear"):
        assert run(["cache", command]) == 0
        if of == "text" and command == "info":
            assert load_compiled(compiled).origin == "cache"  # checked anew, compiled no more
    assert capsys.readouterr().err == ""
    assert not list(cache.directory().rglob("*.so"))


def test_manifest_cannot_point_outside_its_folder(compiled: Path) -> None:
    folder = entry()
    outside = cache.directory() / "outside.so"
    outside.write_bytes(b"x")
    text = (folder / kernels.MANIFEST).read_text()
    name, sha = next(
        (n, s) for n, s in kernels.read_manifest(folder).files.items() if n.endswith(".pyx")
    )
    changed = text.replace(f'"{name}"', '"../../outside.so"').replace(sha, cache.digest(b"x"))
    (folder / kernels.MANIFEST).write_text(changed)
    assert kernels.find(folder.name) is None


def test_keys_cover_what_results_depend_on() -> None:
    texts = {
        cache.model_key("a", None, None),
        cache.model_key("b", None, None),
        cache.model_key("a", "R", None),
        cache.model_key("a", None, "f32"),
        cache.model_key("a", None, None, "/elsewhere"),
    }
    assert len(texts) == 5
    assert cache.kernels_key("a", "native") != cache.kernels_key("a", "baseline")
    assert cache.kernels_key("a", "native") != cache.kernels_key("b", "native")


@pytest.mark.parametrize("variable", ["CC", "CFLAGS", "LDFLAGS"])
def test_key_covers_compiler_and_flags(monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    plain = cache.kernels_key("a", "native")
    monkeypatch.setenv(variable, "something")
    assert cache.kernels_key("a", "native") != plain


def test_code_is_source_without_its_comments() -> None:
    source = (
        "# cython: boundscheck=False\n# Of fit.arael.\n    # fit.arael:3:4: a\n    t0 = x  # a\n"
    )
    other = "# cython: boundscheck=False\n# Of line.arael.\n    t0 = x  # b.c\n"
    assert cache.code_digest(source) == cache.code_digest(other)
    assert cache.code_digest(source) != cache.code_digest(source.replace("t0 = x", "t0 = y"))
    assert cache.code_digest(source) != cache.code_digest(source.replace("=False", "=True"))
    macro = "#define fetch(at) ((void)0)\n"
    assert cache.code_digest(source + macro) != cache.code_digest(source)


@POSIX
def test_directory_open_to_others_is_refused_and_has_to_be_emptied(compiled: Path) -> None:
    cache.directory().chmod(0o777)
    with pytest.raises(AraelError) as error:
        load_compiled(compiled)
    (found,) = error.value.diagnostics
    assert found.code == "E0805"
    assert "`arael cache clear`" in found.help[0]
    assert not any("chmod" in text for text in (*found.help, *found.notes))
    assert run(["cache", "clear"]) == 0
    assert not list(cache.directory().rglob("*.so"))
    assert stat.S_IMODE(cache.directory().stat().st_mode) == 0o700


def of_another_user(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make `path` look as if another user had made it."""
    victim = path.lstat().st_ino
    own = trust.is_own
    monkeypatch.setattr(
        trust, "is_own", lambda p: own(p) and (not p.exists() or p.stat().st_ino != victim)
    )
    monkeypatch.setattr(kernels, "is_own", trust.is_own)


def planted() -> dict[str, Path]:
    """The folders and files on the way to compiled kernels."""
    return {
        "kernels": cache.directory() / "arael-kernels",
        "entry": entry(),
        "module": next(entry().glob("*.so")),
        "manifest": entry() / kernels.MANIFEST,
    }


@POSIX
@pytest.mark.parametrize("what", ["kernels", "entry", "module", "manifest"])
@pytest.mark.parametrize("how", ["owner", "mode", "link"])
def test_planted_entries_are_not_loaded(
    compiled: Path, monkeypatch: pytest.MonkeyPatch, what: str, how: str
) -> None:
    """A folder that was open to others for a while is not trusted because it is closed now."""
    key = entry().name
    assert kernels.find(key) is not None
    path = planted()[what]
    if how == "owner":
        of_another_user(path, monkeypatch)
    elif how == "mode":
        path.chmod(0o777)
    else:
        path.rename(path.with_name("moved"))
        path.symlink_to(path.with_name("moved"))
    assert kernels.find(key) is None


@POSIX
@pytest.mark.skipif(
    os.name != "posix" or os.getuid() != 0, reason="only root gives files to others: run it as root"
)
def test_an_entry_of_another_user_is_replaced(compiled: Path) -> None:
    for path in (entry(), *entry().iterdir()):
        os.chown(path, 65534, -1)
    assert load_compiled(compiled).origin == "compiled"
    assert load_compiled(compiled).origin == "cache"


@POSIX
@pytest.mark.parametrize("how", ["mode", "link"])
def test_a_planted_text_entry_is_not_used(compiled: Path, how: str) -> None:
    load_compiled(compiled)
    path = text_entry()
    if how == "mode":
        path.chmod(0o666)
    else:
        path.rename(path.parents[1] / "moved")
        path.symlink_to(path.parents[1] / "moved")
    assert not trust.is_trusted(path)
    assert load_compiled(compiled).origin == "cache"  # checked and derived anew
    assert trust.is_trusted(path)


def test_cache_that_is_a_file_is_reported(model: Path) -> None:
    cache.directory().write_text("not a directory")
    with pytest.raises(AraelError) as error:
        load_compiled(model)
    assert error.value.diagnostics[0].code == "E0804"
    assert "ARAEL_CACHE_DIR" in error.value.diagnostics[0].help[0]


def test_a_relative_cache_directory(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(model.parent)
    monkeypatch.setenv("ARAEL_CACHE_DIR", "kept/here")
    assert load_compiled(model).origin == "compiled"
    assert list((model.parent / "kept" / "here").rglob("*.so"))
    assert load_compiled(model).origin == "cache"


def test_clear_removes_everything_of_ours_and_counts_it(compiled: Path) -> None:
    load_compiled(compiled)
    root = cache.directory()
    (root / "arael-kernels" / f"build-{'0' * 40}-x").mkdir()
    (root / ("0" * 40)).mkdir()  # an entry of an earlier version
    cleared = cache.clear()
    assert cleared.count == 1
    assert cleared.size > 10_000
    assert cleared.refused == ()
    assert cache.entries() == []
    assert {p.name for p in root.rglob("*") if p.is_file()} <= {
        p.name for p in root.rglob("*.lock")
    }
    assert not (root / ("0" * 40)).exists()


def test_clear_removes_nothing_of_the_user(compiled: Path) -> None:
    """The cache's folder may be one that holds other things."""
    root = cache.directory()
    for name in ("models/mine.arael", "kernels/mine.so", "build-release/out", "notes.lock"):
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_text("mine")
    (root / "link").symlink_to(compiled.parent)
    cache.clear()
    kept = {p.name for p in root.rglob("*") if p.is_file() and "arael-locks" not in p.parts}
    assert kept == {"mine.arael", "mine.so", "out", "notes.lock"}
    assert compiled.exists()


def test_clear_follows_no_links(compiled: Path) -> None:
    root = cache.directory()
    outside = compiled.parent / "outside"
    (root / "arael-kernels").rename(outside)
    (root / "arael-kernels").symlink_to(outside)
    held = list(outside.rglob("*.so"))
    cache.clear()
    assert held and all(path.exists() for path in held)
    assert not (root / "arael-kernels").is_symlink()


def test_imported_files_are_watched(model: Path) -> None:
    shared = model.with_name("shared.arael")
    shared.write_text("const K = 2\n")
    model.write_text('import "shared.arael"\n' + LINE.replace("a * e.x", "K * a * e.x"))
    load_compiled(model)
    assert load_compiled(model).origin == "cache"
    shared.write_text("# Twice.\nconst K = 2\n")
    assert load_compiled(model).origin == "cache"
    shared.write_text("const K = 3\n")
    assert load_compiled(model).origin == "compiled"


def test_entries_used_longest_ago_are_dropped(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(upkeep, "KEPT", 2)
    folder = trust.prepare("arael-kernels")
    keys = [f"{k:040x}" for k in range(4)]
    for age, key in enumerate(keys):
        (folder / key).mkdir(mode=0o700)
        kernels.seal(folder / key, key, "line", "line.arael", "", {})
        os.utime(folder / key, (1e9 - age, 1e9 - age))
    os.utime(folder / keys[3])  # used again
    upkeep.trim()
    assert {key for key, _, _ in cache.entries()} == {keys[0], keys[3]}


def test_a_folder_that_cannot_be_removed_is_moved_aside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trust.shutil, "rmtree", lambda path, ignore_errors: None)
    for text in ("first", "second"):
        (tmp_path / "arael-models").mkdir()
        (tmp_path / "arael-models" / "theirs").write_text(text)
        trust.remove(tmp_path / "arael-models")
        assert not (tmp_path / "arael-models").exists()
    kept = sorted(path.read_text() for path in tmp_path.glob("refused-*/arael-models/theirs"))
    assert kept == ["first", "second"]
