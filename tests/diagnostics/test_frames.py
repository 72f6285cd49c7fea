"""Tracebacks of errors that a user can cause: the user's frames and that of the public function."""

from __future__ import annotations

import subprocess
import sys
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct P { x: real }
root M {
    param a: real = 0
    b: real = 1
    ps: list of P
    constraint c { a - b }
}
"""


def model() -> Any:
    return arael.loads(TEXT, interpret=True)()


MISTAKES: dict[str, Callable[[], object]] = {
    "loads": lambda: arael.loads("root M { param a: rael }"),
    "load": lambda: arael.load("no_such_file.arael"),
    "construct": lambda: arael.loads(TEXT, interpret=True)(c=3),
    "solve": lambda: model().solve(solver="foo"),
    "setting": lambda: model().solve(max_iterations=3),
    "append": lambda: model().ps.append(x="a"),
    "extend": lambda: model().ps.extend(y=[1.0]),
    "set": lambda: setattr(model(), "b", "x"),
    "get": lambda: model().bb,
    "read": lambda: model().read("no_such_file.json"),
    "fit": lambda: arael.fit("y = a * x", {"x": [1.0, 2.0]}),
    "profile": lambda: model().profile("zz"),
    "marginal": lambda: model().covariance().marginal("zz"),
    "residuals": lambda: model().residuals.add("a - "),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_one_frame_of_arael_stays(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARAEL_DEBUG", raising=False)
    with pytest.raises(AraelError) as caught:
        MISTAKES[name]()
    frames = traceback.extract_tb(caught.value.__traceback__)
    # this test, the lambda, the public function
    assert [frame.filename == __file__ for frame in frames] == [True, True, False]
    assert caught.value.diagnostics[0].code in str(caught.value).splitlines()[0]


def test_all_frames_are_there_to_find_a_defect(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARAEL_DEBUG", "1")
    with pytest.raises(AraelError) as caught:
        MISTAKES["append"]()
    assert len(traceback.extract_tb(caught.value.__traceback__)) > 4


def test_frames_of_functions_of_the_user_stay() -> None:
    def observe(record: Any) -> None:
        model().ps.append(x="a")

    with pytest.raises(Exception) as caught:
        model().solve(observer=observe)
    error: BaseException | None = caught.value
    names: list[str] = []
    while error is not None:
        names += [frame.name for frame in traceback.extract_tb(error.__traceback__)]
        error = error.__cause__
    assert "observe" in names


def test_other_errors_have_all_frames() -> None:
    with pytest.raises(IndexError) as caught:
        model().ps[5]
    assert "__getitem__" in [f.name for f in traceback.extract_tb(caught.value.__traceback__)]


def test_in_a_plain_interpreter(tmp_path: Any) -> None:
    script = tmp_path / "script.py"
    script.write_text("import arael\narael.loads('root M { param a: rael }')\n")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.count('  File "') == 2
    assert "error[E0203]: unknown type `rael`" in done.stderr


def test_wrapped_functions_keep_names_and_documentation() -> None:
    assert arael.fit.__name__ == "fit" and "formula" in (arael.fit.__doc__ or "")
    x = np.array([0.0, 1.0, 2.0])
    assert arael.fit("y = a * x", {"x": x, "y": 2 * x}).parameters["a"] == pytest.approx(2)
