"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

from arael.runtime.evaluation.natives import NativeTable
from arael.runtime.parallel.kept import Kept

class Raised(Kept):
    """The first exception of a native function in Python."""

    natives: NativeTable

    def __init__(self, natives: NativeTable) -> None: ...
