"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

from arael.runtime.natives import NativeTable

class Raised:
    """The first exception of the interpreter or of a native function in Python."""

    any: bool
    error: BaseException | None
    natives: NativeTable

    def __init__(self, natives: NativeTable) -> None: ...
    def again(self) -> None: ...
