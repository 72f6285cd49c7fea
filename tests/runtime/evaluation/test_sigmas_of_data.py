"""A sigma in data that is no standard deviation is named before the solve: field, row, key."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Anchor {
    key name
    name: string
    range_sigma: real
}
struct Range {
    to: ref Anchor in root.anchors
    d: real
    sigma: real = 1
    constraint near when d > 0 { (root.a - d) / (sigma * to.range_sigma) }
}
root Tank {
    param a: real = 0
    anchors: list of Anchor
    ranges: list of Range
}
"""


def tank(sigma: float, other: float, d: float = 2.0) -> Any:
    model = arael.loads(TEXT, interpret=True)()
    model.anchors.append(name="left", range_sigma=1.0)
    model.anchors.append(name="right", range_sigma=other)
    model.ranges.append(to="left", d=1.0)
    model.ranges.append(to="right", d=d, sigma=sigma)
    return model


@pytest.mark.parametrize(
    ("sigma", "other", "words"),
    [
        (0.0, 1.0, "`sigma` of ranges[1] is 0"),
        (-0.5, 1.0, "`sigma` of ranges[1] is -0.5"),
        (1.0, -2.0, "`range_sigma` of anchors[1] (`name` 'right') is -2"),
    ],
)
def test_it_is_named_before_the_solve(sigma: float, other: float, words: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # none of NumPy's in front
        with pytest.raises(AraelError) as error:
            tank(sigma, other).solve()
    assert [d.code for d in error.value.diagnostics] == ["E1016"]
    assert words in str(error.value)


def test_rows_on_which_nothing_acts_may_have_any() -> None:
    assert tank(0.0, 0.0, d=-1.0).solve().converged
