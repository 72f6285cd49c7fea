"""Classes of points that are tied, against a graph library's connected components."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from arael.sketch.layout.places import Places


def test_random_ties_and_their_removal() -> None:
    rng = np.random.default_rng(7)
    places, ties = Places(), {}
    for step in range(600):
        if ties and rng.random() < 0.45:
            name = list(ties)[rng.integers(len(ties))]
            places.untie(name)
            del ties[name]
        else:
            a, b = (int(k) for k in rng.integers(0, 25, 2))
            ties[f"C{step}"] = (a, b)
            places.tie(f"C{step}", a, b)
        pairs = np.array(list(ties.values()), dtype=int).reshape(-1, 2)
        graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(25, 25))
        count, label = connected_components(graph, directed=False)
        for point in range(25):
            assert set(places.members(point)) == set(np.flatnonzero(label == label[point]))
        assert len(ties) - len(places.spare) == 25 - count


def test_the_earlier_tie_is_the_one_that_counts() -> None:
    places = Places()
    places.tie("C5", 1, 2)
    places.tie("C3", 1, 2)
    assert places.spare == {"C5"}


def test_a_place_starts_from_the_point_with_more_users() -> None:
    places = Places()
    places.tie("C0", 1, 2, (1, 5))
    assert places.of(1).source == 2
    places.tie("C1", 2, 3, (5, 1))
    assert places.of(3).source == 2


def test_what_is_torn_apart_is_reported() -> None:
    places = Places()
    places.tie("C0", 1, 2)
    places.tie("C1", 2, 3)
    places.touched.clear()
    places.untie("C0")
    assert 1 in places.touched
    assert places.of(1) is None
    assert set(places.members(2)) == {2, 3}
