"""Whatever the text: `parse` returns or raises `AraelError`, soon; what parses can be formatted."""

import random
import string
import time

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from arael.diagnostics.records import AraelError, Source
from arael.diagnostics.render import render
from arael.syntax.fmt import format_source
from arael.syntax.limits import MAX_BYTES, MAX_ERRORS
from arael.syntax.parser import parse, parse_expression
from tests.syntax.models import WHOLE, grammatical, mutated


def check(text: str) -> bool:
    """Parse `text`; if it is valid, check its formatting. Return whether it is valid."""
    try:
        tree = parse(Source("m", text))
    except AraelError as error:
        assert 1 <= len(error.diagnostics) <= MAX_ERRORS
        for d in error.diagnostics:
            assert d.span is not None
            assert 0 <= d.span.start <= d.span.end <= len(text)
            assert "unexpected token" not in d.message
        assert render(error.diagnostics)
        return False
    once = format_source(Source("m", text))
    assert parse(Source("m", once)) == tree
    assert [c.text.lstrip("# ") for c in parse(Source("m", once)).comments] == [
        c.text.lstrip("# ") for c in tree.comments
    ]
    assert format_source(Source("m", once)) == once
    return True


@settings(max_examples=30)
@given(grammatical)
@example(WHOLE)
def test_texts_of_the_grammar(text: str) -> None:
    check(text)


@pytest.mark.slow
@settings(max_examples=400)
@given(grammatical)
def test_many_texts_of_the_grammar(text: str) -> None:
    check(text)


@pytest.mark.slow
@settings(max_examples=60)
@given(mutated())
def test_mutated_models(text: str) -> None:
    check(text)


@pytest.mark.slow
@settings(max_examples=1000)
@given(mutated())
def test_many_mutated_models(text: str) -> None:
    check(text)


@settings(max_examples=200)
@given(st.text(alphabet=string.printable + "éσ\u202e\0", max_size=200))
def test_random_text(text: str) -> None:
    check(text)


def test_the_whole_language_is_good() -> None:
    assert check(WHOLE)


@pytest.mark.parametrize("seed", range(3))
def test_shuffled_tokens(seed: int) -> None:
    words = WHOLE.split(" ")
    random.Random(seed).shuffle(words)
    check(" ".join(words))


FOUND = {
    "a misspelt word shorter than the right one": "component C {\n    constraina { x }\n}",
}


@pytest.mark.parametrize("name", FOUND)
def test_texts_that_failed_before(name: str) -> None:
    check(FOUND[name])


HOSTILE = {
    "brackets": "(" * 100_000,
    "braces": "{" * 100_000,
    "closers": "}" * 100_000,
    "signs": "root R { constraint a { " + "-" * 50_000 + "x } }",
    "nots": "root R { constraint a { " + "not " * 50_000 + "x } }",
    "sum": "root R { constraint a { " + "x + " * 20_000 + "x } }",
    "powers": "root R { constraint a { " + "x^" * 49_000 + "x } }",
    "ifs": "root R { constraint a { " + "if a then b else " * 10_000 + "x } }",
    "quotes": "root R { constraint a { x" + "'" * 50_000 + " } }",
    "calls": "root R { constraint a { f" + "(1)" * 20_000 + " } }",
    "dots": "root R { constraint a { f" + ".x" * 20_000 + " } }",
    "name": "x" * 900_000,
    "digits": "root R { x: real = " + "9" * 900_000 + " }",
    "dimension": "root R { x: vec<" + "9" * 50 + "> }",
    "newlines": "\n" * 1_000_000,
    "semicolons": ";" * 300_000,
    "comments": "#\n" * 400_000,
    "strings": '"' * 500_000,
    "escapes": 'import "' + "\\q" * 100_000 + '"',
    "fields": "struct A {\n" + "x: real\n" * 50_000 + "}",
    "broken fields": "struct A {\n" + "x real\n" * 50_000 + "}",
    "structs": "struct A {\n" * 50_000,
    "garbage": "".join(random.Random(1).choices(string.printable, k=MAX_BYTES)),
    "unicode": "\u202e\u00e9\u4e2d" * 300_000,
    "one line": "root R { " + "x: real; " * 20_000 + "y real }",
}


# Each takes seconds, and fails as others do.
LONG = {"closers", "newlines", "comments", "one line"}


@pytest.mark.sweep(3, slow=("semicolons", "powers"))
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in HOSTILE]
)
def test_hostile_text_takes_little_time(name: str) -> None:
    start = time.process_time()
    source = Source("m", HOSTILE[name])
    try:
        parse(source)
    except AraelError as error:
        text = render(error.diagnostics, width=100)
        assert len(text) < 40_000
        assert max(map(len, text.splitlines())) < 400
    assert time.process_time() - start < 10


def test_ten_megabytes_are_refused_unread() -> None:
    with pytest.raises(AraelError) as caught:
        parse(Source("m", "x: real\n" * 1_250_000))
    assert [d.code for d in caught.value.diagnostics] == ["E0104"]


@given(st.text(alphabet="ab1.+-*/^()[]' ,|<=\n", max_size=40))
def test_formulas(text: str) -> None:
    try:
        parse_expression(Source("formula", text))
    except AraelError as error:
        assert error.diagnostics
