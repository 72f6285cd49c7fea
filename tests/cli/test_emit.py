"""`arael emit --stage sympy|ir`: what is printed is what the derivatives are."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from arael.operations import OPERATIONS
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


def sections(text: str) -> Iterator[list[tuple[str, str]]]:
    """Names and terms of each section of `--stage ir` that has temporaries of its own."""
    found: list[tuple[str, str]] = []
    for line in text.splitlines():
        name, equals, term = line.strip().partition(" = ")
        if equals and line.startswith("  ") and not line.strip().startswith(("when", "loss")):
            found.append((name, term))
        elif found:
            yield found
            found = []
    yield found


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_every_program_is_printed_whole_and_in_order_of_evaluation(
    arael: Arael, path: Path
) -> None:
    """Each operation has all its operands, and each is printed before: data is prepared first."""
    found = arael("emit", str(path), "--stage", "ir")
    if "has no root" in found.err or "E0107" in found.err:
        return
    assert found.code == 0, found.err
    for constraint in found.out.split("\nconstraint "):
        check_order(constraint)


def check_order(constraint: str) -> None:
    prepared: set[str] = set()
    for section in sections(constraint):
        known: set[str] = set()
        for name, term in section:
            head, *operands = term.split(" ")
            if head in OPERATIONS:
                assert len(operands) == OPERATIONS[head].arity, term
            elif not head.startswith("extern:"):
                assert not operands or " of " in term or term.startswith("sum "), term
            read = set(re.findall(r"(?<![\w.])[tp]\d+(?:_\d+)?(?![\w.\[])", term))
            assert read <= known | prepared, (name, term)
            known.add(name)
            prepared |= {name} if name.startswith("p") else set()


SUMS = """
struct Mark {
    w: real
    param x: real
}
root Line {
    param a: real
    h: real
    k: real
    marks: list of Mark
    constraint one when a > 0 {
        a * (1.0 / h) - sum(m in self.marks) { m.x / (1 + m.w * m.w) + h / sin(h * k + exp(k) * 2) }
    }
}
"""


def evaluated(lines: list[tuple[str, str]], known: dict[str, float]) -> dict[str, float]:
    """Values of the lines of a program by the operations of the table."""
    known = dict(known)
    for name, term in lines:
        head, *operands = term.split(" ")
        if head in OPERATIONS and operands:
            values = [known[x] if x in known else float(x) for x in operands]
            known[name] = float(OPERATIONS[head].numpy(*values))
        else:
            known[name] = known[term] if term in known else float(term)
    return known


def test_printed_programs_with_sums_and_a_guard_give_the_residual(
    arael: Arael, tmp_path: Path
) -> None:
    path = tmp_path / "line.arael"
    path.write_text(SUMS)
    text = arael("emit", str(path), "--stage", "ir").out.partition("  where lists have rows")[2]
    own, of_row, term, guard, residual = sections(text)
    h, k, a, rows = 0.7, 0.3, 1.5, [(2.0, 0.4), (-1.0, 3.0)]
    known = evaluated(own, {"h[0]": h, "k[0]": k})
    total = 0.0
    for w, x in rows:
        here = evaluated(of_row, {**known, "marks.w[0]": w})
        here = evaluated(term, {**here, "marks.state[0] of Mark": x})
        assert here["d v0 / d marks.x"] == pytest.approx(1 / (1 + w * w))
        total += here["v0"]
    known = evaluated(guard, {**known, "state[0] of Line": a})
    known = evaluated(residual, {**known, "sum1[0]": total})
    fixed = h / math.sin(h * k + math.exp(k) * 2)
    expected = a / h - sum(x / (1 + w * w) + fixed for w, x in rows)
    assert known["r0"] == pytest.approx(expected)
    assert (known["d r0 / d a"], known["d r0 / d sum1[0]"]) == pytest.approx((1 / h, -1))


def test_printed_formulas_with_sums_and_a_guard_are_whole(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "line.arael"
    path.write_text(SUMS)
    text = arael("emit", str(path), "--stage", "sympy").out
    assert "  when a > 0\n  term of sum1, over marks\n" in text
    inputs = {"h[0]": "h", "k[0]": "k", "marks.w[0]": "w", "marks.x": "x", "sum1[0]": "s"}
    known = {"h": 0.7, "k": 0.3, "a": 1.5, "w": 2.0, "x": 0.4, "s": 3.0}
    for line in re.findall(r"^    (.+)$", text, re.MULTILINE):
        for name, short in inputs.items():
            line = line.replace(name, short)
        name, _, formula = line.partition(" = ")
        known[name] = eval(formula, {"__builtins__": {}}, {**NAMES, **known})
    fixed = 0.7 / math.sin(0.7 * 0.3 + math.exp(0.3) * 2)
    assert known["v0"] == pytest.approx(0.4 / 5 + fixed)
    assert known["d v0 / d x"] == pytest.approx(0.2)
    assert known["guard"] == 1 and known["r0"] == pytest.approx(1.5 / 0.7 - 3)
