"""Helpers that check a text, for the tests of this folder."""

from __future__ import annotations

from pathlib import Path

from arael.check.check import check
from arael.check.typed import ConstraintSite, TypedModel
from arael.diagnostics.records import AraelError, Diagnostic, Findings, Source
from arael.syntax.parser import parse

MODELS = Path(__file__).parents[2] / "models"


def checked(text: str, name: str = "model.arael", root: str | None = None) -> TypedModel:
    """The typed model of a text that has no errors."""
    return check(parse(Source(name, text)), root=root, findings=Findings())


def standard(name: str) -> TypedModel:
    """One of the standard models."""
    return checked((MODELS / f"{name}.arael").read_text(), f"{name}.arael")


def diagnostics(text: str, root: str | None = None) -> list[Diagnostic]:
    """All diagnostics of a text, warnings included."""
    findings = Findings()
    try:
        check(parse(Source("model.arael", text)), root=root, findings=findings)
    except AraelError as error:
        return list(error.diagnostics)
    return list(findings)


def codes(text: str) -> list[str]:
    """Codes of all diagnostics of a text."""
    return [d.code for d in diagnostics(text)]


def constraint(model: TypedModel, label: str, table: str | None = None) -> ConstraintSite:
    """The constraint of that label (at that table)."""
    (found,) = (c for c in model.constraints if c.label == label and table in (None, c.table))
    return found
