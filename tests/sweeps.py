"""`@pytest.mark.sweep(n, slow=ids)`: the default suite runs a part of the cases of a test.

It runs one in `n` of them, and none of those with the `ids`, which take longest; `-m slow` runs the
others. For tests of one behaviour on many inputs, where a few of them show most faults.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

import pytest


@pytest.hookimpl(tryfirst=True)  # before pytest's own, which selects by marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    met: Counter[str] = Counter()
    for item in items:
        mark = item.get_closest_marker("sweep")
        if mark is None:
            continue
        name, _, case = item.nodeid.rstrip("]").partition("[")
        if _is_slow(met[name], case, *mark.args, **mark.kwargs):
            item.add_marker(pytest.mark.slow)
        met[name] += 1


def _is_slow(number: int, case: str, every: int = 1, *, slow: Collection[str] = ()) -> bool:
    return number % every > 0 or case in slow
