"""A compiled kernel of a single group, from another module than that of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class GroupKernel:
    """Kernel `number` of the table in `capsule`, ``arael.kernels`` of a generated module."""

    capsule: Any
    number: int
