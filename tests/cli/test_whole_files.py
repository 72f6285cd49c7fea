"""What a command writes is there whole or not at all, whatever the disk does."""

from __future__ import annotations

import errno
import os
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.cli.conftest import Arael

FILES = {"-o": "out.json", "--covariance": "c.npz", "--report": "r.html", "--plot": "p.png"}
WANTED = [
    pytest.param(
        option,
        marks=pytest.mark.skipif(
            option == "--plot" and find_spec("matplotlib") is None,
            reason="figures need matplotlib: pip install 'arael[plot]'",
        ),
    )
    for option in FILES
]


@pytest.fixture
def full_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every write to a file of the folder ends as it does on a full disk."""

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)


@pytest.mark.parametrize("option", WANTED)
@pytest.mark.parametrize("there", [False, True])
@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_leaves_what_was_there(
    arael: Arael, line: Path, option: str, there: bool
) -> None:
    name = FILES[option]
    if there:
        (line / name).write_text("old")
    before = sorted(os.listdir(line))
    done = arael("solve", "line.arael", "line.json", "--interpret", option, name)
    assert done.code == 2
    assert "error[E0715]: cannot write the file: no space left on device" in done.err
    assert ("the old file is unchanged" in done.err) == there
    assert f"wrote {name}" not in done.out
    assert sorted(os.listdir(line)) == before
    assert not there or (line / name).read_text() == "old"


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_leaves_nothing_of_a_new_model(arael: Arael, line: Path) -> None:
    before = sorted(os.listdir(line))
    done = arael("new", "mine")
    assert done.code == 2 and "E0715" in done.err
    assert sorted(os.listdir(line)) == before


def test_a_disk_that_fills_up_leaves_no_half_of_a_new_model(
    arael: Arael, line: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, sync, calls = sorted(os.listdir(line)), os.fsync, []

    def fills_up(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) > 2:  # the first file and its folder were written
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", fills_up)
    assert "mine.json" in arael("new", "mine").err
    assert sorted(os.listdir(line)) == before
