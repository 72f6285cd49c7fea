"""The options `--fuzz-seed` and `--fuzz-seconds`."""

from __future__ import annotations

from pathlib import Path

import pytest

CONFTEST = (Path(__file__).parents[1] / "conftest.py").read_text(encoding="utf-8")

TESTS = """
from hypothesis import given, strategies as st

drawn = []

@given(st.integers())
def test_draws(number): drawn.append(number)

def test_prints(fuzz_seed, fuzz_budget):
    print(f"<{fuzz_seed} {fuzz_budget:g} {hash(tuple(drawn))}>")
"""


@pytest.fixture
def suite(pytester: pytest.Pytester) -> pytest.Pytester:
    """A test that prints the seed, the time and a hash of what hypothesis drew."""
    pytester.makeconftest(
        CONFTEST.replace('"tests.isolation", "tests.no_skips", "tests.sweeps"', "")
    )
    pytester.makepyfile(TESTS)
    return pytester


def run(suite: pytest.Pytester, *options: str) -> tuple[list[str], str]:
    """What the test printed, and all that pytest printed."""
    result = suite.runpytest_subprocess("-q", "-s", "-p", "no:xdist", *options)
    result.assert_outcomes(passed=2)
    text = result.stdout.str()
    return text.split("<")[1].split(">")[0].split(), text


@pytest.mark.slow
def test_runs_are_the_same_unless_a_seed_is_drawn_and_that_repeats(
    suite: pytest.Pytester,
) -> None:
    fixed, text = run(suite)
    assert fixed[:2] == ["0", "5"]
    assert "fuzz seed" not in text
    assert run(suite)[0] == fixed
    drawn, text = run(suite, "--fuzz-seed", "random", "--fuzz-seconds", "1")
    seed, seconds, inputs = drawn
    assert seed != "0"
    assert seconds == "1"
    assert inputs != fixed[2]
    assert f"fuzz seed {seed}: repeat with --fuzz-seed {seed} --fuzz-seconds 1" in text
    assert run(suite, "--fuzz-seed", seed, "--fuzz-seconds", "1")[0] == drawn
