"""Marks that shorten sweeps in the default suite."""

from __future__ import annotations

import pytest

CASES = """
import pytest

@pytest.mark.sweep(3)
@pytest.mark.parametrize("k", range(7))
def test_many(k):
    pass

@pytest.mark.sweep(slow=("long one", "b"))
@pytest.mark.parametrize("k", [1, 2, 3], ids=["a", "long one", "b"])
def test_named(k):
    pass

def test_plain():
    pass
"""
INI = "[pytest]\nmarkers =\n    slow\n    sweep(n, slow=ids)\n"


def test_the_default_suite_has_a_part_of_a_sweep_and_both_together_all(
    pytester: pytest.Pytester,
) -> None:
    pytester.makepyfile(CASES)
    pytester.makeini(INI)
    for selected, passed in (("not slow", 3 + 1 + 1), ("slow", 4 + 2), ("", 11)):
        found = pytester.inline_run("-p", "tests.sweeps", "-p", "no:xdist", "-m", selected)
        found.assertoutcome(passed=passed)
