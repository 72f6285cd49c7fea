"""arael logs nothing without a handler."""

from __future__ import annotations

import io
import logging
import subprocess
import sys

import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.solving import solve
from tests.runtime import toys
from tests.test_solving import COARSE, line, model_of

ROOT = logging.getLogger("arael")


def rosenbrock():
    layout = toys.rosenbrock()
    return model_of(layout, toys.at(layout, -1.2, 1.0))


def test_nothing_is_printed_unless_asked(capfd: pytest.CaptureFixture[str]) -> None:
    solve(rosenbrock(), max_iters=2)
    assert capfd.readouterr() == ("", "")


def test_silent_even_where_python_would_print_warnings() -> None:
    """Python prints warnings of loggers without a handler; this solve does not converge."""
    code = (
        "import logging\n"
        "from tests.test_log import rosenbrock\n"
        "from arael.solving import solve\n"
        "solve(rosenbrock(), max_iters=1)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")


def test_import_does_not_load_logging() -> None:
    code = "import sys; import arael.log; arael.log.log('solve', 'info', 'x'); " \
        "print('logging' in sys.modules)"  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_passes_at_info_attempts_at_debug() -> None:
    heard: list[str] = []
    with arael.log_to(heard.append):
        solve(line([COARSE]))
    assert len(heard) == 1
    assert heard[0].startswith("toy, pass coarse: converged: cost ")
    with arael.log_to(heard.append, "debug"):
        result = solve(line())
    attempts = [text for text in heard if "radius=" in text]
    assert len(attempts) == result.iterations


def test_warning_only_of_what_did_not_converge() -> None:
    heard: list[str] = []
    with arael.log_to(heard.append, "warning"):
        solve(line())
        assert heard == []
        solve(rosenbrock(), max_iters=2)
    assert len(heard) == 1
    assert "max_iterations: cost 24.2 -> " in heard[0]
    solve(rosenbrock(), max_iters=2)
    assert len(heard) == 1


def test_through_pythons_own_logging(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, logger="arael"):
        solve(rosenbrock(), max_iters=3)
    names = [(record.name, record.levelname) for record in caplog.records]
    assert names == [("arael.solve", "DEBUG")] * 3 + [("arael.solve", "WARNING")]


def test_trace_goes_to_its_taker_and_to_the_log() -> None:
    heard: list[str] = []
    trace: list[str] = []
    with arael.log_to(heard.append, "debug"):
        solve(rosenbrock(), max_iters=3, trace=trace.append)
    assert heard[:3] == trace
    assert len(trace) == 3


def test_sinks_come_and_go_in_any_order() -> None:
    before = ROOT.level
    first, second = io.StringIO(), io.StringIO()
    one = arael.log_to(first, "debug")
    two = arael.log_to(second, "warning")
    one.close()
    solve(rosenbrock(), max_iters=2)
    two.close()
    two.close()
    solve(rosenbrock(), max_iters=2)
    assert first.getvalue() == ""
    assert second.getvalue().count("\n") == 1
    assert ROOT.level == before
    assert not any(getattr(h, "of_arael", False) for h in ROOT.handlers)


def test_what_a_sink_raises_is_not_swallowed() -> None:
    def full(_: str) -> None:
        raise OSError("disk full")

    with arael.log_to(full), pytest.raises(OSError, match="disk full"):
        solve(line())


@pytest.mark.parametrize(
    ("sink", "level", "message"),
    [(None, "loud", "there is no log level 'loud'"), (3, "info", "3 takes no messages")],
)
def test_bad_listeners(sink: object, level: str, message: str) -> None:
    with pytest.raises(AraelError, match=message) as error:
        arael.log_to(sink, level)  # type: ignore[arg-type]
    assert error.value.diagnostics[0].code == "E1010"
