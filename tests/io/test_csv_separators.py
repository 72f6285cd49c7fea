"""The separator of a table of numbers, and places in messages about it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.io.csv_numbers import Points
from arael.io.csv_separators import separated


@pytest.mark.parametrize(
    ("text", "delimiter"),
    [
        ("a,b\n1,2\n", ","),
        ("a;b\n1,5;2,5\n", ";"),
        ("a\tb\n1\t2\n", "\t"),
        ("a|b\n1|2\n", "|"),
        ("a b\n1 2\n", "\t"),
        ("a [m, s];b\n1;2\n", ";"),
        ('a,b\n"1,5",2\n', ","),
        ("a\n1\n2\n", None),
        ("a,b\n1,2,3\n", None),
        ("a b\n1 2 3\n", None),
    ],
)
def test_the_separator_divides_all_lines_equally(text: str, delimiter: str | None) -> None:
    assert separated(text.encode())[1] == delimiter


def test_messages_name_the_line_of_a_table_with_spaces(tmp_path: Path) -> None:
    path = tmp_path / "t.txt"
    path.write_text("# made by hand\n\nx [m] y\n1 2\n\n3 four\n")
    points = Points(path)
    assert points.titles == {"x": "x [m]", "y": "y"}
    with pytest.raises(AraelError) as caught:
        points.columns(["y"])
    (found,) = caught.value.diagnostics
    assert found.origin == "t.txt:6: y" and 'found "four"' in found.message


def test_texts_and_missing_values(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("x;who\n1,5;a b\nNA;c\n")
    points = Points(path)
    assert points.texts("who") == ["a b", "c"] and points.size == 2
    np.testing.assert_array_equal(points.columns(["x"])["x"], [1.5, np.nan])


def test_a_decimal_comma_is_read_only_where_commas_do_not_separate(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text('x,y\n"1,5",2\n')
    with pytest.raises(AraelError, match=r'expected a number, found "1,5"'):
        Points(path).columns(["x"])
