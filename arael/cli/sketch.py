"""`arael sketch`: sketches by script, or by commands at a prompt."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Sequence
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from arael.cli.exits import Exit
from arael.cli.failures import print_text
from arael.diagnostics.records import AraelError, Diagnostic, Source

if TYPE_CHECKING:
    from arael.sketch.commands.replies import Reply
    from arael.sketch.commands.session import Session

MAX_SCRIPT = 64 * 1024 * 1024
"""Bytes of a script."""


@click.command("sketch", short_help="Draw and edit parametric sketches.")
@click.argument("files", nargs=-1, metavar="[FILE.json | FILE.cmd] ...")
@click.option(
    "--export",
    "exports",
    multiple=True,
    metavar="FILE",
    help="Write the sketch at the end: .json, .dxf, .svg, .pdf, .png, .step; may be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object per command line.")
@click.option("--interactive", is_flag=True, help="Open the prompt after FILES.")
@click.option("--serve", is_flag=True, help="Open the editor in the browser, for one FILE.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Of --serve; 0: a free one.")
@click.option("--mcp-allow-all", is_flag=True, help="Agents may change the sketch without asking.")
@click.option("--no-open", is_flag=True, help="With --serve: print the address only.")
def command(
    files: tuple[str, ...],
    exports: tuple[str, ...],
    as_json: bool,
    interactive: bool,
    serve: bool,
    port: int,
    mcp_allow_all: bool,
    no_open: bool,
) -> int:
    """Load sketches (.json), run scripts of commands (any other file), or open a prompt.

    Without FILES it reads commands: at a prompt on a terminal, else from standard input. A script
    stops at the first line that fails, which changes nothing; lines before it stay. `help` shows
    the commands. `-` stands for standard input.

    `arael sketch --serve FILE.json` opens the editor in the browser; `arael sketch mcp FILE.json`
    serves an agent over standard input and output (Model Context Protocol).
    """
    if files[:1] == ("mcp",):
        return _serve_agent(files[1:], port=port, allow_agents=mcp_allow_all)
    if serve:
        return _serve(files, port=port, open_browser=not no_open, allow_agents=mcp_allow_all)
    run = _Run(as_json)
    for name in files:
        if not run.file(name):
            return run.code
    closed = sys.stdin is None
    if not closed and (interactive or (not files and sys.stdin.isatty())):
        run.ask()
    elif not closed and not files and not run.lines(_standard_input()):
        return run.code
    for name in exports:
        if not run.export(name):
            return run.code
    return run.code


def _serve(files: tuple[str, ...], **options: Any) -> int:
    """Serve the editor; the exit code."""
    return _served("arael.sketch.server.serving", "serve", files, say=click.echo, **options)


def _serve_agent(files: tuple[str, ...], **options: Any) -> int:
    """Serve an agent over standard input and output; the exit code."""
    return _served("arael.sketch.agents.stdio", "serve_stdio", files, **options)


def _served(module: str, name: str, files: tuple[str, ...], **options: Any) -> int:
    if len(files) > 1:
        raise click.UsageError("the server takes one file")
    try:
        function = getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("arael"):
            raise
        print_text([_missing(error.name or "")])
        return Exit.BAD_INPUT
    try:
        function(files[0] if files else None, **options)
    except AraelError as error:
        print_text(error.diagnostics)
        return Exit.BAD_INPUT
    return Exit.OK


def _missing(module: str) -> Diagnostic:
    return Diagnostic(
        "E1412",
        f"the editor in the browser needs the module `{module}`",
        help=("`pip install 'arael[sketch]'` brings what it needs",),
    )


def _standard_input() -> Iterator[tuple[Source, int, int]]:
    """Lines of standard input, one by one, so that each is answered when it comes."""
    number = 0
    while line := sys.stdin.readline(200_000):
        number += 1
        text = line.rstrip("\n")
        yield Source("<stdin>", text, number), 0, len(text)


class _Run:
    """A session and the output of its replies.

    Attributes
    ----------
    code : exit code so far
    """

    def __init__(self, as_json: bool) -> None:
        # imported here: start-up time
        from arael.sketch.commands.session import Session

        self.session: Session = Session()
        self.as_json = as_json
        self.code: int = Exit.OK
        self._stdin_folder = self.session.folder

    # --- files ------------------------------------------------------------------------------

    def file(self, name: str) -> bool:
        """Load a sketch or run a script; False if it fails."""
        if name == "-":
            self.session.folder = self._stdin_folder
            return sys.stdin is None or self.lines(_standard_input(), whole=True)
        path = Path(name)
        self.session.folder = path.absolute().parent
        try:
            if path.suffix.lower() == ".json":
                return self._load(path)
            text = _script(path)
        except AraelError as error:
            self._failed(error, Exit.BAD_INPUT)
            return False
        finally:
            if path.suffix.lower() == ".json":
                self.session.folder = self._stdin_folder
        source = Source(name, text)
        return self.lines(_lines_of(source), whole=True)

    def _load(self, path: Path) -> bool:
        # imported here: start-up time
        from arael.sketch.document.saved import load

        try:
            document = load(path)
        except OSError as error:
            raise _unreadable(str(path), error) from None
        self.session.editor = self.session.make_editor(document)
        return True

    def export(self, name: str) -> bool:
        """Write the sketch to a file; False if it fails."""
        # imported here: start-up time
        from arael.sketch.sketch import Sketch

        sketch = Sketch()
        sketch.session = self.session
        try:
            is_json = Path(name).suffix.lower() == ".json"
            (sketch.save if is_json else sketch.export)(name)
        except AraelError as error:
            self._failed(error, Exit.BAD_INPUT)
            return False
        return True

    # --- lines ------------------------------------------------------------------------------

    def lines(self, lines: Iterator[tuple[Source, int, int]], whole: bool = False) -> bool:
        """Run lines up to the first that fails (False) or leaves.

        Parameters
        ----------
        whole : they are of a script: what was done is said after a failure
        """
        done = 0
        for source, start, end in lines:
            try:
                replies = self._line(source, start, end)
            except AraelError as error:
                notes = (_done(done),) if whole else ()
                self._failed(error, Exit.NOT_CONVERGED, notes)
                return False
            done += bool(replies)
            if any(reply.leaves for reply in replies):
                break
        return True

    def ask(self) -> None:
        """Read lines from the terminal until its end."""
        # imported here: start-up time
        from arael.cli.line_editing import line_editing

        click.echo("arael sketch: `help` lists commands, `exit` leaves", err=True)
        with line_editing(self._names, "sketch_history"):
            while True:
                try:
                    line = input("> ")
                except KeyboardInterrupt:
                    click.echo()
                    continue
                except EOFError:
                    click.echo()
                    break
                try:
                    source = Source("input", line)
                    if any(reply.leaves for reply in self._line(source, 0, len(line))):
                        break
                except AraelError as error:
                    self._failed(error, Exit.OK)
                except KeyboardInterrupt:
                    click.echo("interrupted: nothing of the line was done", err=True)

    def _line(self, source: Source, start: int, end: int) -> Sequence[Reply]:
        """Run one line and show its replies."""
        # imported here: start-up time
        from arael.sketch.commands.tokens import statements

        began = time.perf_counter()
        found = statements(source, start, end)
        replies = self.session.run_line(found) if found else []
        elapsed = time.perf_counter() - began
        if replies:
            self._show(source.text[start:end].strip(), replies, elapsed)
        return replies

    def _show(self, line: str, replies: Sequence[Reply], elapsed: float) -> None:
        timed = self.session.state.timing
        if self.as_json:
            shown: dict[str, Any] = {
                "status": "ok",
                "command": line,
                "text": "\n".join(reply.text for reply in replies if reply.text),
                "names": [name for reply in replies for name in reply.names],
                "data": [dict(reply.data) for reply in replies],
            }
            if timed:
                shown["seconds"] = elapsed
            click.echo(json.dumps(shown, default=_plain))
            return
        for reply in replies:
            if reply.text:
                click.echo(reply.text)
        if timed:
            click.echo(f"{1e3 * elapsed:.1f} ms")

    def _failed(self, error: AraelError, code: int, notes: tuple[str, ...] = ()) -> None:
        self.code = code or self.code
        diagnostics = error.diagnostics
        if self.as_json:
            # imported here: start-up time
            from arael.diagnostics.as_json import as_json

            plain: Any = as_json(diagnostics)
            shown = {"status": "error", "diagnostics": plain}
            click.echo(json.dumps(shown | ({"done": notes[0]} if notes else {})))
            return
        sys.stdout.flush()
        print_text(diagnostics)
        for note in notes:
            click.echo(f"note: {note}", err=True)

    def _names(self) -> list[str]:
        """Words for completion: commands, names, variables, points and properties."""
        # imported here: start-up time
        from arael.sketch.commands.completion import completions

        return completions(self.session)


def _plain(value: Any) -> Any:
    """A NumPy number as one of Python."""
    return value.item()


def _done(lines: int) -> str:
    if not lines:
        return "nothing was done before this line"
    if lines == 1:
        return "1 command line before this one is done"
    return f"{lines} command lines before this one are done"


def _lines_of(source: Source) -> Iterator[tuple[Source, int, int]]:
    starts = [*source.line_starts, len(source.text) + 1]
    for start, after in pairwise(starts):
        yield source, start, max(start, after - 1)


def _script(path: Path) -> str:
    try:
        size = path.stat().st_size
        if size > MAX_SCRIPT:
            help_ = (f"at most {MAX_SCRIPT:,} are read",)
            raise AraelError(
                Diagnostic("E1290", f"a script of {size:,} bytes", origin=str(path), help=help_)
            )
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise _unreadable(str(path), error) from None
    except UnicodeDecodeError:
        help_ = ("a script is a text file in UTF-8; a sketch ends in `.json`",)
        message = "cannot be read as a script of commands"
        raise AraelError(Diagnostic("E1290", message, origin=str(path), help=help_)) from None


def _unreadable(name: str, error: OSError) -> AraelError:
    reason = (error.strerror or str(error)).lower()
    return AraelError(Diagnostic("E1290", f"cannot be read: {reason}", origin=name))
