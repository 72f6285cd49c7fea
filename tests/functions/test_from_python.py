"""The functions of a model, called from Python."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.functions import Functions
from tests.functions.models import MODEL, native


@pytest.fixture
def functions(tmp_path: Path) -> Functions:
    path = tmp_path / "fit.arael"
    path.write_text(MODEL.replace("PRECISION", ""))
    found = arael.load(path, functions=native(), interpret=True).functions
    assert isinstance(found, Functions)
    return found


def test_all_functions_are_there(functions: Functions) -> None:
    assert list(functions) == ["sigmoid", "both", "pair", "grow", "si", "co", "arc"]
    with pytest.raises(KeyError):
        functions["none"]


def test_numbers_arrays_and_shapes(functions: Functions) -> None:
    assert functions["sigmoid"](0) == 0.5
    x = np.linspace(-1, 1, 12).reshape(3, 4)
    np.testing.assert_allclose(functions["sigmoid"](x), 1 / (1 + np.exp(-x)), rtol=1e-15)
    np.testing.assert_allclose(functions["arc"](x, 2.0), np.arctan2(x, 2.0), rtol=1e-15)
    pair = functions["pair"](x, np.ones(4))
    assert pair.shape == (3, 4, 2)
    np.testing.assert_allclose(pair[..., 1], x + 0.5)
    np.testing.assert_array_equal(functions["pair"](2.0, 3.0), [6, 3.5])


def test_partials_are_those_of_the_solver(functions: Functions) -> None:
    (slope,) = functions["si"].partials(0.3)
    assert slope == math.cos(0.3)
    (slope,) = functions["sigmoid"].partials(0.0)
    assert slope == pytest.approx(0.25)
    by_x, by_y = functions["pair"].partials(2.0, 3.0)
    np.testing.assert_array_equal(by_x, [3, 1])
    np.testing.assert_array_equal(by_y, [2, 0.5])
    h = 1e-6
    for k, slope in enumerate(functions["arc"].partials(0.4, 1.7)):
        step = h * np.eye(2)[k]
        plus = functions["arc"](*(np.array([0.4, 1.7]) + step))
        minus = functions["arc"](*(np.array([0.4, 1.7]) - step))
        assert slope == pytest.approx((plus - minus) / (2 * h), rel=1e-8)


def test_what_they_say_of_themselves(functions: Functions) -> None:
    grow, si = functions["grow"], functions["si"]
    assert (grow.params, grow.native, grow.formula, grow.derivs) == (
        ("x",), False, "exp(x)", ("grow(x)",),
    )  # fmt: skip
    assert repr(si) == "<extern fn si(x) derivs [co(x)]>"
    with pytest.raises(TypeError, match="takes 1 arguments, found 2"):
        si(1, 2)


def test_without_native_code(tmp_path: Path) -> None:
    path = tmp_path / "fit.arael"
    path.write_text(MODEL.replace("PRECISION", ""))
    functions = arael.load(path, interpret=True).functions
    assert functions["sigmoid"](0) == 0.5
    assert not functions["si"].bound
    with pytest.raises(arael.AraelError) as caught:
        functions["si"](0.5)
    assert caught.value.diagnostics[0].code == "E0820"
