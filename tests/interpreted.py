"""Models from texts on the expression machine, for tests in which kernels are not the point."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import arael
from arael.model import Model

Load = Callable[..., type[Model]]


def loader(folder: Path) -> Load:
    """Return a function that loads a model's text, each once; its files are written to `folder`."""
    loaded: dict[tuple[str, str], type[Model]] = {}

    def load(text: str, precision: str = "f64") -> type[Model]:
        key = (text, precision)
        if key not in loaded:
            path = folder / f"m{len(loaded)}.arael"
            path.write_text(text, encoding="utf-8")
            loaded[key] = arael.load(path, precision=precision, interpret=True)  # type: ignore[arg-type]
        return loaded[key]

    return load
