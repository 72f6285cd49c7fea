"""The protocol: requests of an editor to the modules of this package, by pygls."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from arael.diagnostics.explain import page_address
from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.lsp.actions import actions
from arael.lsp.completion import completions
from arael.lsp.counting import counted
from arael.lsp.document import Document, analyse
from arael.lsp.hints import hints
from arael.lsp.hover import hover
from arael.lsp.names import Symbol
from arael.lsp.renaming import RENAMEABLE, Refused, rename, uses
from arael.lsp.signatures import signature
from arael.lsp.workspace import Workspace
from arael.syntax.fmt import format_source
from arael.version import __version__

PAUSE = 0.15
"""Seconds without typing after which findings are published."""

_SEVERITY = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "note": lsp.DiagnosticSeverity.Information,
}

_COMPLETIONS = {
    "field": lsp.CompletionItemKind.Field,
    "param": lsp.CompletionItemKind.Property,
    "function": lsp.CompletionItemKind.Function,
    "constant": lsp.CompletionItemKind.Constant,
    "variable": lsp.CompletionItemKind.Variable,
    "keyword": lsp.CompletionItemKind.Keyword,
    "struct": lsp.CompletionItemKind.Struct,
    "type": lsp.CompletionItemKind.Class,
    "unit": lsp.CompletionItemKind.Unit,
    "loss": lsp.CompletionItemKind.Function,
    "setting": lsp.CompletionItemKind.Property,
    "constraint": lsp.CompletionItemKind.Event,
}

_SYMBOLS = {
    "struct": lsp.SymbolKind.Struct,
    "component": lsp.SymbolKind.Struct,
    "root": lsp.SymbolKind.Module,
    "param": lsp.SymbolKind.Property,
    "field": lsp.SymbolKind.Field,
    "formula": lsp.SymbolKind.Field,
    "constraint": lsp.SymbolKind.Event,
    "fit": lsp.SymbolKind.Event,
    "prior": lsp.SymbolKind.Event,
    "pass": lsp.SymbolKind.Method,
    "const": lsp.SymbolKind.Constant,
    "function": lsp.SymbolKind.Function,
}


class Server(LanguageServer):
    """Open documents, analysed when they are asked for."""

    def __init__(self) -> None:
        super().__init__("arael", f"v{__version__}")
        self.files = Workspace()
        self.known: dict[str, Document] = {}
        self.stale: set[str] = set()
        self.waiting: asyncio.TimerHandle | None = None
        self.counts: dict[str, dict[str, str]] = {}
        self.counting = threading.Lock()

    # --- documents ----------------------------------------------------------------------------

    def document(self, uri: str) -> Document:
        """The document of an open file, of its present text."""
        if uri in self.stale or uri not in self.known:
            text = self.workspace.get_text_document(uri).source
            source = Source(to_fs_path(uri) or uri, text)
            self.known[uri] = analyse(source, self.files, self.known.get(uri))
            self.stale.discard(uri)
        return self.known[uri]

    def changed(self, uri: str) -> None:
        """Note a new text; findings of all open files follow after a pause."""
        path = to_fs_path(uri)
        if path:
            self.files.open[Path(path).resolve()] = self.workspace.get_text_document(uri).source
        self.stale |= {uri, *self.known}
        self.known.setdefault(uri, self.document(uri))
        if self.waiting is not None:
            self.waiting.cancel()
        self.waiting = asyncio.get_running_loop().call_later(PAUSE, self.publish)

    def closed(self, uri: str) -> None:
        """Forget the text of a file; the disk's counts again."""
        path = to_fs_path(uri)
        if path:
            self.files.open.pop(Path(path).resolve(), None)
        self.known.pop(uri, None)
        self.stale |= set(self.known)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))
        self.publish()

    def publish(self) -> None:
        """Send the findings of all open files."""
        for uri in list(self.known):
            document = self.document(uri)
            found = [self.diagnostic(uri, document, one) for one in document.findings]
            version = self.workspace.get_text_document(uri).version
            self.text_document_publish_diagnostics(
                lsp.PublishDiagnosticsParams(uri, found, version)
            )

    def operations(self, document: Document) -> dict[str, str]:
        """Operations of the constraints of a text; derived once for each text."""
        text = document.source.text
        with self.counting:
            if text not in self.counts:
                self.counts = {text: counted(document.source)}
            return self.counts[text]

    # --- places -------------------------------------------------------------------------------

    def offset(self, uri: str, position: lsp.Position) -> int:
        """Offset in the text of a place of the editor."""
        return self.workspace.get_text_document(uri).offset_at_position(position)

    def range(self, span: Span) -> lsp.Range:
        """Place of the editor of characters of a text."""
        source = span.source
        codec = self.workspace.position_codec

        def position(offset: int) -> lsp.Position:
            line, column = source.position(offset)
            units = codec.client_num_units(source.line(line)[: column - 1])
            return lsp.Position(line - 1, units)

        return lsp.Range(position(span.start), position(span.end))

    def location(self, span: Span) -> lsp.Location:
        """File and place of a span."""
        return lsp.Location(self.uri(span.source.name), self.range(span))

    def uri(self, name: str) -> str:
        """Address of a file as the editor writes it, if it is open."""
        for uri, document in self.known.items():
            if document.source.name == name or to_fs_path(uri) == str(Path(name).resolve()):
                return uri
        return from_fs_path(str(Path(name).resolve())) or name

    def diagnostic(self, uri: str, document: Document, one: Diagnostic) -> lsp.Diagnostic:
        """A finding with its notes and help; one in an imported file stands at the import."""
        span, message = one.span, one.message
        if span is None or span.source.name != document.source.name:
            message = str(one) if span is not None else f"{one.origin}: {message}"
            span = _import_of(document, one)
        parts = [message, *([one.label] if one.label else [])]
        parts += [f"note: {text}" for text in one.notes] + [f"help: {text}" for text in one.help]
        page = page_address(one.code)
        return lsp.Diagnostic(
            self.range(span),
            "\n".join(parts),
            _SEVERITY[one.severity],
            code=one.code,
            source="arael",
            code_description=lsp.CodeDescription(page) if page else None,
            related_information=[
                lsp.DiagnosticRelatedInformation(self.location(label.span), label.text)
                for label in one.labels
            ],
        )


