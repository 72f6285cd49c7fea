"""Scripts that are huge, deep, cyclic or strange. Errors E1260 and others."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands import table
from arael.sketch.commands.session import MAX_VARIABLES, Session
from arael.sketch.commands.tokens import MAX_LINE, MAX_STATEMENTS
from arael.sketch.document.saved import to_json
from arael.sketch.expressions.reading import MAX_LENGTH
from tests.sketch.stand_in import StandIn


@pytest.fixture
def session() -> Session:
    return Session(StandIn(), make_editor=StandIn)


def code(session: Session, text: str) -> str:
    with pytest.raises(AraelError) as caught:
        session.run(text)
    return caught.value.diagnostics[0].code


def test_a_line_that_is_too_long(session: Session) -> None:
    assert code(session, "msg " + "x" * MAX_LINE) == "E1260"


def test_too_many_commands_in_a_line(session: Session) -> None:
    assert code(session, ";".join(["dof"] * (MAX_STATEMENTS + 1))) == "E1260"


def test_an_expression_that_is_too_long(session: Session) -> None:
    assert code(session, "param x " + "+".join(["1"] * MAX_LENGTH)) == "E1260"


def test_too_many_words(session: Session) -> None:
    assert code(session, "print" + " 1" * 30_000) == "E1260"


def test_commands_within_commands(session: Session) -> None:
    session.run("add_line 0,0 5,0")
    assert code(session, "explain " * 20 + "length L0 5") == "E1252"


def test_too_many_variables(session: Session) -> None:
    session.state.variables.update({f"x{i}": 1.0 for i in range(MAX_VARIABLES)})
    assert code(session, "another = 3") == "E1260"
    session.run("x5 = 3")


@pytest.mark.parametrize("depth", [50, 500, 1990])
def test_deep_nesting(session: Session, depth: int) -> None:
    text = "(" * (depth // 2) + "1" + ")" * (depth // 2)
    if depth <= 64:
        session.run(f"param x {text}")
    else:
        assert code(session, f"param x {text}") == "E0105"


@pytest.mark.parametrize(
    "chain", ["-" * 1500 + "1", "2^" * 900 + "1", "sqrt(" * 60 + "1" + ")" * 60]
)
def test_long_chains_of_operators_end(session: Session, chain: str) -> None:
    try:
        session.run(f"param x {chain}")
    except AraelError as error:
        assert error.diagnostics[0].code.startswith("E")


def test_a_long_chain_of_parameters_is_followed(session: Session) -> None:
    session.run("param p0 1")
    session.run("\n".join(f"param p{i + 1} p{i} + 1" for i in range(500)))
    assert session.document.parameters["p500"].amount.number == 501
    assert code(session, "param p0 p500") == "E1240"


def test_a_parameter_that_doubles_others_ends(session: Session) -> None:
    session.run("add_line 0,0 5,0\nparam p0 L0.length")
    session.run("\n".join(f"param p{i + 1} p{i} * p{i} / p{i}" for i in range(40)))
    with pytest.raises(AraelError):
        from arael.sketch.expressions.gradient import program
        from arael.sketch.expressions.refresh import refresh

        with session.document.transaction("x"):
            refresh(session.document)
        program(session.document, "p40")


def test_an_alias_of_an_alias_is_a_name(session: Session) -> None:
    session.run("a = add_line 0,0 5,0\nb = a\nc = b\nlength c 3")
    assert session.document.dimensions["d0"].args == ("L0",)


STRANGE = [
    "\x00",
    "add_line \x00,0 5,0",
    "add_line nan,0 5,0",
    "add_line inf,0 5,0",
    "add_line 1e400,0 5,0",
    "add_line 0,0 5,0 \u202e",
    "param \u00e9 3",
    "param x __import__('os')",
    "param x ().__class__",
    "x = print",
    "= 3",
    "a,b",
    "a,,b = 3",
    ", = 3",
    "let",
    "let let = 3",
    "_ = 3",
    "_0",
    "print _99999999999999999999",
    "undo 1e300",
    "goto -1",
    "undo nan",
    "save \x00.json",
    "save .json/../../x.json",
    "save ~/x.json",
    "load .",
    "add_point @",
    "add_point @@1,2",
    "add_point ,",
    "add_point 1,,2",
    "add_point (1,2)",
    "print (",
    "print )",
    'print "',
    'print ""',
    "zoom nan",
    "zoom +-",
    "cursor @1,1 2,2",
    "select L0.p1.x",
    "delete all",
    "help help help",
    "explain",
    "what_if",
    "settings unit parsec",
    "find",
    "find 0,0 -1",
    "measure",
    "list list",
    "dof everything",
]


@pytest.mark.parametrize("line", STRANGE)
def test_strange_lines_are_refused_and_change_nothing(session: Session, line: str) -> None:
    session.run("add_line 0,0 5,0; param w 3\nselect L0")
    before, state = to_json(session.document), session.state.copy()
    steps = session.document.history.position
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert all(d.span or d.origin for d in caught.value.diagnostics)
    assert to_json(session.document) == before
    assert session.state == state
    assert session.document.history.position == steps


def test_random_words_are_refused_or_done_without_other_errors(tmp_path: Path) -> None:
    session = Session(folder=tmp_path)
    random_ = random.Random(7)
    text = """
        L0 L1 A0 P0 L0.p1 A0.center d0 C0 M0 w 0,0 5,3 @1,2 cursor @tangent 5 -3 0 1e9 = ; , ( ) +
        * / >= to 'x # _ _0 selection all force driven hv 12 mm 30 deg midpoint(L0) dist(P0,L0)
        normal(L0)*2 L0.length/0 x x.y
    """
    files = {"save", "load", "export", "import"}
    pieces = [*(word for word in table.words() if word not in files), *text.split()]
    judged = {"free", "why", "what_if", "sensitivity", "dof", "cost"}
    pieces = [piece for piece in pieces if piece not in judged]
    session.run("add_line 0,0 5,0; add_circle 2,2 1; add_point 9,9; param w 3")
    for _ in range(1500):
        count = random_.randint(1, 6)
        line = " ".join(random_.choice(pieces) for _ in range(count))
        before = to_json(session.document)
        try:
            session.run(line)
        except AraelError:
            assert to_json(session.document) == before, line


def test_a_thousand_evaluations_are_quick(session: Session) -> None:
    session.run("add_line 0,0 5,0; param w 3")
    from arael.sketch.expressions.evaluation import compiled, number
    from arael.sketch.expressions.scope import DocumentScope

    scope = DocumentScope(session.document)
    number("sqrt(w^2 + L0.length*2) / 3", scope)
    misses = compiled.cache_info().misses
    for _ in range(1000):
        number("sqrt(w^2 + L0.length*2) / 3", scope)
    assert compiled.cache_info().misses == misses


#: Scripts with numbers at the limits: each line is done or refused, without a warning of NumPy.
LIMITS = [
    "add_point 1e308,1e308; add_point -1e308,-1e308; distance P0 P1 driven",
    "add_line 0,0 1e308,1e308; length L0 driven",
    "add_line 0,0 1e99,1e99; length L0 driven",
    "add_circle 0,0 1e200; add_circle 1e200,0 1e200; tangent A0 A1",
    "add_circle 0,0 1; radius A0 1e308",
    "add_circle 0,0 1; radius A0 >= 1e200",
    "add_line 0,0 1e-320,0",
    "add_line 1e16,0 1e16,1; length L0 3",
    "add_rect 0,0 1e-30,1e-30 hv; length L0 1e30",
    "add_line 0,0 4,0; length L0 1e300",
    "add_line 0,0 4,0; length L0 1e-300",
    "add_line 0,0 4,0; scale L0 about 0,0 1e300",
    "add_line 0,0 4,0; rotate L0 about 0,0 1e300",
    "add_line 0,0 4,0; move L0 @1e308,1e308; move L0 @1e308,1e308",
    "add_line 0,0 4,0; drag L0.p1 1e308,1e308",
    "add_line 0,0 4,0; angle L0 L0 1e300",
    "add_slot 0,0 1e308,1e308 1e308",
    "add_ellipse 0,0 1e200 1e-200 1e300",
    "add_ellipse 0,0 3 1e-30 0; add_point 1,1; point_on P0 EA0",
    "add_earc 0,0 5,5 1e300 1e-300 1e300",
    "add_spline 0,0 1e150,0 1e-150,1 5,5; add_point 1,1; point_on P0 S0",
    "add_line 0,0 4,0; pattern rect L0 10000 1e307",
    "find 0,0 1e308",
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("script", LIMITS)
def test_numbers_at_the_limits_end_in_a_message_or_a_sketch(script: str, tmp_path: Path) -> None:
    session = Session(folder=tmp_path)
    for line in [*script.split("; "), "dof", "list", "free", "export drawing.svg", "undo"]:
        try:
            session.run(line)
        except AraelError as error:
            assert all(d.span or d.origin for d in error.diagnostics)
        assert np.isfinite(session.document.values).all()
