"""What is made from the table of commands: the manual page, the methods of `Sketch`."""

from __future__ import annotations

from pathlib import Path

from arael.sketch.commands import manual, python, table

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "sketch_commands.md"
METHODS = ROOT / "arael" / "sketch" / "methods.py"


def test_the_manual_page_is_that_of_the_table(update: bool) -> None:
    made = manual.full()
    if update:
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "run pytest --update"


def test_the_methods_are_those_of_the_table(update: bool) -> None:
    made = python.source()
    if update:
        METHODS.write_text(made, encoding="utf-8")
    assert METHODS.read_text(encoding="utf-8") == made, "run pytest --update"


def test_every_command_is_a_method() -> None:
    from arael.sketch.sketch import Sketch

    for name in table.commands():
        if name != "exit":
            method = getattr(Sketch, python.method_name(name))
            assert method.__doc__
