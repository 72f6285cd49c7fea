"""`arael calc`: formulas from arguments, a pipe and a prompt."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Arael


def piped(text: str, *args: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "arael", "calc", *args],
        input=text,
        capture_output=True,
        text=True,
        env={**os.environ, "NO_COLOR": "1"},
        timeout=60,
        check=False,
    )


@pytest.mark.parametrize(
    ("formula", "shown"),
    [
        ("1+2", "3"),
        ("-3 + 2", "-1"),
        ("0.1 + 0.2", "0.3"),
        ("2^10", "1024"),
        ("1/3", "0.333333333333333"),
        ("1e300 * 1e300", "inf"),
        ("sqrt(-1)", "nan"),
        ("diff(x^2, x)", "2 * x"),
        ("diff(x^3, x, 2)", "6 * x"),
        ("diff([x^2, x * y], x)", "[2 * x, y]"),
        ("sin(pi / 2)", "1"),
        ("atan2(1, 1) * 4 - pi", "0"),
        ("2 < 3", "true"),
        ("if 2 < 3 then 10 else 20", "10"),
        ("[1, 2, 3] * 2", "[2, 4, 6]"),
        ("dot([1, 2], [3, 4])", "11"),
        ("identity2() * 3", "[[3, 0], [0, 3]]"),
        ("expand((x + 1)^2)", "x^2 + 2 * x + 1"),
        ("collect(a * x + b * x, x)", "x * (a + b)"),
        ("simplify(sin(x)^2 + cos(x)^2)", "1"),
        ("subs(x^2 + y, x, 3)", "y + 9"),
        ("jacobian([x * y, x], [x, y])", "[[y, x], [1, 0]]"),
        ("latex(x / 2)", "\\frac{x}{2}"),
        ("python(x^2)", "x**2"),
        ("c(sin(x))", "sin(x)"),
        ("x = 3; x^2", "9"),
        ("x = 3; diff(x^2 * y, x)", "6 * y"),
        ("y = x^2; x = 3; diff(y, x); y", "6\n9"),
        ("f(x) = x^2 + k; k = 5; f(2)", "9"),
        ("f(a, b) = a - b; f(b, a)", "b - a"),
        ("sin(x) = x; sin(2)", "2"),
        ("f(e) = e; f(1)", "1"),
        ("x = 2; f(x) = x^2; f(3) + x", "11"),
        ("g(x) = diff2(x); diff2(x) = x; g(4)", "4"),
        ("v = [1, 2, 3]; v.x + v[2]", "4"),
        ("2 + 3; ans * 2", "5\n10"),
        ("x = 1; x = x + 1; x", "2"),
        ("[1,\n 2]; 3 # a comment", "[1, 2]\n3"),
        ("", ""),
        ("# nothing", ""),
    ],
)
def test_results(arael: Arael, formula: str, shown: str) -> None:
    outcome = arael("calc", formula)
    assert (outcome.out.rstrip("\n"), outcome.err, outcome.code) == (shown, "", 0)


def test_several_formulas_share_variables(arael: Arael) -> None:
    outcome = arael("calc", "a = 2", "a^3", "-a")
    assert outcome.out == "8\n-2\n"


def test_digits(arael: Arael) -> None:
    assert arael("calc", "--digits", "4", "pi").out == "3.142\n"
    assert arael("calc", "--digits", "17", "0.1").out == "0.10000000000000001\n"
    assert arael("calc", "--digits", "40", "pi").code == 2


def test_from_a_pipe() -> None:
    done = piped("diff(x^2, x)\n")
    assert (done.stdout, done.stderr, done.returncode) == ("2 * x\n", "", 0)


def test_a_pipe_goes_on_after_an_error() -> None:
    done = piped("x = 4\nsqrt(x\n1 + 1\nquit\n5\n")
    assert done.stdout == "2\n"
    assert done.returncode == 2
    assert "error[E0120]" in done.stderr
    assert "--> <stdin>:2:5" in done.stderr


@pytest.mark.parametrize(
    ("formula", "code", "place"),
    [
        ("1 +", "E0138", "formula:1:3"),
        ("x = 2; foo(x)", "E0205", "formula:1:8"),
        ("x = 2; y = [1] * [2]", "E0301", "formula:1:12"),
        ("f(x, x) = x", "E0651", "formula:1:6"),
        ("a = 1; f(x) = x +", "E0138", "formula:1:17"),
        ("q = q + 1", "E0655", "formula:1:1"),
        ("norm = 3", "E0655", "formula:1:1"),
        ("s = latex(x)", "E0655", "formula:1:1"),
        ("diff(x^2, 3)", "E0652", "formula:1:11"),
        ("diff(x^2)", "E0303", "formula:1:1"),
        ("diff(x, x, 0.5)", "E0652", "formula:1:12"),
        ("diff(x, x, -1)", "E0652", ""),
        ("subs(x, x)", "E0303", "formula:1:1"),
        ("expand((a + b + c)^500)", "E0653", ""),
        ("x == ", "E0138", "formula:1:3"),
        ("1 = 2", "E01", "formula:1:3"),
        ('__import__("os")', "E0205", "formula:1:1"),
    ],
)
def test_errors_are_diagnostics(arael: Arael, formula: str, code: str, place: str) -> None:
    outcome = arael("calc", formula)
    assert outcome.code == 2
    assert outcome.out == ""
    assert f"error[{code}" in outcome.err
    assert place in outcome.err
    assert "Traceback" not in outcome.err


def test_json(arael: Arael) -> None:
    outcome = arael("calc", "--json", "1 + 1; diff(x^2, x)", "1 +")
    first, second, third = map(json.loads, outcome.out.splitlines())
    assert first == {"status": "ok", "result": "2"}
    assert second["result"] == "2 * x"
    assert third["status"] == "error"
    assert third["diagnostics"][0]["code"] == "E0138"
    assert outcome.code == 2


def test_what_is_defined_is_listed() -> None:
    done = piped("x = 2\nf(a) = a^2\nvars\nfunctions\nhelp\n")
    assert "x = 2\nfn f(a) = a^2\n" in done.stdout
    assert "diff(x^2 * y, x)" in done.stdout


def test_hostile_lines_end_soon() -> None:
    lines = [
        "(" * 10_000,
        "9^9^9^9",
        "x = 1 + x",
        *["y = y0 * y0 + y0" if i == 0 else f"y{i} = sin(y{i - 1}) * y{i - 1}" for i in range(60)],
        "y59",
        "diff(y59, y0)",
        "simplify((2 * x)^1000000000)",
        "1" * 100_000,
        "\x1b[31m",
        "f(x) = f(x); f(1)",
    ]
    done = piped("\n".join(lines) + "\n")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "internal error" not in done.stderr
    assert "\x1b" not in done.stderr


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_prompt_with_history(
    arael: Arael, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    history = tmp_path / "deep" / "history"
    monkeypatch.setenv("ARAEL_HISTORY", str(history))
    monkeypatch.setattr(sys, "stdin", Terminal("x = 5\nx * 2\n1 +\nquit\n"))
    outcome = arael("calc")
    assert outcome.out.replace("> ", "").split() == ["10"]
    assert "E0138" in outcome.err
    assert outcome.code == 0
    assert history.exists()
    assert history.stat().st_mode & 0o077 == 0


def test_history_is_kept_in_the_users_data_directory(monkeypatch: pytest.MonkeyPatch) -> None:
    from platformdirs import user_data_path

    from arael.cli.line_editing import history_file

    monkeypatch.delenv("ARAEL_HISTORY", raising=False)
    assert history_file().parent == user_data_path("arael", appauthor=False)


def test_help_lists_it(arael: Arael) -> None:
    assert "calc" in arael("--help").out
    assert "diff(x^2, x)" in arael("calc", "--help").out


def test_standard_input_that_is_closed_is_empty(
    arael: Arael, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    assert arael("calc").code == 0
    assert arael("calc", "1 + 1").out.strip() == "2"
