"""Tapes put together from others."""

from __future__ import annotations

import numpy as np

from arael.runtime.machine.programs import evaluate
from arael.runtime.machine.tape import Tape
from arael.runtime.machine.writer import TapeWriter

SQUARE_PLUS_TWO = Tape(
    ops=("input", "mul", "const", "add"),
    args=((0,), (0, 0), (0,), (1, 2)),
    constants=(2.0,),
    outputs=(3,),
    places=(-1, 4, -1, 5),
)


def test_a_tape_is_added_for_several_inputs() -> None:
    writer = TapeWriter()
    (first,) = writer.add(SQUARE_PLUS_TWO, [writer.input(0)])
    (second,) = writer.add(SQUARE_PLUS_TWO, [writer.input(1)])
    found = writer.tape([writer.op("add", first, second), first])
    values = evaluate(found, [np.array([1.0, 2.0]), np.array([3.0, 4.0])])
    np.testing.assert_array_equal(values, [[14, 24], [3, 6]])
    assert sorted(set(found.places)) == [-1, 4, 5]


def test_equal_operations_are_one_and_what_is_not_needed_is_left_out() -> None:
    writer = TapeWriter()
    (first,) = writer.add(SQUARE_PLUS_TWO, [writer.input(0)])
    (same,) = writer.add(SQUARE_PLUS_TWO, [writer.input(0)])
    writer.op("sin", first)
    assert same == first
    assert writer.tape([first]).operations == 2
