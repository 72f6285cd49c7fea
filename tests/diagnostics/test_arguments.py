"""Checks of arguments of Python calls, which public functions share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.arguments import as_list, as_mapping, as_numbers, fail, require
from arael.diagnostics.records import AraelError


def test_require_names_the_argument() -> None:
    require(True, "f", "x", "a name", 3)
    with pytest.raises(AraelError, match=r"(?s)f: error.E0828.*`x` must be a name, found 3"):
        require(False, "f", "x", "a name", 3, "write `f('x')`")


def test_one_item_alone_is_a_list_of_one() -> None:
    assert as_list("ab", str, "f", "names", "names") == ["ab"]
    assert as_list(("a", "b"), str, "f", "names", "names") == ["a", "b"]
    assert as_list([], str, "f", "names", "names") == []


def test_none_is_an_empty_mapping() -> None:
    assert as_mapping(None, str, "f", "values", "a mapping") == {}
    assert as_mapping({"a": 1}, str, "f", "values", "a mapping") == {"a": 1}


def test_numbers_of_any_shape() -> None:
    assert as_numbers(3, "f", "x").shape == ()
    assert as_numbers([[1, True]], "f", "x").tolist() == [[1.0, 1.0]]
    given = np.zeros(3)
    assert as_numbers(given, "f", "x") is given


@pytest.mark.parametrize(
    "call",
    [
        lambda: as_list(3, str, "f", "x", "a list"),
        lambda: as_list(b"ab", str, "f", "x", "a list"),
        lambda: as_list(["a", 3], str, "f", "x", "a list"),
        lambda: as_mapping([1], str, "f", "x", "a mapping"),
        lambda: as_mapping({3: 4}, str, "f", "x", "a mapping"),
        lambda: as_numbers("3", "f", "x"),
        lambda: as_numbers(None, "f", "x"),
        lambda: as_numbers([1, None], "f", "x"),
        lambda: as_numbers(1j, "f", "x"),
        lambda: as_numbers([[1], [2, 3]], "f", "x"),
    ],
)
def test_wrong_arguments_are_refused(call: Callable[[], Any]) -> None:
    with pytest.raises(AraelError, match="E0828"):
        call()


def test_fail_raises_one_diagnostic() -> None:
    with pytest.raises(AraelError) as caught:
        fail("E0652", "no", origin="here", help=("do",))
    (one,) = caught.value.diagnostics
    assert (one.code, one.message, one.origin, one.help) == ("E0652", "no", "here", ("do",))
