"""Models of several files, and of several roots."""

from __future__ import annotations

import pytest

from arael.check.check import check
from arael.check.typed import TypedModel
from arael.diagnostics.records import AraelError, Findings, Source
from arael.syntax import tree
from arael.syntax.parser import parse
from tests.check.models import checked, diagnostics


def load_all(files: dict[str, str]) -> TypedModel:
    def load(item: tree.Import) -> tree.File:
        return parse(Source(item.path.value, files[item.path.value]))

    return check(parse(Source("main", files["main"])), load=load, findings=Findings())


def test_items_of_imported_files_are_visible_and_count_once() -> None:
    model = load_all(
        {
            "main": 'import "a"\nimport "b"\n'
            "root R { ps: list of P; param x: real; constraint c { twice(x) * K } }",
            "a": 'import "base"\nstruct P { param y: real; constraint c { twice(y) } }',
            "b": 'import "base"\nconst K = 3',
            "base": "fn twice(x) = 2 * x",
        }
    )
    assert [c.label for c in model.constraints] == ["R.c", "P.c"]


def test_a_circle_of_imports_is_told() -> None:
    with pytest.raises(AraelError) as error:
        load_all({"main": 'import "a"', "a": 'import "b"', "b": 'import "a"'})
    assert error.value.diagnostics[0].code == "E0212"
    assert "a -> b -> a" in error.value.diagnostics[0].message


def test_the_same_name_in_two_files_is_told() -> None:
    with pytest.raises(AraelError) as error:
        load_all({"main": 'import "a"\nconst K = 1\nroot R { x: real }', "a": "const K = 2"})
    first = error.value.diagnostics[0]
    assert first.code == "E0206"
    assert first.span is not None
    assert (first.span.source.name, first.labels[0].span.source.name) == ("main", "a")


ROOTS = """
struct P { param x: real; constraint c { x } }
root Slam { ps: list of P }
root Localization { qs: list of P }
"""


def test_one_of_several_roots_is_chosen_by_name() -> None:
    assert checked(ROOTS, root="Localization").tables[1].path == "qs"
    assert checked(ROOTS, root="Slam").tables[1].path == "ps"


def test_a_misspelt_root_gets_a_suggestion() -> None:
    (found,) = diagnostics(ROOTS, root="Slamm")
    assert (found.code, found.help) == ("E0210", ("did you mean `Slam`?",))
