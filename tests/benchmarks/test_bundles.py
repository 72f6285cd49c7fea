"""Generated bundles: near the noise at the optimum, and no camera sees what is behind it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import arael
from benchmarks.bundles import write_bundle


def sightings(path: Path) -> np.ndarray:
    """Camera and point (k, 2) of the file's observations."""
    lines = path.read_text().splitlines()
    count = int(lines[0].split()[2])
    return np.array([[int(word) for word in line.split()[:2]] for line in lines[1 : 1 + count]])


def test_a_bundle_is_solved_down_to_its_noise(tmp_path: Path) -> None:
    path = tmp_path / "bundle.txt"
    seen = write_bundle(path, cameras=12, points=200)
    bundle = arael.load("bundle_adjustment")()
    bundle.read(path, "bal")
    assert len(bundle.cameras) == 12
    assert len(bundle.observations) == seen
    points = len(bundle.points)
    assert np.bincount(sightings(path)[:, 1], minlength=points).min() >= 2
    start = bundle.cost()
    result = bundle.solve()
    # Pixels have a variance of one; seven directions are free.
    freedom = 2 * seen - (9 * 12 + 3 * points - 7)
    assert start > 10 * freedom
    assert abs(result.cost / freedom - 1) < 5 * np.sqrt(2 / freedom)


def test_no_pair_of_camera_and_point_is_there_twice(tmp_path: Path) -> None:
    path = tmp_path / "bundle.txt"
    write_bundle(path, cameras=7, points=300, seed=1)
    pairs = sightings(path)
    assert len(np.unique(pairs, axis=0)) == len(pairs)


def test_a_seed_gives_one_bundle(tmp_path: Path) -> None:
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        write_bundle(tmp_path / name, cameras=5, points=40, seed=seed)
    first, again, other = ((tmp_path / name).read_text() for name in "abc")
    assert first == again
    assert first != other
