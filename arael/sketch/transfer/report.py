"""What a transfer of references did, by name."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(slots=True)
class Transfer:
    """Names of the records that followed, were copied, left out or dropped.

    Attributes
    ----------
    added : constraints and dimensions that are new
    moved : those that refer to something else now, with their old name where that changed
    copied : new name -> the record it is a copy of
    implied : copies that were left out because they follow from others, as text
    dropped : name -> why it could not follow
    rewritten : dimensions and parameters with other expressions
    dissolved : groups that lost a part
    broken : dimensions and parameters whose expressions have no value now
    """

    added: list[str] = field(default_factory=list)
    moved: dict[str, str] = field(default_factory=dict)
    copied: dict[str, str] = field(default_factory=dict)
    implied: list[str] = field(default_factory=list)
    dropped: dict[str, str] = field(default_factory=dict)
    rewritten: list[str] = field(default_factory=list)
    dissolved: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)

    @property
    def data(self) -> dict[str, Any]:
        """The same for programs."""
        return {
            "added": list(self.added),
            "moved": list(self.moved),
            "copied": dict(self.copied),
            "implied": list(self.implied),
            "dropped": dict(self.dropped),
            "rewritten": list(self.rewritten),
            "dissolved": list(self.dissolved),
            "broken": list(self.broken),
        }
