"""Did you mean ...?"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arael.diagnostics.suggest import closest


@pytest.mark.parametrize(
    ("name", "candidates", "expected"),
    [
        ("pos_", ["pos", "ea"], ["pos"]),
        ("Pose", ["poses", "pose"], ["pose"]),
        ("fine_isigma", ["frine_isigma", "isigma"], ["frine_isigma"]),
        ("sqr", ["sqrt", "sin"], ["sqrt"]),
        ("atna2", ["atan2", "tan"], ["atan2"]),
        ("rotationMatrix", ["rotation_matrix"], ["rotation_matrix"]),
        ("x", ["y", "z"], []),
        ("gamma", ["sigma"], []),
        ("landmark", ["poses"], []),
        ("pos", ["pos"], []),
        ("", ["a"], []),
        ("a" * 5000, ["a"], []),
    ],
)
def test_closest(name: str, candidates: list[str], expected: list[str]) -> None:
    assert closest(name, candidates) == expected


def test_limit_and_order() -> None:
    assert closest("posx", ["posy", "posz", "pose"], limit=2) == ["posy", "posz"]


@given(st.text("abc_", max_size=8), st.lists(st.text("abc_", max_size=8)), st.integers(0, 3))
def test_results_are_other_candidates(name: str, candidates: list[str], limit: int) -> None:
    found = closest(name, candidates, limit)
    assert len(found) <= limit
    assert set(found) <= set(candidates) - {name}


@given(st.text("abcdef", min_size=4, max_size=10), st.integers(0, 9), st.sampled_from("xyz"))
def test_one_wrong_letter_is_found(name: str, at: int, letter: str) -> None:
    at %= len(name)
    wrong = name[:at] + letter + name[at + 1 :]
    assert closest(wrong, ["something_else", name]) == [name]
