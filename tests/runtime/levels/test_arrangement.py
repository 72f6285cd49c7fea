"""Rows by component and order of elimination, against SciPy; orders that are kept."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from arael.runtime.levels.structure import Structure, analyse

RANDOM = np.random.default_rng(11)


def pattern(rows: list[list[int]]) -> tuple[np.ndarray, np.ndarray]:
    indptr = np.concatenate([[0], np.cumsum([len(row) for row in rows])]).astype(np.int32)
    return indptr, np.array([k for row in rows for k in row], dtype=np.int32)


def random_rows(m: int, n: int) -> list[list[int]]:
    return [
        sorted(RANDOM.choice(n, min(n, int(RANDOM.integers(1, 4))), replace=False).tolist())
        for _ in range(m)
    ]


def check(
    found: Structure, rows: list[list[int]], n: int, free: np.ndarray, active: np.ndarray
) -> None:
    """Compare with definitions."""
    indptr, indices = pattern(rows)
    assert sorted(found.row_of.tolist()) == np.flatnonzero(active).tolist()
    for p, row in enumerate(found.row_of.tolist()):
        own = found.unknown[found.start[p] : found.start[p + 1]].tolist()
        assert own == [k for k in rows[row] if free[k]]
        assert indices[found.source[found.start[p] : found.start[p + 1]]].tolist() == own
        assert all(indptr[row] <= s < indptr[row + 1] for s in found.source[found.start[p]:
                   found.start[p + 1]])  # fmt: skip
    dense = np.zeros((len(found.row_of), n))
    for p in range(len(found.row_of)):
        dense[p, found.unknown[found.start[p] : found.start[p + 1]]] = 1.0
    for u in range(n):
        of = slice(found.column_start[u], found.column_start[u + 1])
        assert found.column_position[of].tolist() == np.flatnonzero(dense[:, u]).tolist()
        assert (found.unknown[found.column_entry[of]] == u).all()
    # Components, in the order of their first row.
    graph = csr_array(dense)
    both = csr_array(np.block([[np.zeros((len(dense),) * 2), dense],
                               [dense.T, np.zeros((n, n))]]))  # fmt: skip
    label = connected_components(both, directed=False)[1]
    mine = np.repeat(np.arange(len(found.component_start) - 1), np.diff(found.component_start))
    for part in range(len(found.component_start) - 1):
        assert len(set(label[: len(dense)][mine == part].tolist())) == 1
    firsts = [found.row_of[mine == part].min() for part in range(mine.max(initial=-1) + 1)]
    assert firsts == sorted(firsts)
    assert len(set(label[: len(dense)].tolist())) == len(firsts)
    for u in range(n):
        positions = np.flatnonzero(dense[:, u])
        assert found.component_of[u] == (mine[positions[0]] if len(positions) else -1)
    for part in range(len(firsts)):
        listed = found.unknown_list[found.unknown_start[part] : found.unknown_start[part + 1]]
        assert listed.tolist() == np.flatnonzero(found.component_of == part).tolist()
    # L has at least the pattern of J J' below the diagonal.
    product = (graph @ graph.T).toarray() != 0
    for p in range(len(dense)):
        below = set(found.factor_row[found.factor_start[p] : found.factor_start[p + 1]].tolist())
        assert set((np.flatnonzero(product[p, p + 1 :]) + p + 1).tolist()) <= below


@pytest.mark.parametrize("seed", range(12))
def test_rows_are_arranged_by_component_and_order(seed: int):
    m, n = (int(k) for k in RANDOM.integers(1, 40, 2))
    rows = random_rows(m, n)
    free, active = RANDOM.random(n) < 0.8, RANDOM.random(m) < 0.8
    check(analyse(n, *pattern(rows), free, active), rows, n, free, active)


def test_an_order_is_kept_when_rows_come_and_go():
    n = 30
    rows = [[k, k + 1] for k in range(20)]
    everything = np.ones(n, dtype=bool)
    first = analyse(n, *pattern(rows), everything, np.ones(20, dtype=bool))
    rows += [[3, 25], [25, 26]]
    active = np.ones(22, dtype=bool)
    active[5] = False
    second = analyse(n, *pattern(rows), everything, active, None, first)
    check(second, rows, n, everything, active)
    assert second.ordered == first.ordered
    old = [row for row in first.row_of.tolist() if row in second.row_of and row < 5]
    new = [row for row in second.row_of.tolist() if row < 5]
    assert new == old


def test_a_new_order_is_found_when_the_factor_fills_up():
    n = 40
    rows = [[k] for k in range(30)]
    everything = np.ones(n, dtype=bool)
    first = analyse(n, *pattern(rows), everything, np.ones(30, dtype=bool))
    # The unknown that all rows get would fill L where its row comes first.
    rows = [[k, 35] for k in range(30)]
    second = analyse(n, *pattern(rows), everything, np.ones(30, dtype=bool), None, first)
    assert second.ordered != first.ordered


def test_a_new_order_is_found_for_twice_as_many_rows():
    rows = [[k, k + 1] for k in range(25)]
    everything = np.ones(30, dtype=bool)
    first = analyse(30, *pattern(rows[:12]), everything, np.ones(12, dtype=bool))
    second = analyse(30, *pattern(rows), everything, np.ones(25, dtype=bool), None, first)
    assert second.ordered[0] == 25


def test_guards_join_components():
    rows = [[0, 1], [2, 3]]
    everything = np.ones(4, dtype=bool)
    links = pattern([[1, 2]])
    found = analyse(4, *pattern(rows), everything, np.ones(2, dtype=bool), links)
    assert found.component_start.tolist() == [0, 2]
    assert found.component_of.tolist() == [0, 0, 0, 0]
    held = np.array([True, False, True, True])
    found = analyse(4, *pattern(rows), held, np.ones(2, dtype=bool), links)
    assert found.component_of.tolist() == [0, -1, 1, 1]
