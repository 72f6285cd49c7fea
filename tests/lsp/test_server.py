"""The server as an editor uses it: a process, a client, a text that is typed step by step."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

from arael.diagnostics.records import Source
from arael.syntax.fmt import format_source
from tests.event_loop import completed
from tests.lsp.texts import MODEL

WAIT = 60.0


class Editor:
    """A client with one open text."""

    def __init__(self, uri: str) -> None:
        self.client = LanguageClient("test", "1")
        self.uri = uri
        self.text = ""
        self.version = 0
        self.published: dict[str, Any] = {}
        self.news = asyncio.Event()
        self.client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)(
            lambda params: self._publish(params)
        )

    def _publish(self, params: lsp.PublishDiagnosticsParams) -> None:
        self.published[params.uri] = params
        self.news.set()

    async def start(self, encoding: lsp.PositionEncodingKind | None = None) -> lsp.InitializeResult:
        await self.client.start_io(sys.executable, "-m", "arael", "lsp", "--stdio")
        general = lsp.GeneralClientCapabilities(
            position_encodings=[encoding] if encoding is not None else None
        )
        capabilities = lsp.ClientCapabilities(general=general)
        found = await self.client.initialize_async(lsp.InitializeParams(capabilities))
        self.client.initialized(lsp.InitializedParams())
        return found

    async def stop(self) -> None:
        await self.client.shutdown_async(None)
        self.client.exit(None)
        await self.client.stop()

    def open(self, text: str) -> None:
        self.text = text
        item = lsp.TextDocumentItem(self.uri, "arael", self.version, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))

    def type(self, before: str, after: str) -> None:
        """Replace `before` by `after`, as one change of a range."""
        start = self.text.index(before)
        change = lsp.TextDocumentContentChangePartial(
            range=lsp.Range(self.place(start), self.place(start + len(before))), text=after
        )
        self.text = self.text.replace(before, after, 1)
        self.version += 1
        self.client.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(self.version, self.uri), [change]
            )
        )

    def place(self, offset: int) -> lsp.Position:
        before = self.text[:offset]
        line = before.count("\n")
        column = len(before.rpartition("\n")[2].encode("utf-16-le")) // 2
        return lsp.Position(line, column)

    def at(self, mark: str) -> dict[str, Any]:
        """Document and position of `|` in `mark`."""
        offset = self.text.index(mark.replace("|", "")) + mark.index("|")
        return {
            "text_document": lsp.TextDocumentIdentifier(self.uri),
            "position": self.place(offset),
        }

    async def findings(self) -> list[lsp.Diagnostic]:
        """Findings of the present text."""
        while True:
            found = self.published.get(self.uri)
            if found is not None and found.version == self.version:
                return list(found.diagnostics)
            self.news.clear()
            await asyncio.wait_for(self.news.wait(), WAIT)

    def edited(self, edits: list[Any]) -> str:
        """The text with edits made."""
        lines = self.text.splitlines(keepends=True)
        starts = [sum(map(len, lines[:n])) for n in range(len(lines) + 1)]

        def offset(place: lsp.Position) -> int:
            line = lines[place.line] if place.line < len(lines) else ""
            units = line.encode("utf-16-le")[: 2 * place.character]
            return starts[min(place.line, len(lines))] + len(units.decode("utf-16-le"))

        text = self.text
        for one in sorted(edits, key=lambda e: offset(e.range.start), reverse=True):
            text = text[: offset(one.range.start)] + one.new_text + text[offset(one.range.end) :]
        return text


def session(path: Path, work: Callable[[Editor], Awaitable[None]], *, start: bool = True) -> None:
    """Run `work` with an editor and a server of its own."""

    async def run() -> None:
        editor = Editor(path.as_uri())
        if start:
            await editor.start()
        try:
            await asyncio.wait_for(work(editor), 3 * WAIT)
        finally:
            await editor.stop()

    completed(run())


def test_a_model_is_typed(tmp_path: Path) -> None:
    async def work(editor: Editor) -> None:
        editor.open(MODEL)
        assert await editor.findings() == []

        # A mistake, its message and place, its correction.
        editor.type("beacon.pos - pose.pos", "beacon.poss - pose.pos")
        (finding,) = await editor.findings()
        assert finding.code == "E0204"
        assert "Beacon has no field `poss`" in finding.message
        assert "did you mean `pos`" in finding.message
        assert finding.range.start == editor.at("beacon.|poss")["position"]
        assert finding.code_description is not None
        assert finding.code_description.href.endswith("E0204.md")
        assert finding.related_information
        found = await editor.client.text_document_code_action_async(
            lsp.CodeActionParams(
                lsp.TextDocumentIdentifier(editor.uri),
                finding.range,
                lsp.CodeActionContext([finding]),
            )
        )
        assert found
        edits = found[0].edit.changes[editor.uri]  # type: ignore[union-attr,index]
        assert editor.edited(list(edits)) == MODEL

        # A half-typed line: completion in spite of the syntax error.
        editor.type("beacon.poss - pose.pos)", "beacon. - pose.pos")
        assert await editor.findings()
        items = await editor.client.text_document_completion_async(
            lsp.CompletionParams(**editor.at("norm(beacon.|"))
        )
        assert isinstance(items, list)
        assert [i.label for i in items] == ["pos", "parent"]

        editor.type("beacon. - pose.pos", "beacon.pos - pose.pos)")
        assert await editor.findings() == []

    session(tmp_path / "model.arael", work)


def test_questions(tmp_path: Path) -> None:
    async def work(editor: Editor) -> None:
        editor.open(MODEL)
        client = editor.client
        shown = await client.text_document_hover_async(
            lsp.HoverParams(**editor.at("constraint se|en"))
        )
        assert shown is not None and isinstance(shown.contents, lsp.MarkupContent)
        assert "operations" in shown.contents.value
        place = await client.text_document_definition_async(
            lsp.DefinitionParams(**editor.at("before.po|s"))
        )
        assert isinstance(place, lsp.Location)
        assert place.uri == editor.uri
        assert place.range.start == editor.at("|pos: vec2 [m]\n    param")["position"]
        used = await client.text_document_references_async(
            lsp.ReferenceParams(
                context=lsp.ReferenceContext(include_declaration=False), **editor.at("sigm|a: real")
            )
        )
        assert used is not None
        assert sorted(u.range.start.line for u in used) == [
            n for n, line in enumerate(MODEL.splitlines()) if "path.sigma" in line
        ]
        edit = await client.text_document_rename_async(
            lsp.RenameParams(new_name="accuracy", **editor.at("sigm|a: real"))
        )
        assert edit is not None and edit.changes is not None
        changed = editor.edited(list(edit.changes[editor.uri]))
        assert changed == MODEL.replace("sigma", "accuracy")
        with pytest.raises(Exception, match="cannot rename: `sin` belongs to the language"):
            await client.text_document_rename_async(
                lsp.RenameParams(new_name="sin", **editor.at("sigm|a: real"))
            )
        help_ = await client.text_document_signature_help_async(
            lsp.SignatureHelpParams(**editor.at("max(x - limit, |0)"))
        )
        assert help_ is not None
        assert help_.signatures[0].label == "max(a, b, ...)"
        hints = await client.text_document_inlay_hint_async(
            lsp.InlayHintParams(
                lsp.TextDocumentIdentifier(editor.uri),
                lsp.Range(lsp.Position(0, 0), editor.place(len(MODEL))),
            )
        )
        assert hints is not None
        assert [h.label for h in hints] == [": real", ": the struct Pose", ": vec2 [m]"]
        outline = await client.text_document_document_symbol_async(
            lsp.DocumentSymbolParams(lsp.TextDocumentIdentifier(editor.uri))
        )
        assert outline is not None
        names = ["TURN", "beyond", "Beacon", "Pose", "Sight", "Path"]
        assert [s.name for s in outline] == names

    session(tmp_path / "model.arael", work)


def test_format(tmp_path: Path) -> None:
    async def work(editor: Editor) -> None:
        editor.open(MODEL.replace("    param pos", "  param   pos"))
        options = lsp.FormattingOptions(tab_size=4, insert_spaces=True)
        params = lsp.DocumentFormattingParams(lsp.TextDocumentIdentifier(editor.uri), options)
        edits = await editor.client.text_document_formatting_async(params)
        assert edits
        assert editor.edited(list(edits)) == format_source(Source("model.arael", editor.text))
        editor.type("struct Beacon {", "struct Beacon")
        assert not await editor.client.text_document_formatting_async(params)

    session(tmp_path / "model.arael", work)


def test_places_behind_characters_beyond_the_basic_plane(tmp_path: Path) -> None:
    """UTF-16: a character such as an emoji has two units."""

    async def work(editor: Editor) -> None:
        text = MODEL.replace("let step = ", "let step = 1 * # \U0001f600 \U0001f600\n        ")
        editor.open(text.replace("# Range of", "const Y = nothing # \U0001f600\n# Range of"))
        editor.type("nothing # \U0001f600", "1 # \U0001f600\U0001f600\U0001f600 x")
        assert await editor.findings() == []
        editor.type("\U0001f600 x", "\U0001f600\nconst Z = nothing")
        (finding,) = await editor.findings()
        assert finding.range.start == editor.at("= |nothing")["position"]

    session(tmp_path / "model.arael", work)


def test_an_error_of_an_import_stands_at_the_import(tmp_path: Path) -> None:
    parts, main = MODEL.split("struct Pose {", 1)
    (tmp_path / "parts.arael").write_text(parts.replace("vec2 [m]", "vek2 [m]"))

    async def work(editor: Editor) -> None:
        editor.open('import "parts.arael"\n\nstruct Pose {' + main)
        first = (await editor.findings())[0]
        assert first.range.start == lsp.Position(0, 0)
        assert "parts.arael:" in first.message
        # The part is opened and corrected, but not saved: the editor's text counts.
        uri = (tmp_path / "parts.arael").as_uri()
        item = lsp.TextDocumentItem(uri, "arael", 0, parts)
        editor.published.clear()
        editor.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        assert await editor.findings() == []

    session(tmp_path / "main.arael", work)


def test_without_pygls_the_message_names_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib.util

    from arael.cli.lsp import command
    from arael.diagnostics.records import AraelError

    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == "pygls" else find(name, *a)
    )
    with pytest.raises(AraelError) as error:
        command.callback(stdio=True)  # type: ignore[misc]
    (one,) = error.value.diagnostics
    assert one.code == "E0869"
    assert one.help == ("pip install 'arael[lsp]'",)
