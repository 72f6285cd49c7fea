"""Diagnostics as text and as data."""

import io
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arael.diagnostics.as_json import as_json
from arael.diagnostics.cells import width
from arael.diagnostics.records import Diagnostic, Label, Source, Span
from arael.diagnostics.render import render
from arael.diagnostics.style import use_color

SOURCE = Source("m.arael", "struct A {\n    x: real\n    y: vec3\n}\nroot R {\n\ta: list of A\n}\n")


def at(text: str, source: Source = SOURCE) -> Span:
    start = source.text.index(text)
    return Span(source, start, start + len(text))


def test_one_label() -> None:
    d = Diagnostic("E0201", "unknown type `vec3`", at("vec3"), "not known", help=("use `vec2`",))
    assert render([d]) == (
        "error[E0201]: unknown type `vec3`\n"
        " --> m.arael:3:8\n"
        "  |\n"
        "3 |     y: vec3\n"
        "  |        ^^^^ not known\n"
        "  |\n"
        "  = help: use `vec2`\n"
    )


def test_labels_on_one_line_and_on_others() -> None:
    d = Diagnostic(
        "E0301", "shapes differ", at(": real"), "a scalar",
        labels=(Label(at("x"), "this field"), Label(at("vec3"), "a vector")),
        notes=("first", "second"),
    )  # fmt: skip
    assert render([d]) == (
        "error[E0301]: shapes differ\n"
        " --> m.arael:2:6\n"
        "  |\n"
        "2 |     x: real\n"
        "  |     -^^^^^^ a scalar\n"
        "  |     |\n"
        "  |     this field\n"
        "3 |     y: vec3\n"
        "  |        ---- a vector\n"
        "  |\n"
        "  = note: first\n"
        "  = note: second\n"
    )


def test_span_over_lines() -> None:
    d = Diagnostic("E0130", "empty", Span(SOURCE, 9, SOURCE.text.index("}") + 1), "all of this")
    assert render([d]) == (
        "error[E0130]: empty\n"
        " --> m.arael:1:10\n"
        "  |\n"
        "1 | struct A {\n"
        "  |          ^\n"
        "...\n"
        "4 | }\n"
        "  | ^ all of this\n"
    )


def test_tabs_and_wide_characters() -> None:
    tab = Diagnostic("E0201", "m", at("list of A"), "here")
    assert "6 |     a: list of A\n  |        ^^^^^^^^^ here\n" in render([tab])
    wide = Source("w", "# 姿勢 x\n")
    d = Diagnostic("E0201", "m", at("x", wide), "here")
    assert "1 | # 姿勢 x\n  |        ^ here\n" in render([d])
    d = Diagnostic("E0201", "m", at("姿勢", wide), "here")
    assert "1 | # 姿勢 x\n  |   ^^^^ here\n" in render([d])


def test_other_files_have_windows_of_their_own() -> None:
    other = Source("other.arael", "struct B { x: real }\n")
    d = Diagnostic("E0202", "twice", at("x"), "again", labels=(Label(at("x", other), "first"),))
    text = render([d])
    assert " --> m.arael:2:5\n" in text
    assert " ::: other.arael:1:12\n" in text


def test_origin_where_there_is_no_text() -> None:
    d = Diagnostic("E0703", "missing key", origin="scene.json: poses[3]", help=("add it",))
    assert render([d]) == ("error[E0703]: missing key\n --> scene.json: poses[3]\n  help: add it\n")


def test_several_are_counted() -> None:
    d = Diagnostic("E0201", "m", at("x"))
    w = Diagnostic("W0201", "m", at("y"), severity="warning")
    assert render([d, d, w]).endswith("\n2 errors\n")
    assert "warning[W0201]: m" in render([w])
    assert render([]) == ""


def test_the_end_of_the_text_and_beyond_a_line() -> None:
    source = Source("m", "root R {")
    end = len(source.text)
    assert "1 | root R {\n  |         ^ ends\n" in render(
        [Diagnostic("E0120", "m", Span(source, end, end), "ends")]
    )
    assert render([Diagnostic("E0120", "m", Span(Source("m", ""), 0, 0), "ends")])


def test_long_lines_are_cut_around_the_mark() -> None:
    source = Source("m", "x" * 5_000_000 + "HERE" + "y" * 5_000_000)
    text = render([Diagnostic("E0110", "m", at("HERE", source), "look")], width=80)
    assert max(map(len, text.splitlines())) <= 80
    line, marks = text.splitlines()[3:5]
    assert line[marks.index("^") :].startswith("HERE")
    assert line.count("...") == 2


def test_nothing_steers_the_terminal() -> None:
    source = Source("\x1b[31mname", "x \x1b]0;title\x07 \u202e y\n")
    d = Diagnostic(
        "E0110", "bad \x1b[2J", Span(source, 0, 1), "\x07", notes=("\x1b[0m",), help=("\u202e",)
    )
    text = render([d])
    assert not any(c in text for c in "\x1b\x07\u202e")
    assert "\x1b[1;31merror" in render([d], color=True)


def test_colors_change_nothing_but_colors() -> None:
    import re

    d = Diagnostic("E0301", "m", at("real"), "p", labels=(Label(at("x"), "s"),), help=("h",))
    assert re.sub(r"\x1b\[[0-9;]*m", "", render([d], color=True)) == render([d])


@given(
    st.text(st.sampled_from("ab\n\t 勢é\u0301\r\x1b"), max_size=60),
    st.lists(st.tuples(st.integers(0, 60), st.integers(0, 60), st.booleans()), max_size=4),
    st.integers(1, 120),
)
def test_any_spans_can_be_shown(
    text: str, places: list[tuple[int, int, bool]], columns: int
) -> None:
    source = Source("m", text)
    spans = [Span(source, min(a, b, len(text)), min(max(a, b), len(text))) for a, b, _ in places]
    labels = tuple(Label(s, "text" * named) for s, (_, _, named) in zip(spans, places, strict=True))
    d = Diagnostic("E0100", "m", spans[0] if spans else None, "p", labels=labels[1:])
    out = render([d], width=columns)
    assert out.startswith("error[E0100]: m\n")
    for line in out.splitlines():
        assert line == line.rstrip()
        assert width(line) <= max(columns, 40) + 40


@pytest.mark.parametrize(
    ("environment", "terminal", "expected"),
    [
        ({}, True, True),
        ({}, False, False),
        ({"NO_COLOR": "1"}, True, False),
        ({"NO_COLOR": ""}, True, True),
        ({"FORCE_COLOR": "1"}, False, True),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, True, False),
        ({"TERM": "dumb"}, True, False),
    ],
)
def test_use_color(
    monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], terminal: bool, expected: bool
) -> None:
    for name in ("NO_COLOR", "FORCE_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: terminal)
    assert use_color(stream) is expected


def test_json() -> None:
    d = Diagnostic(
        "E0301", "m", at("vec3"), "p", labels=(Label(at("x"), "s"),), notes=("n",), help=("h",)
    )
    (data,) = as_json([d])
    assert json.loads(json.dumps(data)) == data
    assert data == {
        "severity": "error", "code": "E0301", "message": "m", "file": "m.arael",
        "line": 3, "column": 8, "end_line": 3, "end_column": 12, "label": "p",
        "labels": [{"file": "m.arael", "line": 2, "column": 5, "end_line": 2, "end_column": 6,
                    "text": "s"}],
        "notes": ["n"], "help": ["h"],
    }  # fmt: skip
    (bare,) = as_json([Diagnostic("E0703", "m", origin="scene.json")])
    assert (bare["file"], bare["line"]) == ("scene.json", None)
