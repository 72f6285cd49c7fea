"""Random cuts: the pieces make up the whole, references hold, undo brings everything back."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.sketch.geometry import curve_of
from tests.sketch.modify.drawn import measures, run, sketch, state

TARGETS = st.sampled_from(
    [
        "add_line -10,0 10,0",
        "add_circle 0,0 6",
        "add_arc -8,0 8,0 0,5",
        "add_arc -8,0 8,0 0,-5",
        "add_ellipse 0,0 9 4 20",
    ]
)
CUTTERS = st.lists(
    st.tuples(st.floats(-60, 60), st.floats(-5, 5)), min_size=1, max_size=4, unique=True
)


def length(session: object, name: str) -> float:
    document = session.document  # type: ignore[attr-defined]
    return curve_of(document.entities[name].kind, document.numbers_of(name).tolist()).length()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(target=TARGETS, cutters=CUTTERS, where=st.tuples(st.floats(-9, 9), st.floats(-6, 6)))
def test_pieces_add_up(
    target: str, cutters: list[tuple[float, float]], where: tuple[float, float]
) -> None:
    session = sketch(target)
    name = next(iter(session.document.entities))
    if name == "L0":
        session.run("length L0 20; horizontal L0; lock L0.p1; param w L0.length")
    for angle, offset in cutters:
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        ends = [(offset - s * t, c * t) for t in (-15, 15)]
        text = " ".join(f"{x!r},{y!r}" for x, y in ends)
        session.run(f"add_line {text} noconnect")
    before, whole = state(session), length(session, name)
    from arael.diagnostics.records import AraelError

    try:
        reply = run(session, f"split {name} {where[0]!r},{where[1]!r}")
    except AraelError as error:
        assert error.diagnostics[0].code in ("E1281", "E1282")
        assert state(session) == before
        return
    assert sum(length(session, one) for one in reply.names) == pytest.approx(whole, rel=1e-9)
    document = session.document
    for record in (*document.constraints.values(), *document.dimensions.values()):
        for arg in record.args:
            assert arg.partition(".")[0] in document.entities
    if name == "L0":
        assert measures(session, "d0") == pytest.approx(20)
        assert document.parameters["w"].amount.number == pytest.approx(20)
    document.undo()
    assert state(session) == before
    reply = run(session, f"trim {name} {where[0]!r},{where[1]!r}")
    rest = sum(length(session, one) for one in reply.names)
    assert rest < whole
    document.undo()
    assert state(session) == before
    document.redo()
    assert sum(length(session, one) for one in reply.names) == pytest.approx(rest, rel=1e-12)
