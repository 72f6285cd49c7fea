"""Damaged files of any kind are read or refused, never a traceback."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.exchange.dxf.reader import from_dxf
from arael.sketch.exchange.dxf.writer import to_dxf
from arael.sketch.exchange.svg.reader import from_svg
from arael.sketch.exchange.svg.writer import to_svg
from tests.optional import needs
from tests.sketch.exchange.sketches import plate

ALLOWED = {"E1302", "E1303"}


def damaged(data: bytes, seed: int) -> bytes:
    """Lines exchanged, deleted, repeated, numbers replaced, bytes overwritten."""
    source = random.Random(seed)
    lines = data.split(b"\n")
    for _ in range(source.randint(1, 12)):
        i = source.randrange(len(lines))
        what = source.randrange(6)
        if what == 0:
            lines[i] = lines[source.randrange(len(lines))]
        elif what == 1:
            lines[i : i + 1] = [] if len(lines) > 2 else [b""]
        elif what == 2:
            lines[i:i] = lines[i : i + source.randint(1, 40)]
        elif what == 3:
            lines[i] = source.choice([b"-1", b"1e999", b"nan", b"", b"0", b"99999999999999", b"x"])
        elif what == 4:
            line = bytearray(lines[i] or b" ")
            line[source.randrange(len(line))] = source.randrange(256)
            lines[i] = bytes(line)
        else:
            lines = lines[: max(i, 2)]
    return b"\n".join(lines)


def check(read: Callable[[bytes], Any], data: bytes) -> None:
    try:
        read(data)
    except AraelError as error:
        assert {one.code for one in error.diagnostics} <= ALLOWED


@pytest.mark.parametrize("seed", range(150))
def test_damaged_svg(seed: int) -> None:
    check(from_svg, damaged(to_svg(plate()).encode(), seed))


@pytest.fixture(scope="module")
def written() -> bytes:
    return to_dxf(plate())


@needs("ezdxf")
@pytest.mark.parametrize("seed", range(6))
def test_damaged_dxf(seed: int, written: bytes) -> None:
    check(from_dxf, damaged(written, seed))


@needs("ezdxf")
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 200))
def test_damaged_dxf_of_many_kinds(seed: int, written: bytes) -> None:
    check(from_dxf, damaged(written, seed))
    # and near the geometry, where damage is felt
    at = written.index(b"ENTITIES")
    check(from_dxf, written[:at] + damaged(written[at:], seed))
