"""One list of words: the grammar's, in every tool that colours models."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest
from pygments.lexers import load_lexer_from_file
from pygments.token import Comment, Error, Keyword, Name, Number, Operator

from arael.check.builtins import FUNCTIONS
from arael.check.losses import LOSSES
from arael.check.types import TYPE_NAMES
from arael.diagnostics.records import AraelError, Source
from arael.highlighting import words
from arael.highlighting.__main__ import files
from arael.highlighting.keywords import KEYWORDS, NAMES
from arael.highlighting.lexer import AraelLexer
from arael.syntax import tables
from arael.syntax.parser import parse

CHECKOUT = Path(__file__).parents[2]
GRAMMAR = tables.load().words

# Each word at a place where it is a keyword.
PLACES = {
    "of": "a: list of B",
    "list": "a: list of B",
    "deque": "a: deque of B",
    "arena": "a: arena of B",
    "ref": "a: ref B in root.b",
    "in": "a: ref B in root.b",
    "block": "h: block pose",
    "triplets": "h: triplets",
    "when": "constraint c when x {",
    "loss": "constraint c loss huber(1) {",
    "into": "constraint c into h {",
    "as": "fit data as e {",
    "fit": "fit data as e {",
    "derivs": "fn f(x) derivs [1] = x",
    "then": "if a then b else c",
    "else": "if a then b else c",
    "key": "key name",
    "marginalize": "marginalize points",
    "solve": "solve {",
    "update": "update {",
    "freeze": "freeze poses",
    "free": "free poses",
    "fixed": "fixed pos.x",
    "prior": "prior a ~ normal(0, 1)",
}


def test_every_word_of_the_grammar_is_in_one_group() -> None:
    assert set(KEYWORDS) == set(GRAMMAR)
    grouped = {
        *words.RESERVED, *words.CONTEXTUAL, *words.VALUES, *words.ENTITIES, *words.LOGIC,
        *words.BRANCHES,
    }  # fmt: skip
    assert grouped == set(GRAMMAR)
    assert set(FUNCTIONS) | set(LOSSES) <= set(words.BUILTINS)
    assert set(words.TYPES) == TYPE_NAMES


@pytest.mark.parametrize("word", sorted(GRAMMAR))
def test_the_words_that_may_be_names_are_those_of_the_grammar(word: str) -> None:
    body = f"let {word} = a\n        a"
    text = f"root M {{\n    param a: real\n    constraint c {{\n        {body}\n    }}\n}}\n"
    try:
        parse(Source("m.arael", text))
    except AraelError:
        assert word not in NAMES
    else:
        assert word in NAMES


@pytest.mark.parametrize("word", sorted(GRAMMAR))
def test_each_word_is_coloured_by_pygments_and_textmate(word: str) -> None:
    text = PLACES.get(word, f"{word} x {{")
    kinds = {value: kind for kind, value in AraelLexer().get_tokens(text)}
    assert any(kinds[word] in kind for kind in (Keyword, Operator.Word, Name.Builtin.Pseudo))
    grammar = json.loads(files()["editors/vscode/syntaxes/arael.tmLanguage.json"])
    at = text.index(word)
    first = _first_match(grammar, text, at)
    assert re.match(r"storage|keyword|constant\.language|variable\.language", first), first


def _first_match(grammar: dict[str, object], text: str, at: int) -> str:
    """Scope of the text at `at` by the first pattern that covers it, as an editor chooses."""
    position = 0
    while position <= at:
        found = []
        for n, pattern in enumerate(grammar["patterns"]):  # type: ignore[var-annotated,arg-type]
            match = re.compile(pattern.get("match") or pattern["begin"]).search(text, position)
            if match and match.end() > match.start():
                found.append((match.start(), n, match, pattern))
        if not found:
            return ""
        _, _, match, pattern = min(found, key=lambda f: f[:2])
        if match.start() <= at < match.end():
            for number, capture in pattern.get("captures", {}).items():
                if match.start(int(number)) <= at < match.end(int(number)):
                    return str(capture["name"])
            return str(pattern.get("name", ""))
        position = match.end()
    return ""


def test_a_contextual_word_is_a_name_elsewhere() -> None:
    kinds = dict((v, k) for k, v in AraelLexer().get_tokens("loss: real [m]\nx = key + free * 2"))
    assert kinds["loss"] not in Keyword
    assert kinds["key"] not in Keyword
    assert kinds["free"] not in Keyword
    assert kinds["[m]"] is Number.Unit


def test_models_have_no_unknown_character() -> None:
    models = sorted(CHECKOUT.glob("models/*.arael"))
    assert models
    for path in models:
        kinds = list(AraelLexer().get_tokens(path.read_text()))
        assert not [v for k, v in kinds if k is Error], path
        assert any(k is Comment.Single for k, _ in kinds)
        assert "".join(v for _, v in kinds) == path.read_text()


def test_committed_grammars_are_those_that_the_tables_give() -> None:
    for name, text in files().items():
        assert (CHECKOUT / name).read_text() == text, "run `python -m arael.highlighting`"


def test_vim_has_every_word() -> None:
    text = files()["editors/vim/syntax/arael.vim"]
    for word in (*GRAMMAR, *words.TYPES, *words.BUILTINS):
        assert re.search(rf"(?<![A-Za-z0-9_]){word}(?![A-Za-z0-9_])", text), word


def test_pygments_finds_the_lexer_by_its_entry_point() -> None:
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    module, _, name = project["entry-points"]["pygments.lexers"]["arael"].partition(":")
    path = CHECKOUT / (module.replace(".", "/") + ".py")
    assert load_lexer_from_file(str(path), name).name == "arael"


def test_the_extension_names_files_that_exist() -> None:
    folder = CHECKOUT / "editors/vscode"
    package = json.loads((folder / "package.json").read_text())
    contributes = package["contributes"]
    assert contributes["languages"][0]["extensions"] == [".arael"]
    assert (folder / contributes["languages"][0]["configuration"]).is_file()
    assert (folder / contributes["grammars"][0]["path"]).is_file()
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    assert package["version"] == project["version"]
