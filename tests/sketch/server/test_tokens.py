"""Tokens of a server: new ones for a free port, kept ones for a chosen port."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from arael.sketch.server.tokens import tokens


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "state"
    monkeypatch.setattr("platformdirs.user_state_path", lambda *a, **k: folder)
    return folder


def test_a_free_port_has_new_tokens_each_time(state: Path, tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    assert not set(tokens(file, 0)) & set(tokens(file, 0))
    assert not state.exists()


def test_a_chosen_port_keeps_the_tokens_of_a_file(state: Path, tmp_path: Path) -> None:
    first = tokens(tmp_path / "a.json", 8123)
    assert tokens(tmp_path / "a.json", 8123) == first
    assert not set(tokens(tmp_path / "b.json", 8123)) & set(first)
    assert not set(tokens(tmp_path / "a.json", 8124)) & set(first)
    assert len(set(first)) == 2


@pytest.mark.skipif(os.name != "posix", reason="modes of files are those of POSIX")
def test_only_the_user_reads_them(state: Path, tmp_path: Path) -> None:
    first = tokens(tmp_path / "a.json", 8123)
    files = list((state / "sketch").iterdir())
    assert len(files) == 2
    for path in files:
        assert path.stat().st_mode & 0o777 == 0o600
        path.chmod(0o644)
    # others may have read them
    assert not set(tokens(tmp_path / "a.json", 8123)) & set(first)


@pytest.mark.parametrize("text", ["", "short", "x" * 5000, "é" * 32])
def test_a_damaged_file_is_replaced(state: Path, tmp_path: Path, text: str) -> None:
    tokens(tmp_path / "a.json", 8123)
    for path in (state / "sketch").iterdir():
        path.write_text(text, encoding="utf-8")
    page, agents = tokens(tmp_path / "a.json", 8123)
    assert len(page) == len(agents) == 32
    assert tokens(tmp_path / "a.json", 8123) == (page, agents)


def test_where_nothing_can_be_kept_there_is_a_new_one(state: Path, tmp_path: Path) -> None:
    state.write_text("a file in place of the folder")
    assert len(tokens(tmp_path / "a.json", 8123)[0]) == 32
