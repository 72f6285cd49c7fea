"""Whether a pattern has the blocks that are coupled, so that it is kept."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.runtime.assembly.compiled import has_blocks
from arael.runtime.assembly.pattern import BlockPattern

CHAIN = """
struct Point {
    param x: real
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    d: real
    constraint tie { b.x - a.x - d }
}
root Chain {
    points: list of Point
    links: arena of Link
}
"""


def _pattern(pairs: list[tuple[int, int]], blocks: int = 6) -> BlockPattern:
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return BlockPattern.from_pairs(np.full(blocks, 2, np.int64), rows, columns)


def _keys(pairs: list[tuple[int, int]], blocks: int = 6) -> np.ndarray:
    return np.sort(np.array([min(p) * blocks + max(p) for p in pairs], dtype=np.int64))


@pytest.mark.parametrize("seed", range(20))
def test_a_pattern_has_the_blocks_that_it_was_built_from(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = [(int(a), int(b)) for a, b in rng.integers(0, 6, (int(rng.integers(0, 9)), 2))]
    pattern = _pattern(pairs)
    assert has_blocks(pattern, _keys(pairs))
    assert has_blocks(pattern, _keys([*pairs, *pairs[:2], (3, 3)]))
    others = {(a, b) for a in range(6) for b in range(a)} - {(max(p), min(p)) for p in pairs}
    for more in others:
        assert not has_blocks(pattern, _keys([*pairs, more]))
    for fewer in {p for p in pairs if p[0] != p[1]}:
        left = [p for p in pairs if set(p) != set(fewer)]
        assert not has_blocks(pattern, _keys(left))


def test_rows_between_coupled_entities_keep_the_pattern() -> None:
    model = arael.loads(CHAIN, interpret=True)()
    model.points.extend(x=np.arange(5.0))
    model.points[0].x.fixed = True
    model.links.extend(a=np.arange(4), b=np.arange(1, 5), d=np.full(4, 1.5))
    model.solve()
    first = model.session.earlier.structure
    extra = model.links.append(a=model.points[2], b=model.points[3], d=1.1)
    model.solve()
    second = model.session.earlier.structure
    assert second is not first
    assert second.pattern is first.pattern
    second.plan.check()
    assert model.points[3].x - model.points[2].x == pytest.approx(1.3)
    model.links.remove(extra)
    model.solve()
    assert model.session.earlier.structure.pattern is first.pattern
    model.links.append(a=model.points[1], b=model.points[4], d=4.5)
    model.solve()
    assert model.session.earlier.structure.pattern is not first.pattern
    assert model.session.counts.analyses == 2
