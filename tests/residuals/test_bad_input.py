"""Invalid or malicious runtime residuals: bounded work, and a diagnostic for each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

WIDE = {f"p{k}": [0.1] * 64 for k in range(56)}

HOSTILE = {
    "too long": ("a + " * 6000 + "a", "E0104"),
    "brackets": ("(" * 9000 + "a" + ")" * 9000, "E0105"),
    "signs": ("-" * 19_000 + "a", "E0105"),
    "wide": ("+".join(f"norm2(p{k})" for k in range(56)), "E0620"),
    "huge index": ("p0[99999999999999999999]", "E0305"),
    "huge number": ("1e99999999 * a", "E0111"),
    "long number": ("9" * 5000 + " * a", "E0106"),
    "long name": ("a" * 5000, "E0106"),
    "control character": ("a\x00", "E0110"),
    "direction override": ("a + \u202e b", "E0110"),
    "import": ('import "/etc/passwd"', "E0123"),
    "unknown name": ("a + b", "E0201"),
    "unknown function": ("system(a)", "E0205"),
    "dunder": ("a.__class__", "E0204"),
}


@pytest.mark.sweep(slow=("wide",))
@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_texts_are_refused_by_name(case: str) -> None:
    text, code = HOSTILE[case]
    model = arael.runtime_model()
    with pytest.raises(AraelError) as caught:
        model.residuals.add(text, label="bad", parameters={"a": 1, **WIDE})
    assert code in {d.code for d in caught.value.diagnostics}
    assert not model.residuals
    model.residuals.add("a - 1", label="good", parameters={"a": 0})
    model.solve()
    assert model.residuals.parameters["a"] == pytest.approx(1)


@pytest.mark.sweep(3)
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("+".join(["sin(a)"] * 2400), 2400 * np.sin(0.1)),
        ("*".join(["(a + 1)"] * 200), 1.1**200),
        ("(((a^a)^a)^a)" + "*a^a" * 500, 0.1 ** (0.001 + 50)),
    ],
    ids=["sum", "product", "powers"],
)
def test_long_chains_are_evaluated(text: str, value: float) -> None:
    model = arael.runtime_model()
    model.residuals.add(text, label="long", parameters={"a": 0.1})
    assert model.cost() == pytest.approx(value**2, rel=1e-9)


@pytest.mark.parametrize("nested", ["exp({})", "atan2(a, {})", "if a > 0 then {} else 1", "a^({})"])
def test_deep_but_allowed_texts_are_evaluated(nested: str) -> None:
    text = "a"
    for _ in range(40):
        text = nested.format(text)
    model = arael.runtime_model()
    model.residuals.add(f"[{text}, a]", label="deep", parameters={"a": 0.1})
    assert model._problem().evaluation.group_rows(0)[0].shape == (1, 2)


def test_expressions_that_double_each_other_are_bounded() -> None:
    """Each is read once, however often it is named; the height of what they make is bounded."""
    model = arael.runtime_model()
    model.residuals.define("d0", "x", data={"x": 0.1})
    for k in range(1, 25):
        model.residuals.define(f"d{k}", f"d{k - 1} * d{k - 1} / 2 + sin(d{k - 1})")
    model.residuals.add("a * d24", label="all", parameters={"a": 1})
    x = 0.1
    for _ in range(24):
        x = x * x / 2 + np.sin(x)
    assert model.cost() == pytest.approx(x * x, rel=1e-9)
    with pytest.raises(AraelError) as caught:
        for k in range(25, 400):
            model.residuals.define(f"d{k}", f"d{k - 1} * d{k - 1}")
        model.residuals.add("a * d399", label="more", parameters={"b": 1})
    assert caught.value.diagnostics[0].code in ("E0607", "E0764")
    assert list(model.residuals) == ["all"]


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"data": {"x": [1, 2, 3], "y": [1, 2]}}, "E0762"),
        ({"data": {"x": "abc", "y": 1}}, "E0762"),
        ({"data": {"x": [[1, 2], [3]], "y": 1}}, "E0762"),
        ({"data": {"x": np.zeros((2, 2, 2)), "y": 1}}, "E0762"),
        ({"data": {"x": [1, 2j], "y": 1}}, "E0762"),
        ({"data": {"x": {}, "y": 1}}, "E0762"),
        ({"data": {"x y": 1}}, "E0760"),
        ({"data": [1, 2]}, "E0760"),
        ({"parameters": 5}, "E0760"),
        ({"entities": "a"}, "E0760"),
        ({"entities": {"x": 3}, "data": {"y": 1}}, "E0762"),
        ({"parameters": {"a": float("nan")}}, "E0761"),
        ({"parameters": {"a": None}}, "E0761"),
        ({"parameters": {"a": [1] * 65}}, "E0761"),
        ({"parameters": {"a": {"value": 1, "lo": 2}}}, "E0761"),
        ({"parameters": {3: 1}}, "E0760"),
        ({"parameters": {"sin": 1}}, "E0760"),
        ({"loss": 3}, "E0760"),
        ({"loss": "cauchy(" * 3000}, "E0104"),
        ({"label": "a b"}, "E0760"),
    ],
)
def test_values_that_do_not_fit_are_told(given: dict[str, Any], code: str) -> None:
    model = arael.runtime_model()
    whole = {"label": "bad", "parameters": {"a": 1}, "data": {"x": 1, "y": 1}, **given}
    with pytest.raises(AraelError) as caught:
        model.residuals.add("a * x - y", **whole)
    assert caught.value.diagnostics[0].code == code
    assert not model.residuals
    assert model.parameter_names() == []


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("compiled", [False, True])
def test_data_that_is_not_finite_is_found_by_row_and_name(value: float, compiled: bool) -> None:
    model = arael.runtime_model()
    fit = model.residuals.add(
        "a * x - y", label="fit", parameters={"a": 1}, data={"x": [1, 2, 3, 4], "y": 1}
    )
    if compiled:
        fit.compile()
    model.solve()
    fit.set_data(x=[1, 2, value, 4])
    with pytest.raises(AraelError) as caught:
        model.solve()
    (found,) = caught.value.diagnostics
    assert found.code == "E1001"
    assert "`fit[2]`" in found.message
    assert any(f"`fit[2].x` is {value:g}" in note for note in found.notes)
    fit.set_data(x=[1, 1, 1, 1])
    model.solve()
    assert fit.parameters["a"] == pytest.approx(1)
