"""Live expressions of a document: order, cycles, what is broken, derivatives, renaming."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.runtime.machine.programs import evaluate
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Dimension, Parameter
from arael.sketch.document.saved import from_json, to_json
from arael.sketch.expressions import refresh as refreshing
from arael.sketch.expressions.dependencies import cycle_through, ordered, readers
from arael.sketch.expressions.evaluation import number
from arael.sketch.expressions.gradient import program
from arael.sketch.expressions.reading import literal
from arael.sketch.expressions.refresh import follows_geometry, refresh
from arael.sketch.expressions.renaming import rename_everywhere, renamed
from arael.sketch.expressions.scope import DocumentScope


@pytest.fixture
def document() -> Document:
    made = Document()
    with made.transaction("make"):
        made.add_entity("line", (0, 0, 3, 4))
        made.add_entity("line", (1, 1, 5, 2))
        made.add_entity("point", (8, 9))
        made.add_entity("arc", (0, 0, 2, 0, 0, 2, 2))
    return made


def param(document: Document, **texts: str) -> None:
    with document.transaction("param"):
        for name, text in texts.items():
            document.put("parameters", Parameter(name, Amount(text, literal(text) or 0.0)))
        refresh(document)


def value(document: Document, name: str) -> float:
    return document.parameters[name].amount.number


def test_values_follow_in_order(document: Document) -> None:
    param(document, c="b + 1", b="a*2", a="3 + 1", free="7")
    assert [value(document, name) for name in "abc"] == [4, 8, 9]
    param(document, a="10 + 0")
    assert [value(document, name) for name in "abc"] == [10, 20, 21]


def test_what_reads_geometry_follows_it(document: Document) -> None:
    param(document, a="L0.length", b="a + k", k="3", c="k*2")
    assert [follows_geometry(document, name) for name in ("a", "b", "c")] == [True, True, False]
    with document.transaction("move"):
        document.set_values([2, 3], [6, 8])
        assert sorted(refresh(document)) == ["a", "b"]
    assert value(document, "b") == 13


def test_a_sketch_of_literals_has_nothing_to_do(document: Document) -> None:
    param(document, a="3")
    assert refreshing._LIVE[document].names == {}
    assert refresh(document) == []


def test_undo_and_loading_keep_up(document: Document) -> None:
    param(document, a="L0.length*2")
    document.undo()
    assert refreshing._LIVE[document].names == {}
    document.redo()
    assert list(refreshing._LIVE[document].names) == ["a"]
    again = from_json(to_json(document))
    with again.transaction("move"):
        again.set_values([2, 3], [6, 8])
        refresh(again)
    assert value(again, "a") == 20


def test_what_is_gone_breaks_and_keeps_its_value(document: Document) -> None:
    param(document, a="L1.length", b="a*2", k="5 + 0")
    before = value(document, "a")
    with document.transaction("delete"):
        document.remove("entities", "L1")
        refresh(document)
    assert document.parameters["a"].broken == "no parameter, dimension or entity `L1`"
    assert document.parameters["b"].broken == "it reads `a`, which has no value"
    assert not document.parameters["k"].broken
    assert value(document, "a") == before
    document.undo()
    assert not document.parameters["a"].broken
    param(document, a="4*1")
    assert value(document, "b") == 8
    assert not document.parameters["b"].broken


def test_cycles_are_marked_with_their_way(document: Document) -> None:
    param(document, a="1 + 1", b="a + 1")
    param(document, a="b")
    assert document.parameters["a"].broken == "it reads itself: a -> b -> a"
    assert value(document, "b") == 3
    param(document, a="7*1")
    assert (value(document, "b"), document.parameters["b"].broken) == (8, "")


def test_the_way_of_a_cycle(document: Document) -> None:
    param(document, a="1", b="a", c="b + a")
    assert cycle_through(document, "a", ["c*2"]) in (["a", "c", "b", "a"], ["a", "c", "a"])
    assert cycle_through(document, "x", ["c*2"]) == []
    assert cycle_through(document, "a", ["a"]) == ["a", "a"]


def test_order_of_a_deep_chain(document: Document) -> None:
    names = [f"p{i}" for i in range(5000)]
    with document.transaction("param"):
        for one, other in pairwise(names):
            document.put("parameters", Parameter(one, Amount(other, 0.0)))
        document.put("parameters", Parameter(names[-1], Amount("3", 3.0)))
    order, cycles = ordered(document, document.parameters)
    assert order == names[::-1]
    assert cycles == []


def test_dimensions_are_read_and_follow(document: Document) -> None:
    with document.transaction("dims"):
        document.put("dimensions", Dimension("d0", "length", ("L0",), Amount("5", 5.0)))
        document.put("dimensions", Dimension("d1", "length", ("L1",), Amount("d0*2", 0.0)))
        document.put(
            "dimensions",
            Dimension("d2", "angle", ("L0", "L1"), Amount("-d0", 0.0), side=1),
        )
        refresh(document)
    assert document.dimensions["d1"].value == Amount("d0*2", 10.0)
    assert document.dimensions["d2"].value == Amount("-d0", 5.0)
    assert readers(document, "d0") == ["d1", "d2"]


def test_a_unit_that_does_not_fit_breaks(document: Document) -> None:
    param(document, a="30 deg")
    with document.transaction("dims"):
        document.put("dimensions", Dimension("d0", "length", ("L0",), Amount("30 deg*2", 5.0)))
        refresh(document)
    assert document.dimensions["d0"].broken == "expected a length, found an angle"


# --- derivatives ----------------------------------------------------------------------------

LIVE = [
    "L0.length*2 + 1",
    "(L0.length + 1)*2 - (3 - k)/(L0.length - 1)^2/2",
    "1.01^2^L0.length*(k - L0.length)",
    "(L0.length^2)^3 - -L0.length",
    "+".join(["P0.x"] * 300),
    "v*k",
    "sqrt(P0.x^2 + P0.y^2)",
    "dist(P0, L0.p2)",
    "dist(P0, L1)",
    "dist(L1, P0)*k",
    "sin(L0.angle) * A0.radius",
    "A0.sweep/2 + 1 deg",
    "angle(L0, L1)",
    "max(L0.length, k, 2)",
    "if L0.length > 3 then L0.p2.x else k",
    "d9 + hd",
    "min(k, 3) * 1 in + pi*A0.diameter",
]


@pytest.mark.parametrize("text", LIVE)
def test_programs_have_the_value_and_its_derivatives(document: Document, text: str) -> None:
    param(document, k="4", v="L0.length + L1.p1.y")
    with document.transaction("dims"):
        derived = Dimension("d9", "length", ("L1",), Amount("4", 4.0), derived=True)
        document.put("dimensions", derived)
        document.put(
            "dimensions", replace(derived, name="hd", kind="hdistance", args=("L0.p1", "P0"))
        )
        refresh(document)
    scope = DocumentScope(document, refreshing._measure(document))
    made = program(document, text)
    inputs = [number(path, scope) for path in (*made.geometry, *made.numbers)]
    outputs = [float(np.asarray(x)) for x in evaluate(made.tape, [np.array(x) for x in inputs])]
    assert outputs[0] == pytest.approx(number(text, scope))
    for i in range(len(made.geometry)):
        step = 1e-6
        found = []
        for sign in (1, -1):
            moved = [np.array(x + sign * step * (j == i)) for j, x in enumerate(inputs)]
            found.append(float(np.asarray(evaluate(made.tape, moved)[0])))
        assert outputs[1 + i] == pytest.approx(
            (found[0] - found[1]) / (2 * step), rel=1e-7, abs=1e-6
        )


def test_parameters_that_do_not_follow_are_numbers(document: Document) -> None:
    param(document, k="4", v="L0.length*k", u="k*2")
    made = program(document, "v + u")
    assert made.geometry == ("L0.length",)
    assert made.numbers == ("k", "u")


def test_constants_of_models_are_names_here(document: Document) -> None:
    param(document, e="3", epsilon="L0.length*e")
    made = program(document, "epsilon + e")
    assert (made.geometry, made.numbers) == (("L0.length",), ("e",))
    found = evaluate(made.tape, [np.array(5.0), np.array(3.0)])
    assert float(np.asarray(found[0])) == 18


def test_functions_that_cannot_be_followed(document: Document) -> None:
    with pytest.raises(AraelError) as caught:
        program(document, "midpoint(L0).x")
    assert caught.value.diagnostics[0].code == "E1254"


def test_programs_are_compiled_once(document: Document) -> None:
    assert program(document, "L0.length*2").tape is program(document, "L0.length*2").tape


# --- renaming -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "names", "expected"),
    [
        ("width*2 + widths", {"width": "w"}, "w*2 + widths"),
        ("  L0.length *2# ".rstrip("# "), {"L0": "L7"}, "  L7.length *2"),
        ("L0.p1.x + L0.p2.x", {"L0.p1": "L5.p1", "L0.p2": "L6.p2"}, "L5.p1.x + L6.p2.x"),
        ("2*L0.length", {"L0.length": "(L1.length + L2.length)"}, "2*(L1.length + L2.length)"),
        ("dist(P0, L0)", {"P0": "L3.p1", "L0": "L4"}, "dist(L3.p1, L4)"),
        ("12 mm + w", {"mm": "x", "w": "v"}, "12 mm + v"),
        ("sin(w)", {"sin": "x"}, "sin(w)"),
        ("L0.length", {"L0": "L1", "L0.length": "L2.length"}, "L2.length"),
        ("3", {"w": "v"}, "3"),
        ("broken ((", {"broken": "v"}, "broken (("),
    ],
)
def test_renaming_keeps_the_rest(text: str, names: dict[str, str], expected: str) -> None:
    assert renamed(text, names) == expected


def test_renaming_everywhere(document: Document) -> None:
    param(document, a="L0.length", b="a + L1.length")
    with document.transaction("rename"):
        document.put(
            "dimensions",
            Dimension("d0", "length", ("L1",), low=Amount("a", 5.0), high=Amount("9", 9.0)),
        )
        assert rename_everywhere(document, {"a": "x", "L1": "L0"}) == ["b", "d0"]
    assert document.parameters["b"].amount.text == "x + L0.length"
    low = document.dimensions["d0"].low
    assert low is not None
    assert low.text == "x"
    assert math.isfinite(low.number)
