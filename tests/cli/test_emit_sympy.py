"""`arael emit --stage sympy`: what is printed is what the derivatives are."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from tests.cli.conftest import Arael

MODEL = """
root Bend {
    param a: real
    param b: real
    constraint both { [sin(a * b) * exp(a), safe_sqrt(a - b) / (a * a + b)] }
}
"""
ROOT = Path(__file__).parents[2]
NAMES = {"sin": math.sin, "cos": math.cos, "exp": math.exp, "sqrt": math.sqrt}
NAMES |= {
    "max": max,
    "maximum": max,
    "lt": lambda a, b: float(a < b),
    "select": lambda c, a, b: a if c else b,
}


@pytest.fixture
def bend(tmp_path: Path) -> Path:
    path = tmp_path / "bend.arael"
    path.write_text(MODEL)
    return path


def printed(text: str, a: float, b: float) -> dict[str, float]:
    """Evaluate the printed lines in order, as Python."""
    known: dict[str, float] = {"a": a, "b": b}
    waiting = re.findall(r"^    (.+?) = (.+)$", text, re.MULTILINE)
    while waiting:
        left = []
        for name, formula in waiting:
            try:
                known[name] = eval(formula, {"__builtins__": {}}, {**NAMES, **known})
            except NameError:  # shared subexpressions may use sums that are printed below them
                left.append((name, formula))
        assert len(left) < len(waiting), left
        waiting = left
    return known


def test_the_printed_derivatives_are_those_of_the_printed_residuals(
    arael: Arael, bend: Path
) -> None:
    text = arael("emit", str(bend), "--stage", "sympy").out
    at, step = (0.9, 0.4), 1e-6
    found = printed(text, *at)
    assert found["r0"] == pytest.approx(math.sin(0.36) * math.exp(0.9), rel=1e-14)
    for k, name in enumerate("ab"):
        up = printed(text, at[0] + step * (k == 0), at[1] + step * (k == 1))
        down = printed(text, at[0] - step * (k == 0), at[1] - step * (k == 1))
        for r in ("r0", "r1"):
            slope = (up[r] - down[r]) / (2 * step)
            assert found[f"d {r} / d {name}"] == pytest.approx(slope, rel=1e-7)


def test_operations_before_and_after_are_counted(arael: Arael, bend: Path) -> None:
    text = arael("emit", str(bend), "--stage", "sympy").out
    counts = re.search(r"2 residuals, 4 derivatives, (\d+) operations before and (\d+) after", text)
    assert counts is not None
    assert int(counts[1]) > int(counts[2]) > 10


def test_one_constraint_in_latex(arael: Arael) -> None:
    text = arael("emit", "slam", "--stage", "sympy", "--constraint", "Pose.gps", "--latex").out
    assert text.count("constraint ") == 1
    assert r"\frac{\partial r_{0}}{\partial \mathrm{pos.x}} = " in text
    assert r"\mathrm{info.gps.cov\_isigma}_{0}" in text


def test_an_unknown_constraint_is_named_with_the_nearest(arael: Arael) -> None:
    done = arael("emit", "slam", "--stage", "sympy", "--constraint", "Pose.gpx")
    assert done.code == 2
    assert "the model has no constraint 'Pose.gpx'; did you mean 'Pose.gps'?" in done.err


@pytest.mark.parametrize("option", [["--constraint", "Pose.gps"], ["--latex"]])
def test_its_options_belong_to_the_stage(arael: Arael, option: list[str]) -> None:
    done = arael("emit", "slam", *option)
    assert done.code == 2
    assert f"{option[0]} needs --stage sympy, found --stage pyx" in done.err


ALL = sorted(path for folder in ("models", "examples") for path in (ROOT / folder).rglob("*.arael"))


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_every_model_is_printed_in_order_of_evaluation(arael: Arael, path: Path) -> None:
    """Each value, shared subexpression and sum is printed before the lines that read it."""
    found = arael("emit", str(path), "--stage", "sympy")
    if "has no root" in found.err or "E0107" in found.err:  # a file that others import
        return
    assert found.code == 0, found.err
    known: set[str] = set()
    for line in found.out.splitlines():
        if line.startswith("constraint "):
            known = set()
        if not line.startswith("    "):
            continue
        name, _, term = line.strip().partition(" = ")
        read = set(re.findall(r"(?<![\w.])[txw]\d+(?![\w.\[])", term))
        assert read <= known, line
        known.add(name)


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_prepared_data_is_named_with_both_operands(arael: Arael, path: Path) -> None:
    """`mul of root.h[0]` has lost one: of two operands, both are named."""
    found = arael("emit", str(path), "--stage", "ir")
    if found.code != 0:
        assert "E0107" in found.err or "has no root" in found.err, found.err
        return
    lines = re.findall(r"^  t\d+ = (add|sub|mul|div) of (.+)$", found.out, re.MULTILINE)
    lines = [(op, name) for op, name in lines if op != "div"]  # a constant is left out
    short = [(op, name) for op, name in lines if len(name) < 40 and "..." not in name]
    for op, name in short:  # a square names its one operand
        assert op == "mul" or " and " in name or "(" in name or ", " in name, name
