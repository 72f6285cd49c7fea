"""The degrees of freedom that jacobian_demo counts, against a Jacobian written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.examples.scripts import printed, script

SIDES = [(0, 1), (1, 2), (2, 3), (3, 0)]


def by_hand(p: np.ndarray, lengths: list, nail: bool, level: bool) -> np.ndarray:
    """Rows of lengths, level edge and nail at the corners `p` (4, 2)."""
    rows = []
    for a, b in lengths:
        row = np.zeros((4, 2))
        direction = (p[b] - p[a]) / np.linalg.norm(p[b] - p[a])
        row[b], row[a] = direction, -direction
        rows.append(row.ravel())
    if level:
        rows.append([0, -1, 0, 1, 0, 0, 0, 0])
    if nail:
        rows += [[1, 0, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0, 0, 0]]
    return np.array(rows)


STATES = [
    (SIDES, False, False, 4, ["translation", "translation", "rotation", ""]),
    ([*SIDES, (0, 2)], False, False, 5, ["translation", "translation", "rotation"]),
    ([*SIDES, (0, 2)], True, False, 7, ["rotation"]),
    ([*SIDES, (0, 2)], True, True, 8, []),
    ([*SIDES, (0, 2), (1, 3)], True, True, 8, []),
]


def test_rank_and_freedoms_after_each_dimension() -> None:
    module = script("jacobian_demo")
    for (_, sketch), (lengths, nail, level, rank, kinds) in zip(
        module.steps(), STATES, strict=True
    ):
        expected = by_hand(np.array(sketch.points.p.value), lengths, nail, level)
        jacobian = sketch.jacobian()
        np.testing.assert_allclose(jacobian.dense(), expected, atol=1e-9)
        assert jacobian.rank() == np.linalg.matrix_rank(expected, tol=1e-9) == rank
        values = np.linalg.svd(expected, compute_uv=False)
        np.testing.assert_allclose(jacobian.singular_values(), values, atol=1e-9)
        assert [one.gauge for one in sketch.free_directions()] == kinds
        assert sketch.cost() < 1e-15
        for one in sketch.free_directions():
            assert np.abs(expected @ one.vector).max() < 1e-6


def test_the_dimension_too_many_is_found() -> None:
    module = script("jacobian_demo")
    *_, (_, before), (_, last) = module.steps()
    assert before is last  # one sketch grows; look at its end
    assert [name.split(" at ")[1] for name in module.redundant(last)] == [
        f"lengths[{k}]" for k in range(6)
    ]
    assert list(last.lengths.row) == list(range(6))
    assert list(last.nails.row) == [7]


@pytest.mark.parametrize("line", [
    "four sides: 4 residuals, rank 4 of 8",
    "  free: `points.p` turn together",
    "and the other diagonal: 9 residuals, rank 8 of 8",
    "  7 Nail.nail      residual",
])  # fmt: skip
def test_report(line: str, monkeypatch, capsys) -> None:
    assert line in printed("jacobian_demo", [], monkeypatch, capsys)
