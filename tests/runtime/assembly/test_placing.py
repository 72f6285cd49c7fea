"""Where contributions go: the compiled routine against a plain one, instance by instance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.assembly.compiled import placed_pairs, used_rows
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.layout import pair_of

MODEL = """
struct Point {
    param pos: vec2
    param scale: real
    on: bool = true
    constraint keep when on { (pos - pos.value) * scale }
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    constraint near { [norm2(a.pos - b.pos) - root.size, a.scale * b.scale] }
    constraint apart { [a.scale - 1, b.scale - 2] }
}
root Net {
    param size: real
    points: list of Point
    links: list of Link
}
"""


@pytest.fixture(scope="module")
def net(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("models") / "net.arael"
    path.write_text(MODEL, encoding="utf-8")
    model = arael.load(path, interpret=True)(size=1.0)
    rng = np.random.default_rng(4)
    model.points.extend(pos=rng.normal(size=(9, 2)), scale=1.0, on=rng.random(9) < 0.7)
    for a, b in rng.integers(0, 9, (14, 2)):
        model.links.append(a=model.points[int(a)], b=model.points[int(b)])  # a == b among them
    model.links.append(a=model.points[2], b=model.points[2])
    model.points[4].pos.fixed = True
    model.points[4].scale.fixed = True
    for k in range(6):
        text = f"points[{k}].pos.x * points[{k + 1}].scale - p{k} * size"
        model.residuals.add(text, label=f"r{k}", parameters={f"p{k}": 0.5})
    model.residuals.add("a.pos - [2, 2]", label="every", entities={"a": model.points})
    return model


def blocks_of_values(pattern: BlockPattern) -> dict[tuple[int, int], int]:
    """Offset of each block (row, column)."""
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    return {
        (int(i), int(j)): int(at)
        for i, j, at in zip(pattern.rows, columns, pattern.value_start, strict=True)
    }


def test_contributions_go_to_the_blocks_of_what_is_used(net: Any) -> None:
    problem = net._problem()
    structure, pattern = problem.structure, problem.structure.pattern
    places = blocks_of_values(pattern)
    coupled = {(i, i) for i in range(pattern.block_count)}
    assert len(structure.placements) == len(problem.layout.groups) == 10
    for group, ways, placement in zip(
        problem.layout.groups, structure.slot_rows, structure.placements, strict=True
    ):
        together = {
            (a, b) for r, a, _ in group.jacobian for s, b, _ in group.jacobian if r == s
        } | {(a, a) for a in range(len(group.uses))}
        for k in range(len(ways[0])):
            blocks = []
            for u, use in enumerate(group.uses):
                row = ways[use.slot][k]
                of = structure.system.blocks[use.entity]
                blocks.append(int(of.block[row]))
                assert placement.rows[k, u] == row
                moves = of.first[row] >= 0
                expected = of.first[row] if moves else structure.system.size
                assert placement.gradient_at[k, u] == expected
            for a, i in enumerate(blocks):
                for b, j in enumerate(blocks[: a + 1]):
                    at = placement.block_at[k, pair_of(a, b)]
                    turn = placement.turn[k, pair_of(a, b)]
                    if (a, b) not in together or i < 0 or j < 0:
                        assert (at, turn) == (pattern.value_count, 0)
                        continue
                    coupled.add((max(i, j), min(i, j)))
                    assert at == places[max(i, j), min(i, j)]
                    assert turn == (0 if a == b else 2 if i == j else 1 if i < j else 0)
    assert coupled == set(places)


@pytest.mark.parametrize("by_rows", [False, True])
def test_a_pattern_has_each_pair_once_and_its_values_without_gaps(by_rows: bool) -> None:
    rng = np.random.default_rng(3)
    sizes = rng.integers(0, 5, 30)
    pairs = rng.integers(0, 30, (200, 2))
    pattern = BlockPattern.from_pairs(sizes, pairs[:, 0], pairs[:, 1], by_rows=by_rows)
    places = blocks_of_values(pattern)
    expected = {(int(max(p)), int(min(p))) for p in pairs} | {(i, i) for i in range(30)}
    assert set(places) == expected
    assert len(pattern.rows) == len(expected)
    order = sorted(places) if by_rows else sorted(places, key=lambda block: block[::-1])
    end = 0
    for i, j in order:
        assert places[i, j] == end
        end += int(sizes[i] * sizes[j])
    assert pattern.value_count == end


def test_rows_out_of_range_and_blocks_that_are_missing_are_refused() -> None:
    pattern = BlockPattern.from_pairs(np.array([2, 2]), np.zeros(0, int), np.zeros(0, int))
    both = np.ones(3, dtype=np.uint8)
    with pytest.raises(ValueError, match="lacks a block"):
        placed_pairs(np.array([[0, 1]]), both, pattern, pattern.value_count)

    class Blocks:
        first = block = np.arange(2)

    with pytest.raises(IndexError, match="row 2 of 2"):
        used_rows([np.array([0, 2])], [Blocks], 2, 9)
