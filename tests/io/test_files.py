"""Bytes of data files: how much is read, and what memory that takes."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from arael.io.files import read_bytes


def test_a_small_file_asks_for_little_address_space(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource", reason="address space is limited on Unix only")
    path = tmp_path / "points.json"
    path.write_text("[1, 2, 3]")
    used = int(Path("/proc/self/statm").read_text().split()[0]) if os.path.exists("/proc") else 0
    if not used:
        pytest.skip("needs /proc to know the address space in use; run it on Linux")
    before = resource.getrlimit(resource.RLIMIT_AS)
    size = used * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + (256 << 20), before[1]))
    try:
        assert read_bytes(path) == b"[1, 2, 3]"
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.parametrize("size", [1, 9, 10, 11, 3 << 20])
def test_the_limit_counts_bytes(tmp_path: Path, size: int) -> None:
    path = tmp_path / "data"
    path.write_bytes(b"x" * size)
    assert read_bytes(path, limit=size) == b"x" * size
    if size > 1:
        with pytest.raises(AraelError, match="E0714"):
            read_bytes(path, limit=size - 1)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    content = b"x" * (3 << 20)
    writer = threading.Thread(target=path.write_bytes, args=(content,))
    writer.start()
    try:
        assert read_bytes(path) == content
    finally:
        writer.join()
