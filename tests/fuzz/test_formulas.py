"""Mutated formulas: refused with a useful message, or calculated, differentiated and fitted."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.fuzz import campaign, corpus
from tests.fuzz.campaign import Input
from tests.fuzz.mutation import mutated_text

pytestmark = pytest.mark.slow


def formula(rng: random.Random) -> Input:
    """A formula with one to four changes."""
    text = rng.choice(corpus.FORMULAS)
    return Input(
        "formula.txt", mutated_text(rng, text, corpus.FORMULAS, gentle=rng.random() < 0.6), text
    )


def test_mutated_formulas(fuzz_seed: int, fuzz_seconds: float, tmp_path: Path) -> None:
    found = campaign.run("formulas", formula, fuzz_seed, fuzz_seconds, tmp_path)
    assert not found.failures, str(found)
    assert found.reached("calculated solved") > 0, str(found)
