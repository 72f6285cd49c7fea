"""Collects the diagnostics of the rules and limits their number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from arael.diagnostics.records import Diagnostic, Findings, Label, Span

MAX_ERRORS = 50
MAX_WARNINGS = 50


class Reporter:
    """Adds diagnostics to the findings of a run.

    `observe`, if given, is called with each expression of the text, what it was found to be (a
    binding) and its unit if it is a value: editors show these.

    After `MAX_ERRORS` errors the run is stopped, so that checking a malicious or badly broken file
    takes bounded time.
    """

    def __init__(
        self, findings: Findings, observe: Callable[[Any, Any, Any], None] | None = None
    ) -> None:
        self.findings = findings
        self.observe = observe

    def error(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        label: str = "",
        labels: Sequence[Label] = (),
        notes: Sequence[str] = (),
        help: Sequence[str] = (),
    ) -> None:
        """Report an error at `span`."""
        self._add(Diagnostic(code, message, span, label, tuple(labels), tuple(notes), tuple(help)))
        if len(self.findings.errors) >= MAX_ERRORS:
            self.stop()

    def reported(self, code: str, message: str, labels: Sequence[Label]) -> bool:
        """Whether an error of this code, message and secondary places was reported before."""
        return any(
            (d.code, d.message, d.labels[: len(labels)]) == (code, message, tuple(labels))
            for d in self.findings.items
        )

    def stop(self) -> None:
        """Raise `AraelError` with all findings, in order of place, if any of them is an error."""
        self.in_order()
        self.findings.stop_on_errors()

    def warning(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        label: str = "",
        labels: Sequence[Label] = (),
        notes: Sequence[str] = (),
        help: Sequence[str] = (),
    ) -> None:
        """Report a warning at `span`; the last one within the limit notes that more were found."""
        count = len(self.findings.warnings)
        if count >= MAX_WARNINGS:
            return
        if count == MAX_WARNINGS - 1:
            notes = [*notes, "further warnings are not shown"]
        self._add(
            Diagnostic(
                code,
                message,
                span,
                label,
                tuple(labels),
                tuple(notes),
                tuple(help),
                severity="warning",
            )
        )

    def in_order(self) -> None:
        """Sort the findings by place, file by file."""
        files = {
            d.span.source.name: i for i, d in reversed(list(enumerate(self.findings))) if d.span
        }
        self.findings.items.sort(
            key=lambda d: (files[d.span.source.name], d.span.start) if d.span else (-1, 0)
        )

    def _add(self, diagnostic: Diagnostic) -> None:
        """Keep one diagnostic per place and code: constraints are typed at every place."""
        said = ((d.code, d.span, d.message) for d in self.findings.items)
        if (diagnostic.code, diagnostic.span, diagnostic.message) not in said:
            self.findings.add(diagnostic)
