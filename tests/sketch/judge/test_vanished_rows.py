"""Equations whose derivatives cancel out hold nothing, whatever rounding leaves of them."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.runtime.orthogonal import RankQR
from arael.sketch.commands.session import Session


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("first", ["coincident", "point_on"])
def test_a_point_on_a_line_that_ends_there_takes_no_freedom(seed: int, first: str) -> None:
    a, b, c = np.random.default_rng(seed).uniform(-10, 10, (3, 2)).tolist()
    session = Session()
    session.run(f"add_line {a[0]},{a[1]} {b[0]},{b[1]}")
    session.run(f"add_line {b[0]},{b[1]} {c[0]},{c[1]} noconnect")
    second = "point_on" if first == "coincident" else "coincident"
    words = {"coincident": "coincident L1.p1 L0.p2", "point_on": "point_on L1.p1 L0 force"}
    session.run(words[first])
    session.run(words[second])
    session.run("lock L0.p1; length L0 5; length L1 6; xangle L1 40")
    assert session.editor.judge.freedoms().total == 1
    session.run("xangle L0 20")
    assert session.editor.judge.freedoms().total == 0


def test_it_is_refused_as_redundant() -> None:
    session = Session()
    session.run("add_line 0,0 4.1,1.3; add_line 4.1,1.3 7.7,5.9")
    with pytest.raises(AraelError) as refused:
        session.run("point_on L1.p1 L0")
    assert refused.value.diagnostics[0].code == "E1230"


def test_a_line_through_its_own_fixed_end_is_not_frozen() -> None:
    session = Session()
    session.run("add_point 0,0 noconnect; lock P0")
    session.run("add_line -1e-13,1300 -2e-15,4e-13 noconnect; vertical L0.p1 P0")
    session.run("point_on P0 L0; coincident L0.p2 P0")
    assert session.editor.judge.freedoms().total == 1
    session.run("length L0 1000")
    assert session.document.numbers_of("L0")[1] == pytest.approx(1000)
    session.run("delete d0; drag L0.p1 0,1100")
    assert session.document.numbers_of("L0")[1] == pytest.approx(1100)


def test_short_rows_are_not_scaled_up() -> None:
    rounding = np.array([3e-17, -1e-16])
    found = RankQR(2, 2, [0, 2, 4], [0, 1, 0, 1])
    found.factor([1.0, 1.0, *rounding], scale=np.ones(2))
    assert found.rank == 2  # by itself it may be an equation of this size
    found.factor([1.0, 1.0, *rounding], scale=np.ones(2), shortest=0.5)
    assert (found.rank, found.dependent.tolist()) == (1, [1])
    assert found.dependency_of([0, 1], rounding).remainder < found.tolerance
    found.factor([1.0, 1.0, 1e-6, -1e-6], scale=np.ones(2), shortest=0.5)
    assert found.rank == 2
    with pytest.raises(ValueError, match="shortest length of at least 0"):
        found.factor([1.0, 1.0, 1.0, 1.0], scale=np.ones(2), shortest=-1.0)


def test_the_sentences_on_what_is_partly_redundant() -> None:
    def reply(*lines: str) -> list[str]:
        session = Session()
        for line in lines:
            found = session.run(line)[-1].text.splitlines()
        return found[1:]

    mirrored = (
        "add_line 0,0 0,10 noconnect; add_line 2,1 6,3 noconnect; add_line -2,1 -6,3 noconnect",
        "fix L0; symmetry L1 L0 L2",
    )
    ends = "symmetry L1.p1 L0 L2.p1"
    assert reply(*mirrored, ends) == [
        f"notice: `{ends}` takes 1 of its 2 degrees of freedom: the other follows from `C1`"
    ]
    straight = "add_line 0,0 5,0; add_line 5,0 10,0; length L0 5; length L1 5"
    assert reply(straight, "hdistance L0.p1 L1.p2 10") == [
        "notice: `hdistance L0.p1 L1.p2 10` takes no degree of freedom in this position, only when "
        "the geometry is moved"
    ]
    # Nothing is said where each equation takes a freedom.
    assert reply(straight, "point_on L1.p2 L0") == []


def test_what_is_partly_redundant_is_not_listed_as_redundant() -> None:
    session = Session()
    session.run("add_line 0,0 0,10 noconnect; add_line 2,1 6,3 noconnect; fix L0")
    session.run("add_line -2,1 -6,3 noconnect; symmetry L1 L0 L2; symmetry L1.p1 L0 L2.p1")
    found = session.editor.judge.freedoms()
    assert (found.total, found.redundant) == (5, ())


@pytest.mark.parametrize(
    "lines",
    [
        "add_line 0,0 5,0.1; horizontal L0; xangle L0 180",
        "add_line 0,0 5,0; add_line 0,1 4,3; parallel L0 L1; angle L0 L1 180",
    ],
)
def test_what_only_the_side_forbids_is_said_to_be_on_the_other_side(lines: str) -> None:
    with pytest.raises(AraelError) as refused:
        Session().run(lines)
    assert refused.value.diagnostics[0].code == "E1233"
