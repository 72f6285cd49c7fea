"""Mutated data files: refused with the model as it was, or read, written and read as the same."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.fuzz import campaign, data_files
from tests.fuzz.campaign import Draw, Input
from tests.fuzz.mutation import mutated_archive, mutated_columns, mutated_json

pytestmark = pytest.mark.slow


def _json(rng: random.Random) -> Input:
    return Input(
        "scene.json", mutated_json(rng, data_files.SCENE, rng.choice([1, 1, 3])), "scene.json"
    )


def _npz(rng: random.Random) -> Input:
    name = "scene.npz"
    return Input(name, mutated_archive(rng, data_files.originals()[name]), name)


def _columns(*names: str) -> Draw:
    def draw(rng: random.Random) -> Input:
        name = rng.choice(names)
        return Input(name, mutated_columns(rng, data_files.originals()[name]), name)

    return draw


KINDS = {
    "json": _json,
    "npz": _npz,
    "csv": _columns("pairs.csv"),
    "g2o": _columns("g2o2.g2o", "g2o3.g2o"),
    "bal": _columns("bal.bal"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_mutated_files(kind: str, fuzz_seed: int, fuzz_seconds: float, tmp_path: Path) -> None:
    found = campaign.run("data_files", KINDS[kind], fuzz_seed, fuzz_seconds / 2, tmp_path)
    assert not found.failures, str(found)
    assert found.reached("read") > 0, str(found)
    assert found.reached("refused") > 0, str(found)
