"""Rank of sketches' equations against singular values."""

from __future__ import annotations

import random

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.judge.rank import Rank
from arael.sketch.layout.layout import Linearisation

CHAIN = """
add_line 0,0 6,0
add_arc 6,0 10,4 8.82842712,1.17157288
add_line 10,4 14,4
add_point -15,-9
"""

SOURCES = (
    CHAIN,
    "add_line 0,0 10,0 10,6 4,9\nadd_point -15,-9",
    "add_rect 0,0 10,6\nfillet L0 L1 L1 L2 L2 L3 L3 L0 1\nadd_point -15,-9",
    "add_rect 0,0 10,6 hv\nlength L0 10\nadd_point -15,-9",
    "add_circle 3,3 2\nadd_line 8,0 8,5\nadd_point -15,-9",
    "add_arc 0,0 5,1 3,2\nadd_arc 5,1 9,1 7,-1\nadd_point -15,-9",
)


def ranks(session: Session) -> tuple[int, int]:
    """Rank as the judge finds it, and by singular values of the matrix with rows of length 1."""
    session.editor.layout.refresh()
    judge = session.editor.judge
    system = judge.layout.linearisation()
    m, n = len(system.residuals), len(system.x)
    found = n - judge.freedoms().total
    matrix = np.zeros((m, n))
    rows = np.repeat(np.arange(m), np.diff(system.indptr))
    np.add.at(matrix, (rows, system.indices), system.entries)
    lengths = np.linalg.norm(matrix, axis=1)
    values = np.linalg.svd(matrix / np.where(lengths > 0, lengths, 1.0)[:, None])[1]
    return found, int((values > 1e-12 * values.max(initial=1.0)).sum())


def test_a_row_that_follows_through_a_tiny_multiplier_is_no_freedom_less() -> None:
    session = Session()
    session.run(f"{CHAIN}pattern circular L0 A0 L1 about P0 2")
    freedoms = session.editor.judge.freedoms()
    assert freedoms.total == 10
    # The image of which it is an equation holds others, too.
    assert freedoms.redundant == ()


def _matrix(rows: list[list[float]]) -> Rank:
    matrix = np.array(rows)
    m, n = matrix.shape
    return Rank(
        Linearisation(
            x=np.zeros(n),
            residuals=np.zeros(m),
            indptr=np.arange(0, m * n + 1, n, dtype=np.int32),
            indices=np.tile(np.arange(n, dtype=np.int32), m),
            entries=matrix.ravel(),
            rows=np.arange(m),
            names=[""] * m,
        )
    )


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1), (2, 1, 0), (1, 2, 0)])
@pytest.mark.parametrize("near", [1e-4, 1e-7, 1e-9, 1e-11])
def test_nearly_dependent_rows_count_unless_a_later_one_makes_them_exact(
    near: float, order: tuple[int, ...]
) -> None:
    one, other = np.array([1.0, 2.0, -1.0, 0.5]), np.array([0.3, -1.0, 2.0, 1.0])
    rows = [one, one + near * other, other]
    assert _matrix([rows[k].tolist() for k in order]).free == 2
    assert _matrix([one.tolist(), (one + near * other).tolist()]).free == 2


def _step(chance: random.Random, session: Session) -> str:
    document = session.document
    names = [n for n, e in document.entities.items() if e.kind in ("line", "arc", "circle")]
    some = " ".join(sorted(chance.sample(names, min(len(names), chance.randint(1, 3)))))
    line = chance.choice([n for n, e in document.entities.items() if e.kind == "line"] or names)
    d = round(chance.uniform(0.1, 1.5), 2)
    return chance.choice(
        [
            f"pattern circular {some} about P0 {chance.randint(2, 4)}",
            f"pattern rect {some} {chance.randint(2, 3)} {20 * d:g}",
            f"mirror {some} about {line}",
            f"offset sequence {names[0]} {d}",
            f"offset sequence {names[0]} {d} symmetric caps round",
            f"length {line} driven",
            f"lock {names[0]}.p1",
        ]
    )


@pytest.mark.sweep(5)
@pytest.mark.parametrize("seed", range(150))
def test_the_rank_is_that_of_the_singular_values(seed: int) -> None:
    chance = random.Random(seed)
    session = Session()
    session.run(SOURCES[seed % len(SOURCES)])
    for _ in range(3):
        step = _step(chance, session)
        try:
            session.run(step)
        except AraelError:
            continue
        found, wanted = ranks(session)
        assert found == wanted, step
