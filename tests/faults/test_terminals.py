"""Closed pipes, a full device, no home, no current folder, a locale without UTF-8."""

from __future__ import annotations

import os
import sys

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow
SOLVE = "$ARAEL solve line.arael line.json --interpret"

CLOSED = {
    "pipe closed": ("$ARAEL explain E0101 | true", {0}),
    "pipe closed early": (f"{SOLVE} -v 2>&1 | head -c 1 >/dev/null", {0}),
    "no output": (f"{SOLVE} >&-", {0, 2}),
    "no output, an error": ("$ARAEL solve absent.arael line.json >&-", {2}),
    "no errors": (f"{SOLVE} 2>&-", {0}),
    "no errors, an error": ("$ARAEL solve absent.arael line.json 2>&-", {2}),
    "neither": (f"{SOLVE} >&- 2>&-", {0, 2}),
    "no input": (f"{SOLVE} <&-", {0}),
    "calc without input": ("$ARAEL calc <&-", {0, 2}),
    "fmt without input": ("$ARAEL fmt - <&-", {0, 2}),
    "full device": (f"{SOLVE} >/dev/full", {2}),
    "full device, json": (f"{SOLVE} --json >/dev/full", {2}),
    "full device, an error": ("$ARAEL solve absent.arael line.json --json >/dev/full", {2}),
    "full device for errors": ("$ARAEL solve absent.arael line.json 2>/dev/full", {2}),
    "help into a full device": ("$ARAEL --help >/dev/full", {2}),
}


@pytest.mark.parametrize("kind", CLOSED)
def test_outputs_that_are_closed(place: Place, kind: str) -> None:
    text, codes = CLOSED[kind]
    if "/dev/full" in text and not os.path.exists("/dev/full"):
        pytest.skip("needs /dev/full (Linux)")
    done = place.shell(text).require(codes)
    if kind.startswith("full device") and "errors" not in kind:
        done.require(codes, "no space", "cannot write", "absent")
    assert place.leftovers() == []


def test_full_device_that_is_named_as_output(place: Place) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("needs /dev/full (Linux)")
    os.symlink("/dev/full", place.folder / "out.json")
    done = place.arael("solve", "line.arael", "line.json", "--interpret", "-o", "out.json")
    done.require({1, 2}, "no space")
    assert os.path.islink(place.folder / "out.json")


@pytest.mark.parametrize("home", [None, "", "/nonexistent", "/dev/null"])
def test_no_home(place: Place, home: str | None) -> None:
    """Without a home the cache has no folder: the model runs, or an error names what to set."""
    env = {
        "HOME": home,
        "ARAEL_CACHE_DIR": None,
        "XDG_CACHE_HOME": str(place.cache) if home != "/dev/null" else None,
    }
    place.arael("solve", "line.arael", "line.json", "--interpret", env=env).require(
        {0, 2}, "converged", "ARAEL_CACHE_DIR"
    )
    place.arael("doctor", env=env).require({0, 1, 2})
    place.arael("cache", "info", env=env).require({0, 2})
    assert place.leftovers() == []


def test_relative_cache(place: Place) -> None:
    env = {"ARAEL_CACHE_DIR": "here"}
    place.arael("solve", "line.arael", "line.json", "--compiled", env=env).require(0, "converged")
    assert {path.split(os.sep)[0] for path in place.leftovers()} == {"here"}


@pytest.mark.parametrize("locale", ["C", "POSIX", "no_SUCH.UTF-8"])
def test_locale(place: Place, locale: str) -> None:
    env = {"LC_ALL": locale, "LANG": locale, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    (place.folder / "größe.arael").write_text("root R {\n    param σ: real\n}\n", encoding="utf-8")
    place.arael("check", "größe.arael", env=env).require(2, "E01")
    place.arael("solve", "line.arael", "line.json", "--interpret", env=env).require(0, "converged")
    place.arael("info", "slam", env=env).require(0)
    place.arael("explain", "E0101", env=env).require(0)


def test_names_that_are_no_utf8(place: Place) -> None:
    raw = os.fsencode(place.folder)
    try:
        for old, new in ((b"line.arael", b"li\xffne.arael"), (b"line.json", b"li\xffne.json")):
            with open(raw + b"/" + old, "rb") as a, open(raw + b"/" + new, "wb") as b:
                b.write(a.read())
    except OSError:
        pytest.skip("needs a file system with names of any bytes")
    command = [
        sys.executable,
        "-m",
        "arael",
        "solve",
        b"li\xffne.arael",
        b"li\xffne.json",
        "--interpret",
    ]
    place.run([*command]).require({0, 2})  # type: ignore[list-item]
    place.run([*command, "-o", b"ou\xfft.json", "--json"]).require({0, 2})  # type: ignore[list-item]
    place.run([*command[:3], "check", b"ab\xffsent.arael"]).require(2)  # type: ignore[list-item]


def test_folder_that_is_gone(place: Place) -> None:
    text = "mkdir gone && cd gone && rmdir ../gone && $ARAEL"
    place.shell(f"{text} solve ../line.arael ../line.json --interpret").require({0, 2})
    place.shell(f"{text} info slam").require({0, 2})
    place.shell(f"{text} new line").require(2, "current folder")
    place.shell(f"{text} doctor").require({0, 1, 2})
