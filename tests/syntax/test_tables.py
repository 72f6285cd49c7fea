"""The tables beside the grammar are those of the grammar."""

import logging

import lark
import msgspec
from lark import Lark

from arael.syntax import tables


def test_tables_are_current() -> None:
    content = (tables.grammar_folder() / "arael.tables.json").read_bytes()
    kept = msgspec.json.decode(content, type=tables.Tables)
    made = tables.generate(tables.grammar_text())
    assert kept == made, "run: python -m arael.syntax.tables"


def test_grammar_has_no_conflicts() -> None:
    records: list[logging.LogRecord] = []
    handler = logging.Handler()
    handler.emit = records.append  # type: ignore[method-assign]
    level = lark.logger.level
    lark.logger.addHandler(handler)
    lark.logger.setLevel(logging.DEBUG)
    try:
        Lark(tables.grammar_text(), parser="lalr", start=list(tables.STARTS), debug=True)
    finally:
        lark.logger.removeHandler(handler)
        lark.logger.setLevel(level)
    assert [r.getMessage() for r in records if "onflict" in r.getMessage()] == []


def test_every_word_has_one_terminal() -> None:
    loaded = tables.load()
    assert loaded.words["constraint"] == "CONSTRAINT"
    assert loaded.spelling("CONSTRAINT") == "constraint"
    assert loaded.spelling("LBRACE") == "{"
    assert loaded.spelling("NAME") is None
