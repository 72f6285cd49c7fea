"""What Python's readers of numbers take, and files do not mean: `1_5`, other digits, hex."""

from __future__ import annotations

from pathlib import Path

import pytest

import arael
from arael import io
from arael.diagnostics.records import AraelError
from arael.io.csv_numbers import Points
from arael.io.plain_numbers import real, whole
from arael.runtime.store import Store
from tests.hand_layouts import pose_graph
from tests.io.cases import layout_of

ROWS = """
struct P { x: real; k: int = 0 }
root R { ps: list of P }
"""
ODD = ["1_5", "1__5", "0x1p3", "0x10", "1e1_0", "\u0661", "1,5", ""]


@pytest.mark.parametrize("text", ODD)
def test_odd_forms_are_no_numbers(text: str) -> None:
    for reader in (real, whole):
        with pytest.raises(ValueError, match=r".*"):
            reader(text)


@pytest.mark.parametrize("word", ["1_5", "0x1p3", "\u0661"])
@pytest.mark.parametrize("place", [0, 1, 2, 4])
def test_bal_refuses_them(tmp_path: Path, word: str, place: int) -> None:
    lines = ["1 1 1", "0 0 1.5 2", "0 0 0 0 0 0 500 0 0", "1", "2", "3"]
    words = lines[place].split()
    words[-1] = word
    lines[place] = " ".join(words)
    path = tmp_path / "a.bal"
    path.write_text("\n".join(lines))
    model = arael.load("bundle_adjustment")()
    with pytest.raises(AraelError) as failure:
        model.read(path)
    assert [d.code for d in failure.value.diagnostics] == ["E0716"]
    if place:
        span = failure.value.diagnostics[0].span
        assert span is not None
        assert span.text == word


@pytest.mark.parametrize("word", ["nan", "inf", "-Infinity", "1e999"])
def test_bal_refuses_what_is_not_finite(tmp_path: Path, word: str) -> None:
    path = tmp_path / "a.bal"
    path.write_text(f"1 1 1\n0 0 1 2\n0 0 0 0 0 0 {word} 0 0\n1 2 3\n")
    with pytest.raises(AraelError) as failure:
        arael.load("bundle_adjustment")().read(path)
    assert [d.code for d in failure.value.diagnostics] == ["E0705"]


def test_bal_names_the_word_after_odd_white_space(tmp_path: Path) -> None:
    path = tmp_path / "a.bal"
    path.write_bytes(b"1 1 1\n0 0 1 2\n0 0 0 0 0\xc2\xa00 500 0 0 0\n1 x 3\n")
    with pytest.raises(AraelError) as failure:
        arael.load("bundle_adjustment")().read(path)
    span = failure.value.diagnostics[0].span
    assert span is not None
    assert span.text == "0\u00a00"


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("VERTEX_SE2 1_5 0 0 0", "E0716"),
        ("VERTEX_SE2 0 1_5 0 0", "E0716"),
        ("VERTEX_SE2 0 0x1p3 0 0", "E0716"),
        ("VERTEX_SE2 0 nan 0 0", "E0705"),
        ("FIX 1_5", "E0716"),
    ],
)
def test_g2o_refuses_them(tmp_path: Path, line: str, code: str) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(f"VERTEX_SE2 15 0 0 0\n{line}\n")
    with pytest.raises(AraelError) as failure:
        io.read(Store(pose_graph(2)), path)
    assert code in [d.code for d in failure.value.diagnostics]


@pytest.mark.parametrize("cell", ["1_5", "0x1p3", "\u0661"])
@pytest.mark.parametrize("column", ["x", "k"])
def test_csv_refuses_them(tmp_path: Path, cell: str, column: str) -> None:
    path = tmp_path / "ps.csv"
    path.write_text(f"x,k\n{cell},1\n" if column == "x" else f"x,k\n1,{cell}\n")
    with pytest.raises(AraelError) as failure:
        io.read(Store(layout_of(ROWS)), path)
    assert [d.code for d in failure.value.diagnostics] == ["E0703"]


@pytest.mark.parametrize("cell", ["1_5", "0x1p3", "\u0661"])
def test_tables_of_numbers_refuse_them(tmp_path: Path, cell: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"x\n{cell}\n")
    with pytest.raises(AraelError) as failure:
        points = Points(path)
        points.columns(points.titles)
    assert [d.code for d in failure.value.diagnostics] == ["E0703"]
