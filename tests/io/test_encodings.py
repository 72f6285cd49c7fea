"""Byte-order marks, bytes that are no UTF-8, half surrogate pairs, names that are no text."""

from __future__ import annotations

import codecs
import os
import sys
from pathlib import Path

import pytest

from arael import io
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.render import render
from arael.io.csv_numbers import Points
from arael.runtime.store import Store
from tests.hand_layouts import pose_graph
from tests.io.cases import layout_of

MODEL = """
struct P { x: real; name: string = "" }
root R { ps: list of P }
"""
MARK = codecs.BOM_UTF8


def found(path: Path, content: bytes) -> list[Diagnostic]:
    """What is wrong with a data file of these bytes."""
    path.write_bytes(content)
    with pytest.raises(AraelError) as failure:
        io.read(Store(layout_of(MODEL)), path)
    return list(failure.value.diagnostics)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.json", b'{"ps": [{"x": 1}]}'),
        ("ps.csv", b"x\n1\n"),
        ("data", b'{"ps": [{"x": 1}]}'),
    ],
)
def test_a_byte_order_mark_is_passed_over(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(MARK + content)
    store = Store(layout_of(MODEL))
    io.read(store, tmp_path / name)
    assert store.tables["ps"].column("x").tolist() == [1.0]


def test_a_byte_order_mark_before_a_graph(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_bytes(MARK + b"VERTEX_SE2 0 1 2 3\n")
    store = Store(pose_graph(2))
    io.read(store, tmp_path / "a.g2o")
    assert store.tables["poses"].size == 1


@pytest.mark.parametrize("name", ["ps.csv", "a.json", "data.g2o"])
@pytest.mark.parametrize("content", [MARK, MARK + b"\n"])
def test_nothing_but_a_mark_is_an_empty_file(tmp_path: Path, name: str, content: bytes) -> None:
    assert [d.code for d in found(tmp_path / name, content)] == ["E0712"]


@pytest.mark.parametrize("content", [MARK, b"\n", MARK + b"\r\n\r\n"])
def test_nothing_but_a_mark_is_no_table_of_numbers(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(AraelError) as failure:
        points = Points(tmp_path / "a.csv")
        points.columns(points.titles)
    assert [d.code for d in failure.value.diagnostics] == ["E0712"]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-16-le"])
@pytest.mark.parametrize("name", ["a.json", "ps.csv"])
def test_utf_16_is_named(tmp_path: Path, name: str, encoding: str) -> None:
    content = '\ufeff{"ps": []}'.encode(encoding)
    (wrong,) = found(tmp_path / name, content)
    assert (wrong.code, "UTF-16" in wrong.message) == ("E0711", True)


@pytest.mark.parametrize(
    ("content", "line", "column", "words"),
    [
        (MARK + b'{"ps": [\n {"x": .5}]}', 2, 8, "invalid character in `ps[0]"),
        (b'{"ps": [\n {"x": 1, "name": "a\xffb"}]}', 2, 21, "byte 0xff in `ps[0].name`"),
        (b'{"ps": [\n {"x": 1, "\xc3\xa9\xff": 1}]}', 2, 13, "byte 0xff in `ps[0]`"),
        (
            b'{"ps": [\n {"x": 1, "name": "\xc3\xa9\\ud800b"}]}',
            2,
            21,
            "`\\ud800` is an unpaired surrogate",
        ),
        (
            b'{"ps": [\n {"x": 1, "name": "\\ud800\\ud801"}]}',
            2,
            20,
            "`\\ud800` is an unpaired surrogate",
        ),
        (
            b'{"ps": [\n {"x": 1, "name": "\\ud83d\\ude00\\udc00"}]}',
            2,
            32,
            "`\\udc00` is an unpaired surrogate",
        ),
        (
            b'{"ps": [\n {"x": 1, "a\\udc00": 1}]}',
            2,
            13,
            "`ps[0]`: `\\udc00` is an unpaired surrogate",
        ),
        (
            b'{"ps": [\n {"x": 1, "name": "\\\\ud800 \\ud800 "}]}',
            2,
            28,
            "`\\ud800` is an unpaired surrogate",
        ),
    ],
)
def test_json_is_shown_at_its_place(
    tmp_path: Path, content: bytes, line: int, column: int, words: str
) -> None:
    (wrong,) = found(tmp_path / "a.json", content)
    assert wrong.code == "E0711"
    assert words in wrong.message
    assert wrong.span is not None
    assert str(wrong.span).endswith(f"a.json:{line}:{column}")


def test_a_whole_surrogate_pair_is_a_character(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"ps": [{"x": 1, "name": "\\ud83d\\ude00"}]}')
    store = Store(layout_of(MODEL))
    io.read(store, tmp_path / "a.json")
    assert store.tables["ps"].column("name").tolist() == ["\U0001f600"]


@pytest.mark.parametrize("text", ["\ud800", "a\udcffb"])
def test_half_pairs_do_not_enter_a_model(text: str) -> None:
    store = Store(layout_of(MODEL))
    for given in (text, [text], ["a", text]):
        with pytest.raises(AraelError, match="unpaired surrogate") as failure:
            store.tables["ps"].extend(1 if given == text else len(given), x=1.0, name=given)
        assert failure.value.diagnostics[0].code == "E0703"
    assert store.tables["ps"].size == 0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"a": 1, "\\u0061": 2}', "`a` is given twice"),
        (b'{"a": 1, "a": 2}', "`a` is given twice"),
    ],
)
def test_keys_are_compared_as_characters(tmp_path: Path, content: bytes, words: str) -> None:
    (tmp_path / "a.json").write_bytes(content)
    with pytest.raises(AraelError, match=words):
        io.read(Store(layout_of("root R { a: real }")), tmp_path / "a.json")


def test_names_that_are_no_text_are_printed(tmp_path: Path) -> None:
    if sys.platform in ("win32", "darwin"):
        pytest.skip("this system's file names are text; run on Linux")
    path = os.path.join(tmp_path, os.fsdecode(b"bad\xff.json"))
    with open(path, "w") as file:
        file.write('{"ps": [{"y": 1}]}')
    for name in (path, os.fsencode(path), f"{path}x.json"):
        with pytest.raises(AraelError) as failure:
            io.read(Store(layout_of(MODEL)), name)  # type: ignore[arg-type]
        text = render(failure.value.diagnostics) + str(failure.value)
        assert "bad\\xff.json" in text.encode().decode()
    with open(path, "w") as file:
        file.write('{"ps": [{"x": 1}]}')
    store = Store(layout_of(MODEL))
    io.read(store, path)
    io.write(store, path)
    assert store.tables["ps"].size == 1


@pytest.mark.parametrize("name", ["a\0b.json", "\ud800.json", 5, None])
def test_what_names_no_file_is_refused(name: object) -> None:
    store = Store(layout_of(MODEL))
    for use in (io.read, io.write):
        with pytest.raises(AraelError) as failure:
            use(store, name)  # type: ignore[operator]
        assert failure.value.diagnostics[0].code == "E0712"
        render(failure.value.diagnostics).encode()
