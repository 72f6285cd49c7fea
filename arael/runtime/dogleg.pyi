"""Powell's dogleg."""

from arael.runtime.box import Box
from arael.runtime.vectors import Vectors

class Dogleg:
    """Trust region whose steps lie on Powell's dogleg."""

    radius: float
    regularisation: float
    floor: float
    known: bool

    def __init__(self, vectors: Vectors, box: Box, floor: float) -> None: ...
