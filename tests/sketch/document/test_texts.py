"""Which texts a sketch may hold, in documents too."""

from __future__ import annotations

import msgspec
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, to_json
from arael.sketch.document.texts import MAX_TEXT, normalized, problem_of

REFUSED = {
    "": "at least one character",
    "   ": "at least one character",
    "a\nb": "one line",
    "a\u2028b": "one line",
    "a\tb": "U+0009",
    "a\x00": "U+0000",
    "\x1b[31mred": "U+001B",
    "\u202eabc": "U+202E",
    "a\u200bb": "U+200B",
    "a\ud800": "U+D800",
    "x" * (MAX_TEXT + 1): "at most 200",
    "x" * 1_000_000: "at most 200",
}


@pytest.mark.parametrize("text", REFUSED, ids=lambda text: repr(text[:12]))
def test_a_text_that_cannot_be_is_refused_with_the_reason(text: str) -> None:
    assert REFUSED[text] in problem_of(text)


@pytest.mark.parametrize("text", ["M6", 'say "hi"', "שלום", "日本", "; # ' <b>&amp;", "x" * 200])
def test_any_other_line_is_a_text(text: str) -> None:
    assert problem_of(text) == ""


def test_letters_with_marks_are_composed() -> None:
    assert normalized("Gro\u0308ße") == "Größe"


def saved(text: str, kind: str = "line") -> bytes:
    document = Document()
    with document.transaction("text"):
        document.add_entity(kind, [0, 0, 5, 0] if kind == "line" else [0, 0, 1], text="title")
    data = msgspec.json.decode(to_json(document))
    data["entities"][0]["text"] = text
    return msgspec.json.encode(data)


def test_a_saved_text_comes_back() -> None:
    text = 'Ø8 "x" → ש'
    document = from_json(saved(text))
    assert document.entities["L0"].text == text
    assert to_json(from_json(to_json(document))) == to_json(document)


@pytest.mark.parametrize(
    ("text", "kind"), [("a\nb", "line"), ("\u202ea", "line"), (" ", "line"), ("a", "circle")]
)
def test_a_file_with_a_text_that_cannot_be_is_refused_with_its_place(text: str, kind: str) -> None:
    with pytest.raises(AraelError) as caught:
        from_json(saved(text, kind))
    (found,) = caught.value.diagnostics
    assert found.code == "E1211" and found.message.startswith("entities[0]: ")
