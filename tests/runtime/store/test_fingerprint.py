"""Whether flags are what they were, from numbers instead of a copy."""

import numpy as np
import pytest

from arael.runtime.store.compiled import fingerprint_of_flags


def _flags(*columns: str) -> list[np.ndarray]:
    return [np.array([c == "x" for c in column], dtype=bool) for column in columns]


def test_equal_flags_have_equal_numbers() -> None:
    assert fingerprint_of_flags(_flags("x.x", "..x")) == fingerprint_of_flags(_flags("x.x", "..x"))
    assert fingerprint_of_flags([]) == fingerprint_of_flags([])


@pytest.mark.parametrize(
    "other",
    [("x..", "..x"), ("..x", "x.x"), ("x.x.", ".x"), ("x.x", "..x", ""), ("x.x..x",), ()],
    ids=["flag", "column", "length", "empty", "joined", "none"],
)
def test_other_flags_have_other_numbers(other: tuple[str, ...]) -> None:
    assert fingerprint_of_flags(_flags("x.x", "..x")) != fingerprint_of_flags(_flags(*other))


def test_every_single_flag_counts() -> None:
    flags = np.zeros(70, dtype=bool)  # more than two words at a time, and a rest
    seen = {fingerprint_of_flags([flags])}
    for k in range(70):
        flags[:] = False
        flags[k] = True
        seen.add(fingerprint_of_flags([flags]))
    assert len(seen) == 71
