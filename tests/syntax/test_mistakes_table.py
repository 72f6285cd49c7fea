"""The table of mistakes of syntax: every row is complete, and can be reached."""

from __future__ import annotations

import contextlib
import re
import string
from pathlib import Path

import pytest

from arael.diagnostics import explain
from arael.diagnostics.explain import codes
from arael.diagnostics.records import AraelError, Source
from arael.syntax import mistakes, tables
from arael.syntax.mistakes.table import CLASSES, Mistake
from arael.syntax.parser import parse
from arael.syntax.trouble import Trouble

KINDS = ("token", "before", "ahead", "second", "opener", "construct", "block")
TERMINALS = ("within", "outside", "expected", "accepted")
OPERATIONS = {"skip", "skip_to", "skip_past", "insert", "swap", "pop", "panic"}


def known_types() -> set[str]:
    grammar = tables.load()
    words = {*grammar.words.values(), *grammar.symbols.values(), *grammar.patterns}
    return words | set(CLASSES) | {"name", "word", "none", "meant"} | {"$END", "_NEWLINE"}


@pytest.mark.parametrize("row", mistakes.TABLE, ids=lambda row: f"{row.code} {row.message[:40]}")
def test_a_row_names_codes_types_and_operations_that_exist(row: Mistake) -> None:
    assert row.code in codes()
    for name in (*KINDS, *TERMINALS):
        assert set(getattr(row, name).split()) <= known_types(), name
    if isinstance(row.repair, str):
        assert {step.split()[0] for step in row.repair.split("; ")} <= OPERATIONS


@pytest.mark.parametrize("row", mistakes.TABLE, ids=lambda row: f"{row.code} {row.message[:40]}")
def test_names_in_texts_come_from_the_tokens_or_a_condition(row: Mistake) -> None:
    always = {"token", "before", "ahead", "construct", "opener"}
    texts = (row.message, row.label, row.help, row.note, row.related[1] if row.related else "")
    named = {n for text in texts for _, n, _, _ in string.Formatter().parse(text) if n is not None}
    if named - always - ({"meant"} if row.meant or row.near else set()):
        assert row.when is not None, named


# A text for each row that the files in `messages` and the pages of the codes do not show.
FURTHER = [
    ("struct 3 { }", "the struct needs a name"),
    ("root R {\n    gain\n    x: real\n}", "field `gain` has no type"),
    ("struct Pose { loss\n pos: vec3 }", "field `loss` has no type"),
    ("root R { param x: real; constraint c { let y = x = 2; y } }", "a second `=` in one"),
    ("constraint { x }", "`constraint` outside of a struct"),
    ("fn f(x) real = x", "a function declares no type"),
    ("root R { param x: real; constraint c whem x > 1 { x } }", "unknown word `whem`"),
    ("root R { param x: real; constraint c\n}", "this constraint has no braces"),
    ("struct A with { x: real }", "expected `{` after the header of this struct"),
    ("struct A(x)\n{ x: real }", "expected `{` after the header of this struct"),
    (
        "root R { param x: real; constraint c { let real y = x; y } }",
        "`real` does not belong in a `let`",
    ),
    ("root R { param x: real; constraint c { let y == x; y } }", "`=` is missing in this `let`"),
    ("root R { param x: real; constraint c { x[0] = 1 } }", "a value gets its name with `let`"),
    ("root R { param x: real; constraint c { double y = x; y } }", "a value gets its name"),
    ("root R { param x: real; constraint c into a, b { x } }", "several blocks are written in"),
    ("root R {\nparam x: real\nconstraint c {\nlet y\ny } }", "`=` is missing in this `let`"),
]


@pytest.mark.parametrize(("text", "message"), FURTHER)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(AraelError) as caught:
        parse(Source("m", text))
    assert message in caught.value.diagnostics[0].message


def test_every_row_is_reached_by_a_text_of_these_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    reached: set[Mistake] = set()
    report = Mistake.report

    def reporting(self: Mistake, t: Trouble, names: dict[str, str]) -> None:
        reached.update(row for row in mistakes.TABLE if row is self)
        report(self, t, names)

    monkeypatch.setattr(Mistake, "report", reporting)
    pages = (Path(explain.__file__).parent / "pages").glob("*.md")
    shown = [*(Path(__file__).parent / "messages").glob("*.md"), *pages]
    texts = [text for text, _ in FURTHER]
    for path in shown:
        texts += re.findall(r"```\w*\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
    for text in texts:
        with contextlib.suppress(AraelError):
            parse(Source("m", text))
    left = [n for n, row in enumerate(mistakes.TABLE) if row not in reached]
    assert left == []
