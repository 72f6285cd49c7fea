"""Windows: pages that are open, each with its own cursor, selection and variables."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.sketch.commands.session import State
from arael.sketch.server.differences import changed_offsets
from arael.sketch.server.protocol import frame_message, json_message


class Link(Protocol):
    """The way to a page."""

    @property
    def is_behind(self) -> bool:
        """Whether messages wait to be sent: frames are left out then."""

    def send(self, data: bytes) -> None:
        """Send a message; never blocks, never raises."""


class Actor(Protocol):
    """What runs commands: a window or an agent.

    Attributes
    ----------
    state : its variables, cursor, selection and view
    """

    state: State


@dataclass(eq=False)
class Window:
    """A page that is open.

    Attributes
    ----------
    name : made by the page
    link : the way to it
    state : its variables, cursor, selection and view
    shown : (n,) numbers as the page has them
    sequence : of the newest place of the pointer that was used
    """

    name: str
    link: Link
    state: State = field(default_factory=State)
    shown: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    sequence: int = 0

    def send(self, content: dict[str, Any], revision: int = 0) -> None:
        """Send JSON."""
        self.link.send(json_message(content, revision))

    def send_frame(self, values: NDArray[np.float64], revision: int) -> None:
        """Send the numbers that the page does not have, none if it has all."""
        offsets = changed_offsets(self.shown, values)
        self.shown = values
        self.link.send(frame_message(self.sequence, offsets, values[offsets], revision))
