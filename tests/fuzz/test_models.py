"""Mutated models: refused with a useful message, or checked, formatted, loaded and solved."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.fuzz import campaign, corpus
from tests.fuzz.campaign import Input
from tests.fuzz.mutation import mutated_text

pytestmark = pytest.mark.slow


def any_model(rng: random.Random) -> Input:
    """A model of the corpus, with tokens, lines and bytes changed."""
    origin, text = rng.choice(corpus.models())
    others = [rng.choice(corpus.models())[1] for _ in range(3)]
    return Input("model.arael", mutated_text(rng, text, others), origin)


def small_model(rng: random.Random) -> Input:
    """A small model with one or two tokens changed: most are still accepted and solved."""
    number = rng.randrange(len(corpus.SMALL))
    text = corpus.SMALL[number]
    return Input(
        "small.arael", mutated_text(rng, text, corpus.SMALL, 2, gentle=True), f"SMALL[{number}]"
    )


def test_mutated_models(fuzz_seed: int, fuzz_seconds: float, tmp_path: Path) -> None:
    found = campaign.run("models", any_model, fuzz_seed, fuzz_seconds, tmp_path)
    assert not found.failures, str(found)
    assert found.reached("refused") > 0, str(found)


def test_models_with_a_token_changed(fuzz_seed: int, fuzz_seconds: float, tmp_path: Path) -> None:
    found = campaign.run("models", small_model, fuzz_seed, fuzz_seconds, tmp_path)
    assert not found.failures, str(found)
    assert found.reached("solved") > 0, str(found)
