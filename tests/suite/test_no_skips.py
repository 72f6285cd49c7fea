"""The option `--no-skips`, and the summary of what is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

TESTS = """
import pytest

def test_passes(): pass

@pytest.mark.skipif(True, reason="needs a part: apt install part")
def test_marked(): pass

def test_inside(): pytest.importorskip("no_such_module", reason="needs another: pip install x")

@pytest.mark.xfail(reason="known")
def test_expected_failure(): assert False
"""


@pytest.fixture
def suite(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder of tests that skip, with the plugin of this suite."""
    monkeypatch.syspath_prepend(str(ROOT))
    pytester.makeconftest('pytest_plugins = ["tests.no_skips"]')
    pytester.makepyfile(TESTS)
    return pytester


def test_skips_remain_skips_by_default(suite: pytest.Pytester) -> None:
    result = suite.runpytest_inprocess("-p", "no:xdist", "-q")
    result.assert_outcomes(passed=1, skipped=2, xfailed=1)
    result.stdout.fnmatch_lines(["1 skipped, needs a part: apt install part"])


def test_skips_fail_with_the_option(suite: pytest.Pytester) -> None:
    result = suite.runpytest_inprocess("-p", "no:xdist", "--no-skips")
    result.assert_outcomes(passed=1, failed=1, errors=1, xfailed=1)
    result.stdout.fnmatch_lines(
        ["*test_marked: --no-skips forbids this skip: *needs a part: apt install part"]
    )


def test_a_skipped_module_is_an_error_with_the_option(suite: pytest.Pytester) -> None:
    suite.makepyfile(test_module='import pytest\npytest.importorskip("no_such_module")\n')
    result = suite.runpytest_inprocess("-p", "no:xdist", "--no-skips", "test_module.py")
    result.assert_outcomes(errors=1)
    assert result.ret != 0
