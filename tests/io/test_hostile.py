"""Untrusted files: reading any content ends with the data or with diagnostics."""
# ruff: noqa: E501 - lists of odd texts

from __future__ import annotations

import functools
import io as std_io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael import io
from arael.diagnostics.records import AraelError
from arael.runtime.store import Store
from tests.hand_layouts import odds, pose_graph, slam
from tests.io.test_json import odds_scene, slam_scene

ODD = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), st.text(max_size=5),
    st.just([]), st.just({}), st.just([[1, 2], [3]]), st.just({"value": 1, "fixed": []}), st.just([[]]),
)  # fmt: skip


def spots(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything inside a JSON value."""
    found = [path] if path else []
    items = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, inner in items:
        found += spots(inner, (*path, key))
    return found


def read(layout: Any, content: bytes, path: Path) -> Store | None:
    """What is read, or None where that is refused with diagnostics."""
    path.write_bytes(content)
    store = Store(layout)
    try:
        io.read(store, path, limit=10_000_000)
    except AraelError as failure:
        assert 0 < len(failure.diagnostics) <= 20
        assert all(d.code.startswith("E07") and d.message for d in failure.diagnostics)
        assert all(t.size == (p == "") for p, t in store.tables.items())
        return None
    return store


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("layout", "scene"), [(slam, slam_scene), (odds, odds_scene)])
@settings(max_examples=300)
@given(data=st.data())
def test_json_with_odd_values(
    layout: Any, scene: Any, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """One value replaced by an odd one; what is accepted writes and reads as the same."""
    whole = scene()
    *path, last = data.draw(st.sampled_from(spots(whole)))
    holder = functools.reduce(lambda inner, key: inner[key], path, whole)
    holder[last] = data.draw(ODD)
    file = tmp_path_factory.getbasetemp() / "odd.json"
    store = read(layout(), json.dumps(whole).encode(), file)
    if store is not None:
        io.write(store, file)
        once = file.read_bytes()
        io.write(read(layout(), once, file), file)
        assert file.read_bytes() == once


TEXTS = {
    "json": json.dumps(slam_scene()).encode(),
    "g2o": b"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 1\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    b"EDGE_PRIOR_SE2 0 0 0 0 1 0 0 1 0 1\n",
    "csv": b"prev,cur\n0,1\n1,0\n",
}


@pytest.mark.sweep(3)
@pytest.mark.parametrize("kind", TEXTS)
@settings(max_examples=300)
@given(data=st.data())
def test_texts_with_random_changes(
    kind: str, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    content = bytearray(TEXTS[kind])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        cut = data.draw(st.integers(0, 3))
        content[at : at + cut] = data.draw(st.one_of(st.binary(max_size=3), st.sampled_from(
            [b"1e400", b"nan", b"-", b'"', b"{", b"[", b"\x00", b"\n", b"99999999999999999999", b"_"])))  # fmt: skip
    file = tmp_path_factory.getbasetemp() / f"{'pose_pairs' if kind == 'csv' else 'changed'}.{kind}"
    layout = pose_graph(2) if kind == "g2o" else slam()
    read(layout, bytes(content), file)


@functools.cache
def archive() -> bytes:
    memory = std_io.BytesIO()
    np.savez(memory, **{
        "landmarks.pos": np.zeros((2, 3)), "landmarks.name": np.array(["a", "b"]),
        "landmarks.frines.offsets": np.array([0, 0, 0]),
    })  # fmt: skip
    return memory.getvalue()


@settings(max_examples=400)
@given(data=st.data())
def test_archives_with_random_changes(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    content = bytearray(archive())
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 4))] = data.draw(st.binary(max_size=4))
    read(slam(), bytes(content), tmp_path_factory.getbasetemp() / "changed.npz")


@pytest.mark.slow
def test_deep_and_long_texts_end_quickly(tmp_path: Path) -> None:
    for text in (
        b"[" * 5_000_000, b'{"a":' * 1_000_000, b'{"gamma": ' + b"9" * 5_000_000 + b"}",
        b'{"poses": [' + b"{}," * 500_000 + b"{}]}", b'"' * 5_000_000, b"{" + b'"a":1,' * 500_000 + b'"a":1}',
    ):  # fmt: skip
        assert read(slam(), text, tmp_path / "long.json") is None
    for text in (b"VERTEX_SE2 " + b"1 " * 2_000_000, b"FIX 1\n" * 500_000, b"x\n" * 1_000_000):
        assert read(pose_graph(2), text, tmp_path / "long.g2o") is None
