"""An `AraelError` as text: what a traceback, a notebook or a log shows of it."""

from __future__ import annotations

import pickle
import traceback
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.diagnostics.render import render

SOURCE = Source("m.arael", "root R { x: rael }\n")
FOUND = Diagnostic(
    "E0203",
    "unknown type `rael`",
    Span(SOURCE, 12, 16),
    "not found",
    notes=("a note",),
    help=("did you mean `real`?",),
)


def test_the_text_has_window_notes_and_help() -> None:
    assert str(AraelError([FOUND])) == (
        "m.arael:1:13: error[E0203]: unknown type `rael`\n"
        "  |\n"
        "1 | root R { x: rael }\n"
        "  |             ^^^^ not found\n"
        "  |\n"
        "  = note: a note\n"
        "  = help: did you mean `real`?"
    )


def test_a_place_without_a_text_stands_first_as_well() -> None:
    found = Diagnostic("E0702", "`y` is not set", origin="Path", help=("give it a value",))
    assert str(AraelError(found)) == "Path: error[E0702]: `y` is not set\n  help: give it a value"


def test_the_command_line_and_the_text_differ_in_the_place_alone() -> None:
    lines = render([FOUND]).splitlines()
    assert lines[2:] == str(AraelError(FOUND)).splitlines()[1:]


def test_a_traceback_ends_with_the_help() -> None:
    try:
        raise AraelError(FOUND)
    except AraelError as error:
        shown = "".join(traceback.format_exception(error))
    assert shown.endswith("= help: did you mean `real`?\n")


def loaded(folder: Path, text: str) -> Any:
    path = folder / "model.arael"
    path.write_text(text)
    return arael.load(path, interpret=True)


def test_an_attribute_error_of_python_has_the_suggestion(tmp_path: Path) -> None:
    model = loaded(tmp_path, "root R { param xs: real\n constraint c { xs } }")(xs=1.0)
    with pytest.raises(AttributeError, match="did you mean"):
        model.xz  # noqa: B018


def test_free_directions_are_named_in_the_text(tmp_path: Path) -> None:
    text = "root R { param left: real; param right: real\n constraint c { left - right } }"
    model = loaded(tmp_path, text)(left=0.0, right=0.0)
    with pytest.raises(AraelError, match=r"free direction: .*left.*right"):
        model.covariance().marginal("left")


def test_many_diagnostics_are_cut_to_the_first_ten() -> None:
    many = [Diagnostic("E0203", f"number {i}") for i in range(500)]
    shown = str(AraelError(many))
    assert "number 9" in shown
    assert "number 10" not in shown
    assert shown.endswith("and 490 more")


def test_the_text_is_made_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> str:
        raise AssertionError("rendered too early")

    monkeypatch.setattr("arael.diagnostics.render.render", refuse)
    AraelError(FOUND)


def test_the_representation_holds_no_source_text() -> None:
    long = Source("m.arael", "root R { x: rael }" + "#" * 100_000)
    error = AraelError([Diagnostic("E0203", "unknown type", Span(long, 12, 16))] * 3)
    assert repr(error) == "<AraelError m.arael:1:13: error[E0203]: unknown type and 2 more>"


def test_an_error_survives_another_process() -> None:
    again = pickle.loads(pickle.dumps(AraelError(FOUND)))
    assert str(again) == str(AraelError(FOUND))


def test_notebooks_display_the_whole_text() -> None:
    shown: list[str] = []

    class Printer:
        def text(self, text: str) -> None:
            shown.append(text)

    AraelError(FOUND)._repr_pretty_(Printer(), False)
    assert shown == [str(AraelError(FOUND))]
