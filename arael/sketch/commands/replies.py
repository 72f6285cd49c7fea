"""What a command answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Reply:
    """What a command did or found.

    Attributes
    ----------
    text : for people; several lines are separated by line ends
    names : what it created, in order: assigned by ``a, b = ...``, and kept as ``_0``, ``_1``, ...
    main : what ``_`` stands for afterwards; empty for the first of `names`
    remembered : whether ``_``, ``_0``, ... are set; not by dimensions, constraints and questions
    data : the same facts for programs, of what JSON has
    leaves : whether the session ends
    """

    text: str = ""
    names: tuple[str, ...] = ()
    main: str = ""
    remembered: bool = True
    data: Mapping[str, Any] = field(default_factory=dict)
    leaves: bool = False
