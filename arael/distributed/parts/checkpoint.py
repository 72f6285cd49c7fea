"""The state of a solve in parts on disk, from which it goes on when the cluster is lost."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.compiled_model import CompiledModel
from arael.diagnostics.records import AraelError, Diagnostic
from arael.io import npz
from arael.io.files import write_whole
from arael.runtime.layout import to_json

Floats = NDArray[np.float64]

_VERSION = 1
_PLAIN = ("version", "turn", "attempts", "damping", "radius", "cost", "print", "x", "base")


@dataclass(frozen=True)
class Checkpoint:
    """An accepted state.

    Attributes
    ----------
    mark : what the problem is recognised by (`mark_of`)
    turn : number of the pass
    attempts : attempts of this pass so far
    damping, radius, cost : of the loop, after the last attempt
    x : stored scalars of all rows with parameters
    base : the same at the beginning of the pass
    """

    mark: str
    turn: int
    attempts: int
    damping: float
    radius: float
    cost: float
    x: Floats
    base: Floats

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file whole; the one before stays until then."""
        arrays: dict[str, Any] = {
            "version": np.array(_VERSION),
            "print": np.array(self.mark),
            "turn": np.array(self.turn),
            "attempts": np.array(self.attempts),
            "damping": np.array(self.damping),
            "radius": np.array(self.radius),
            "cost": np.array(self.cost),
            "x": self.x,
            "base": self.base,
        }
        write_whole(path, lambda file: np.savez(file, **arrays))


def read(path: str | os.PathLike[str], mark: str) -> Checkpoint:
    """The checkpoint of a file.

    Raises
    ------
    AraelError
        E0897: no file, damaged, or of another model or other data.
    """
    name = os.fspath(path)
    try:
        with np.load(name, allow_pickle=False) as found:
            values = {key: found[key] for key in _PLAIN}
    except FileNotFoundError:
        raise _wrong(name, "there is no such file", "leave `--resume` out to begin") from None
    except (*npz.DAMAGED, AttributeError):
        raise _wrong(name, "it is damaged, or no checkpoint", "begin without it") from None
    if str(values["print"]) != mark or int(values["version"]) != _VERSION:
        raise _wrong(
            name, "it is of another model or other data", "resume with what it was written for"
        )
    return Checkpoint(
        mark,
        int(values["turn"]),
        int(values["attempts"]),
        float(values["damping"]),
        float(values["radius"]),
        float(values["cost"]),
        values["x"],
        values["base"],
    )


def _wrong(name: str, why: str, help_: str) -> AraelError:
    message = f"the solve cannot go on from the checkpoint: {why}"
    return AraelError(Diagnostic("E0897", message, origin=name, help=(help_,)))


def mark_of(compiled: CompiledModel, x: Floats, counts: dict[str, int]) -> str:
    """A digest of the model, the start and the number of rows."""
    found = hashlib.sha256(to_json(compiled.layout))
    found.update(repr(sorted(counts.items())).encode())
    found.update(np.ascontiguousarray(x).tobytes())
    return found.hexdigest()
