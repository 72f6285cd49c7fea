"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

from arael.runtime.evaluation.natives import NativeTable

class Kept:
    """The first exception that code without a way to raise met."""

    any: bool
    error: BaseException | None

    def again(self) -> None: ...

class Raised(Kept):
    """The first exception of the interpreter or of a native function in Python."""

    natives: NativeTable

    def __init__(self, natives: NativeTable) -> None: ...
