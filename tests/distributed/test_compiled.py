"""Compiled models by hash: what is not vouched for is refused."""

from __future__ import annotations

import msgspec
import pytest

import arael
from arael.compiler.cache import digest
from arael.diagnostics.records import AraelError
from arael.distributed import compiled, contents


def test_content_of_another_hash_is_refused_on_arrival() -> None:
    with pytest.raises(AraelError, match="E0883"):
        contents.arrive("0" * 64, b"anything")


def test_what_has_not_arrived_is_not_loaded() -> None:
    with pytest.raises(AraelError, match="E0883"):
        compiled.load("1" * 64)


def test_a_vouched_model_is_loaded_with_the_kernels_that_were_sent() -> None:
    kind = arael.load("linear")
    data = msgspec.msgpack.encode(compiled.content_of(kind.compiled))
    vouched = digest(data)
    contents.arrive(vouched, data)
    try:
        loaded = compiled.load(vouched)
        assert loaded.layout == kind.layout
        assert (loaded.compiled.kernels is None) == (kind.compiled.kernels is None)
    finally:
        contents.forget(vouched)
