"""Arrays whose memory C code reads and writes are checked before it does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.levenberg.compiled import RECORD
from arael.runtime.records import check_record, probe_of


@pytest.fixture
def evaluation() -> Any:
    fit = arael.runtime_residual("a * x - 2", parameters={"a": 0.5}, data={"x": np.arange(5.0)})
    return arael.runtime_model(fit)._problem().evaluation


def test_arrays_of_another_type_are_refused(evaluation: Any) -> None:
    gradient, values = evaluation.workspace()
    with pytest.raises(TypeError, match=r"float64.*found float32"):
        evaluation.linearised((gradient.astype(np.float32), values))
    with pytest.raises(TypeError, match=r"float64.*found int64"):
        evaluation.linearised((gradient, values.astype(np.int64)))


def test_arrays_that_are_too_short_are_refused(evaluation: Any) -> None:
    gradient, values = evaluation.workspace()
    with pytest.raises(ValueError, match=f"at least {len(values)} scalars, found 0"):
        evaluation.linearised((gradient, values[:0]))


def test_arrays_with_gaps_and_read_only_ones_are_refused(evaluation: Any) -> None:
    gradient, values = evaluation.workspace()
    gaps = np.zeros(2 * len(gradient) + 2)[::2]
    with pytest.raises(ValueError, match="contiguous in C order"):
        evaluation.linearised((gaps, values))
    gradient.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        evaluation.linearised((gradient, values))


def test_arrays_that_fit_are_used_in_place(evaluation: Any) -> None:
    gradient, values = evaluation.workspace()
    _, found, _ = evaluation.linearised((gradient, values))
    assert found.base is gradient
    assert found[0] != 0


@pytest.mark.parametrize(
    "change",
    [
        lambda found: found.pop("cost"),
        lambda found: found.update(cost=found["trial_cost"]),
        lambda found: found.update(extra=99),
    ],
)
def test_a_struct_that_does_not_match_its_records_is_refused(change: Any) -> None:
    probe = probe_of(RECORD)
    found = {name: probe[name][0] for name in RECORD.names or ()}
    check_record("Record", RECORD, found, RECORD.itemsize)
    with pytest.raises(TypeError, match="Record"):
        check_record("Record", RECORD, found, RECORD.itemsize + 8)
    change(found)
    with pytest.raises(TypeError, match="does not match its records"):
        check_record("Record", RECORD, found, RECORD.itemsize)
