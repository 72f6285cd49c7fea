"""Imports and solve schedules."""

from __future__ import annotations

from arael.syntax.mistakes.table import Mistake, Names
from arael.syntax.trouble import Trouble


def _file_name(t: Trouble) -> Names:
    return {"name": t.token.text if t.is_word(t.token) else "file"}


def _insert_pass(t: Trouble) -> None:
    if t.ahead().type == "LBRACE":
        t.insert("PASS")
    else:
        t.panic()


ROWS = (
    Mistake(
        "E0112", "`import` takes the name of a file in quotes", "expected a text after this",
        help='write `import "{name}.arael"`', place="before",
        before="IMPORT", last=True, when=_file_name,
    ),
    Mistake(
        "E0135", "`:` where `=` belongs", "a setting is written `{before} = value`",
        token="COLON", block="PASS UPDATE", expected="EQUAL", repair="swap EQUAL",
    ),
    Mistake(
        "E0128", "`{token}` without `pass`", "a solve schedule holds passes",
        help="write `pass {token} {{ ... }}`",
        token="name", block="SOLVE", accepted="PASS", repair=_insert_pass,
    ),
)  # fmt: skip
