"""Initial values of pose graphs, computed from their measurements."""

from arael.starts.choose import WAYS, How, Start, can_initialise, initialise

__all__ = ["WAYS", "How", "Start", "can_initialise", "initialise"]