def _import_of(document: Document, one: Diagnostic) -> Span:
    """The first import of a document, where the finding is in another file."""
    for i, token in enumerate(document.tokens[:-1]):
        if token.type == "IMPORT":
            after = document.tokens[i + 1]
            return Span(document.source, token.start, after.end)
    return Span(document.source, 0, 0)


def make_server() -> Server:
    """The server with all its features."""
    server = Server()

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: lsp.DidOpenTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: lsp.DidChangeTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: lsp.DidCloseTextDocumentParams) -> None:
        server.closed(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    @server.thread()
    def hovered(params: lsp.HoverParams) -> lsp.Hover | None:
        uri = params.text_document.uri
        document, offset = server.document(uri), server.offset(uri, params.position)
        symbol = document.symbol_at(offset)
        named = symbol is not None and symbol.kind in ("constraint", "fit", "prior")
        counts = server.operations(document) if named and not document.errors else {}
        found = hover(document, offset, counts)
        if found is None:
            return None
        text, span = found
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text), server.range(span))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def defined(params: lsp.DefinitionParams) -> lsp.Location | None:
        symbol = _symbol(server, params)
        return server.location(symbol.span) if symbol is not None else None

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def referred(params: lsp.ReferenceParams) -> list[lsp.Location]:
        symbol = _symbol(server, params)
        if symbol is None:
            return []
        found = uses(server.document(params.text_document.uri), symbol, server.files)
        if not params.context.include_declaration:
            found = [s for s in found if (s.source.name, s.start) != symbol.key]
        return [server.location(span) for span in found]

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    def highlighted(params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
        symbol = _symbol(server, params)
        if symbol is None:
            return []
        document = server.document(params.text_document.uri)
        found = uses(document, symbol, Workspace())
        own = [s for s in found if s.source.name == document.source.name]
        return [lsp.DocumentHighlight(server.range(span)) for span in own]

    @server.feature(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def renamed(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        uri = params.text_document.uri
        document, offset = server.document(uri), server.offset(uri, params.position)
        try:
            edits = rename(document, offset, params.new_name, server.files)
        except Refused as why:
            raise JsonRpcInvalidParams(f"cannot rename: {why}") from None
        return lsp.WorkspaceEdit(
            {
                server.uri(name): [lsp.TextEdit(server.range(s), text) for s, text in own]
                for name, own in edits.items()
            }
        )

    @server.feature(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def renameable(params: lsp.PrepareRenameParams) -> lsp.Range | None:
        uri = params.text_document.uri
        document, offset = server.document(uri), server.offset(uri, params.position)
        symbol, i = document.symbol_at(offset), document.token_at(offset)
        if symbol is None or i is None or symbol.kind not in RENAMEABLE:
            return None
        token = document.tokens[i]
        return server.range(Span(document.source, token.start, token.end))

    @server.feature(
        lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "["])
    )
    def completed(params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        uri = params.text_document.uri
        found = completions(server.document(uri), server.offset(uri, params.position))
        return [
            lsp.CompletionItem(
                one.label,
                kind=_COMPLETIONS[one.sort],
                detail=one.detail or None,
                documentation=lsp.MarkupContent(lsp.MarkupKind.Markdown, one.doc)
                if one.doc
                else None,
                sort_text=f"{number:04}",
                insert_text=one.insert or None,
                insert_text_format=lsp.InsertTextFormat.Snippet if one.insert else None,
            )
            for number, one in enumerate(found)
        ]

    @server.feature(
        lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","])
    )
    def signed(params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        uri = params.text_document.uri
        found = signature(server.document(uri), server.offset(uri, params.position))
        if found is None:
            return None
        one = lsp.SignatureInformation(
            found.label,
            lsp.MarkupContent(lsp.MarkupKind.Markdown, found.doc) if found.doc else None,
            [lsp.ParameterInformation(a) for a in found.arguments],
        )
        return lsp.SignatureHelp([one], 0, found.active)

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def formatted(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        document = server.document(params.text_document.uri)
        try:
            text = format_source(document.source)
        except AraelError:
            return []  # its errors are shown as findings
        if text == document.source.text:
            return []
        whole = Span(document.source, 0, len(document.source.text))
        return [lsp.TextEdit(server.range(whole), text)]

    @server.feature(
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]),
    )
    def acted(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        uri = params.text_document.uri
        document = server.document(uri)
        start, end = (server.offset(uri, p) for p in (params.range.start, params.range.end))
        return [
            lsp.CodeAction(
                one.title,
                kind=lsp.CodeActionKind.QuickFix,
                diagnostics=[server.diagnostic(uri, document, one.finding)],
                edit=lsp.WorkspaceEdit({uri: [lsp.TextEdit(server.range(one.span), one.text)]}),
            )
            for one in actions(document, start, end, server.files)
        ]

    @server.feature(lsp.TEXT_DOCUMENT_INLAY_HINT)
    def hinted(params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
        uri = params.text_document.uri
        start, end = (server.offset(uri, p) for p in (params.range.start, params.range.end))
        document = server.document(uri)
        return [
            lsp.InlayHint(
                server.range(Span(document.source, one.offset, one.offset)).start,
                one.text,
                lsp.InlayHintKind.Type,
            )
            for one in hints(document, start, end)
        ]

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outlined(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        document = server.document(params.text_document.uri)
        names, own = document.names, document.source.name

        def entry(symbol: Symbol, inside: list[Symbol]) -> lsp.DocumentSymbol:
            place = server.range(symbol.span)
            return lsp.DocumentSymbol(
                symbol.name,
                _SYMBOLS[symbol.kind],
                place,
                place,
                detail=symbol.text,
                children=[entry(s, []) for s in inside],
            )

        items = [
            (s.symbol, [*s.members.values(), *s.constraints.values(), *s.passes.values()])
            for s in names.structs.values()
        ]
        items += [(s, []) for s in (*names.consts.values(), *names.functions.values())]
        items = [i for i in items if i[0].span.source.name == own and document.complete]
        return [entry(s, inside) for s, inside in sorted(items, key=lambda i: i[0].span.start)]

    return server


def _symbol(server: Server, params: Any) -> Symbol | None:
    uri = params.text_document.uri
    return server.document(uri).symbol_at(server.offset(uri, params.position))


def serve() -> None:
    """Serve one editor over standard input and output, until it ends."""
    make_server().start_io()
