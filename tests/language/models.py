"""Making models of texts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import arael


def loaded(folder: Path, text: str, **more: str) -> Any:
    """The model of a text on the expression machine; `more` are files beside it by their stem."""
    for name, other in more.items():
        (folder / f"{name}.arael").write_text(other)
    path = folder / "model.arael"
    path.write_text(text)
    return arael.load(path, interpret=True)


def refusal(folder: Path, text: str, **more: str) -> Any:
    """The first diagnostic of a model that is wrong."""
    try:
        loaded(folder, text, **more)
    except arael.AraelError as error:
        return error.diagnostics[0]
    raise AssertionError("nothing was found wrong")
