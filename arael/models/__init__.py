"""The standard models, compiled: ``from arael.models import slam``."""

from __future__ import annotations

from arael.loading import load, standard_models
from arael.model import Model


def __getattr__(name: str) -> type[Model]:
    """Load the standard model of that name on first use."""
    if name.startswith("_") or name not in standard_models():
        raise AttributeError(f"arael has no standard model {name!r}")
    found = load(name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *standard_models()])
