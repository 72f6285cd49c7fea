"""Standard streams that are full, closed or of a poor encoding: a message, never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="redirections are those of a POSIX shell"
)
NEEDS_FULL = pytest.mark.skipif(
    not os.path.exists("/dev/full"), reason="there is no /dev/full; Linux has it"
)
SOLVE = "solve line.arael line.json --interpret"
C_LOCALE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def shell(
    command: str, folder: Path, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run ``arael COMMAND``, redirections included, in a shell."""
    return subprocess.run(
        ["sh", "-c", f'"{sys.executable}" -m arael {command}'],
        cwd=folder,
        env={**os.environ, **(environment or {})},
        capture_output=True,
        timeout=120,
        check=False,
    )


@NEEDS_FULL
@pytest.mark.parametrize("command", [SOLVE, f"{SOLVE} --json", "calc 1+1", "--help"])
def test_a_full_output_is_reported(line: Path, command: str) -> None:
    done = shell(f"{command} >/dev/full", line)
    assert done.returncode == 2
    assert done.stderr == b"error: cannot write the output: no space left on device\n"


@NEEDS_FULL
def test_an_error_that_cannot_be_printed_keeps_its_exit_code(line: Path) -> None:
    for redirected in ("--json >/dev/full", "2>/dev/full", "--json >&-", ">&- 2>&-"):
        done = shell(f"solve no.arael x {redirected}", line)
        assert done.returncode == 2
        assert b"Traceback" not in done.stderr and b"internal" not in done.stderr


@pytest.mark.parametrize("command", [SOLVE, f"{SOLVE} --json", "calc 1+1"])
def test_a_closed_output_is_reported(line: Path, command: str) -> None:
    done = shell(f"{command} >&-", line)
    assert done.returncode == 2
    assert done.stderr == b"error: cannot write the output: standard output is closed\n"


def test_a_file_does_not_take_the_place_of_a_closed_stream(line: Path) -> None:
    done = shell(f"{SOLVE} -o out.json >&- 2>&-", line)
    assert done.returncode == 2
    assert (line / "out.json").read_text().startswith("{\n")
    assert (line / "out.json").read_text().endswith("}\n")


@pytest.mark.parametrize("closed", ["2>&-", "<&-"])
def test_other_streams_may_be_closed(line: Path, closed: str) -> None:
    done = shell(f"{SOLVE} {closed}", line)
    assert done.returncode == 0 and done.stdout.startswith(b"converged")


def test_a_locale_of_ascii_alone(line: Path) -> None:
    """Files with other names and texts are read, solved and written all the same."""
    (line / "lin\u00e9.json").write_text((line / "line.json").read_text())
    text = (
        (line / "line.arael").read_text().replace("# A line.", "## A l\u00efne \u2264 \U0001f600.")
    )
    (line / "line.arael").write_text(text, encoding="utf-8")
    done = shell("solve line.arael lin\u00e9.json --interpret -o \u00fc.json", line, C_LOCALE)
    assert done.returncode == 0, done.stderr
    assert b"wrote " in done.stdout
    assert (line / "\u00fc.json").exists()
    shown = shell("info line.arael", line, C_LOCALE)
    assert shown.returncode == 0, shown.stderr
    assert b"Traceback" not in shown.stderr + done.stderr
