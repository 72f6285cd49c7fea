"""Sessions at the shell, as Markdown: files, a command, what it prints, and its exit code.

A page begins with files that all its sessions share: fenced blocks whose info string ends with a
file's name (```` ```arael line.arael ````). Each heading below begins a session in a folder of its
own, with a ```` ```console ```` block: a command after ``$``, what it prints on
either stream, and ``exit`` with the code. ``pytest --update`` writes what comes out now.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from arael.cli.main import run

PAGES = sorted((Path(__file__).parent / "sessions").glob("*.md"))
FILE = re.compile(r"^```\w+ (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CONSOLE = re.compile(
    r"^```console\n\$ (?P<command>[^\n]*)\n(?P<printed>.*?)^```$", re.M | re.DOTALL
)

PLAIN = re.compile(r"arael [\w ./=:+,-]*")
"""A command that needs no shell: it is run in this process."""


@dataclass(frozen=True)
class Session:
    page: Path
    heading: str
    files: tuple[tuple[str, str], ...]
    command: str
    printed: str

    def __str__(self) -> str:
        return f"{self.page.stem}-{re.sub(r'[^a-z0-9]+', '-', self.heading.lower())}"


def sessions() -> list[Session]:
    found = []
    for page in PAGES:
        head, *sections = re.split(r"^## ", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
        for section in sections:
            files = (*FILE.findall(head), *FILE.findall(section))
            console = CONSOLE.search(section)
            assert console, f"{page}: no session under {section.splitlines()[0]}"
            heading = section.splitlines()[0]
            found.append(Session(page, heading, files, console["command"], console["printed"]))
    return found


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder whose path is short and has always the same length: messages are wrapped."""
    with tempfile.TemporaryDirectory(prefix="", dir="/tmp") as name:
        yield Path(name)


@pytest.mark.skipif(sys.platform == "win32", reason="the sessions are written for a POSIX shell")
@pytest.mark.parametrize("session", sessions(), ids=str)
def test_session(
    session: Session, folder: Path, update: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in session.files:
        (folder / name).write_text(text, encoding="utf-8")
    printed = printed_by(session.command, folder, monkeypatch).replace(str(folder), "/here")
    assert "Traceback" not in printed
    if update and printed != session.printed:
        text = session.page.read_text(encoding="utf-8")
        at = text.index(f"## {session.heading}\n")
        match = CONSOLE.search(text, at)
        assert match
        start, end = match.span("printed")
        session.page.write_text(text[:start] + printed + text[end:], encoding="utf-8")
        return
    assert printed == session.printed


def printed_by(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """What a command prints in `folder`, and its exit code."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")
    if PLAIN.fullmatch(command):
        written = io.BytesIO()
        out = io.TextIOWrapper(written, encoding="utf-8", write_through=True)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            code = int(run(shlex.split(command)[1:]))
        return f"{written.getvalue().decode()}exit {code}\n"
    script = f'arael() {{ "{sys.executable}" -m arael "$@"; }}\n{command}\n'
    done = subprocess.run(
        ["bash", "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
        check=False,
    )
    return f"{done.stdout}exit {done.returncode}\n"
