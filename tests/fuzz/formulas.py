"""A formula's text: calculated, differentiated, printed, fitted."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np

import arael
from arael import sym
from arael.calculator.calculator import Calculator
from arael.diagnostics.records import AraelError
from arael.syntax.fmt import format_source  # noqa: F401 - imported before memory is limited
from tests.fuzz.corpus import STATEMENTS
from tests.fuzz.models import numbers
from tests.fuzz.verdict import unusable


def warm_up(folder: Path) -> None:
    """Import what the stages import, so that it is not counted as an input's memory."""
    for seed in range(20):
        examine(b"a * x^2 + sqrt(b^2 + 1)", "formula.txt", random.Random(seed), folder)


def examine(content: bytes, name: str, rng: random.Random, folder: Path) -> str:
    """Run all stages on a formula, up to the first error."""
    text = content.decode("utf-8", "surrogateescape")
    outcomes = [_calculated(text, rng), _fitted(text, rng)]
    values = {name: rng.gauss(0, 2) for name in "abcxy"}
    formula = sym.parse(text)
    free = sym.free_vars(formula)
    at = {name: values.get(name, 0.5) for name in free}
    outcomes.append("evaluated")
    sym.eval(formula, at)
    for variable in free[:2]:
        sym.eval(sym.diff(formula, variable), at)
    return " ".join(outcomes)


def _calculated(text: str, rng: random.Random) -> str:
    try:
        answers = list(Calculator().run(rng.choice(STATEMENTS).replace("{}", text)))
    except AraelError as error:
        _check(error)
        return "refused"
    assert all(len(answer.text) < 200_000 for answer in answers), "an answer of unbounded length"
    return "calculated"


def _fitted(text: str, rng: random.Random) -> str:
    x = np.array([rng.gauss(0, 1) for _ in range(5)])
    names = ["a", "b", "c"]
    try:
        residual = arael.runtime_residual(
            text,
            parameters=dict.fromkeys(names, rng.choice([1.0, 0.0, -2.5])),
            data={"x": x, "y": x + 1},
        )
        model = arael.runtime_model(residual)
        return numbers(model)
    except AraelError as error:
        _check(error)
        return "unfitted"


def _check(error: AraelError) -> None:
    why = unusable(error)
    assert not why, why
